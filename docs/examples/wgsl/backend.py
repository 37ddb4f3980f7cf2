"""A backend in WGSL, through wgpu-py: on a GPU, or on Mesa's software driver.

    pip install '.[shader]'
    restir check docs/examples/wgsl/backend.py

The environment variable ``RESTIR_ADAPTER`` picks an adapter by a part of its name, and
``RESTIR_PLANT`` plants a mistake; ``python backend.py`` lists both, and with
``--list-plants`` the mistakes alone.
"""

import math
import os
import sys
from functools import partial
from pathlib import Path

import numpy as np

RECEIVER = ("visible_position", "visible_normal", "albedo")
SAMPLE = ("position", "normal", "radiance")
RESERVOIR = (*SAMPLE, "W", "M")
KEPT = {"position": 3, "normal": 3, "radiance": 3, "W": 1, "M": 1}


def prefixed(prefix, names):
    """The same names with a prefix."""
    return tuple(f"{prefix}_{name}" for name in names)


PASSES = {
    "random": (("key",), {"words": "u4", "u": 4}),
    "direction": (("visible_normal", "u"), {"direction": 3, "pdf": 1}),
    "target": ((*RECEIVER, *SAMPLE), {"p_hat": 1}),
    "jacobian": (("x_from", "x_to", "position", "normal"), {"jacobian": 1}),
    "merge": (("w_a", "M_a", "w_b", "M_b", "u"), {"second": "u1", "w": 1, "M": 1}),
    "finalize": (("w", "p_hat", "Z"), {"W": 1}),
    "similar": (("normal_a", "depth_a", "normal_b", "depth_b"), {"similar": "u1"}),
    "initial": ((*RECEIVER, *SAMPLE, "pdf"), {"p_hat": 1, "W": 1, "M": 1}),
    "temporal": (
        (
            *RECEIVER,
            *prefixed("past", RESERVOIR),
            *prefixed("new", SAMPLE),
            "new_pdf",
            "u",
        ),
        KEPT,
    ),
    "moved": (
        (
            *RECEIVER,
            *prefixed("past", RECEIVER),
            *prefixed("past", RESERVOIR),
            *prefixed("new", SAMPLE),
            "new_pdf",
            "visible",
            "u",
        ),
        KEPT,
    ),
    "neighbors": (("visible_normal", "depth", "u"), {"neighbors": "iK"}),
    "spatial": (
        (
            *RECEIVER,
            *RESERVOIR,
            *prefixed("past", RESERVOIR),
            "neighbors",
            "visible",
            "u_own",
            "u_neighbors",
        ),
        KEPT,
    ),
    "shade": ((*RECEIVER, *SAMPLE, "W"), {"color": 3}),
}
"""Inputs in the order in which the shader counts them, and columns of the outputs."""

PLANTS = (
    "jacobian-divided",
    "jacobian-omitted",
    "jacobian-unsquared",
    "jacobian-receiver-cosine",
    "jacobian-clamped",
    "cosine-omitted",
    "cosine-twice",
    "missing-one-over-pi",
    "one-over-m",
    "nulls-not-counted",
    "m-times-two",
    "cap-missing",
    "confidence-missing",
    "source-target",
    "canonical-missing",
    "visibility-ignored-in-z",
    "visibility-ignored-in-weight",
    "hidden-not-counted",
    "accept-old-sum",
    "wrong-pdf",
    "random-reused",
    "depth-relative-to-own",
    "radius-not-halved",
    "albedo-missing",
    "cap-before-weight",
)
"""Mistakes, in the order of their numbers in the shader."""


class WgslBackend:
    """The passes on a device, which is opened on the first call.

    Parameters
    ----------
    plant : str, optional; mistake to make; by default what ``RESTIR_PLANT`` says
    """

    precision = "float32"

    def __init__(self, plant=None):
        if plant is None:
            plant = os.environ.get("RESTIR_PLANT", "")
        if plant and plant not in PLANTS:
            raise ValueError(f"no plant {plant}; see --list-plants")
        self._plant = 1 + PLANTS.index(plant) if plant else 0
        self._pipelines = {}
        self._device = self._module = None

    def __getattr__(self, name):
        if name not in PASSES:
            raise AttributeError(name)
        return partial(self._run, name)

    def _open(self):
        import wgpu

        adapter = best_adapter()
        # What every device grants is too small for large images.
        large = ("max-buffer-size", "max-storage-buffer-binding-size")
        device = adapter.request_device_sync(
            required_limits={name: adapter.limits[name] for name in large}
        )
        self._wgpu, self._device = wgpu, device

    def _module_of(self, name):
        """The compiled shader that has the entry point of a pass."""
        if self._module is None:
            source = (Path(__file__).parent / "restir.wgsl").read_text(encoding="utf-8")
            self._module = self._device.create_shader_module(code=source)
        return self._module

    def _pipeline(self, name):
        if self._device is None:
            self._open()
        if name not in self._pipelines:
            module = self._module_of(name)
            stage = {"module": module, "entry_point": f"pass_{name}"}
            visible = self._wgpu.ShaderStage.COMPUTE
            kinds = ["read-only-storage"] * 3 + ["storage"] * 2
            # Not every pass uses every buffer; one layout serves all.
            group = self._device.create_bind_group_layout(
                entries=[
                    {"binding": k, "visibility": visible, "buffer": {"type": kind}}
                    for k, kind in enumerate(kinds)
                ]
            )
            layout = self._device.create_pipeline_layout(bind_group_layouts=[group])
            pipeline = self._device.create_compute_pipeline(
                layout=layout, compute=stage
            )
            self._pipelines[name] = pipeline, group
        return self._pipelines[name]

    def _run(self, name, **given):
        inputs, outputs = PASSES[name]
        arrays = {key: as_read(given.pop(key)) for key in inputs}
        rows = len(arrays[inputs[0]])
        columns = {"neighbors": "u", "spatial": "neighbors"}.get(name)
        count = arrays[columns].shape[1] if columns else 0
        reals, words, starts = [], [], []
        for array in arrays.values():
            pool = reals if array.dtype == np.float32 else words
            starts.append(sum(part.size for part in pool))
            pool.append(
                array.reshape(-1).view(np.float32 if pool is reals else np.uint32)
            )
        shapes, ends, sizes = {}, [], {"f": 0, "u": 0}
        for key, form in outputs.items():
            kind = "f" if isinstance(form, int) else "u"
            width = form if kind == "f" else count if form[1] == "K" else int(form[1])
            shapes[key] = kind, sizes[kind], width
            ends.append(sizes[kind])
            sizes[kind] += rows * width
        parameters = self._parameters(rows, count, given)
        parameters[16 : 16 + len(starts)] = starts
        parameters[40 : 40 + len(ends)] = ends
        found = self._dispatch(name, rows, parameters, reals, words, sizes)
        result = {}
        for key, (kind, start, width) in shapes.items():
            part = found[kind][start : start + rows * width]
            part = part.view(np.int32) if outputs[key] == "iK" else part
            is_column = width == 1 and outputs[key] != "iK"
            result[key] = part if is_column else part.reshape(rows, width)
        return result

    def _parameters(self, rows, count, settings):
        p = np.zeros(64, np.uint32)
        p[:3] = rows, self._plant, count
        p[3] = settings.get("target") == "outgoing"
        p[4] = settings.get("mis") == "1/Z"
        p[5] = settings.get("source") == "uniform"
        p[6] = settings.get("width", 0)
        angle = math.radians(settings.get("max_angle", 0.0))
        p[7:12] = np.array(
            [
                settings.get("cap", 0.0),
                settings.get("radius", 0.0),
                settings.get("min_radius", 0.0),
                math.cos(angle),
                settings.get("max_depth", 0.0),
            ],
            np.float32,
        ).view(np.uint32)
        return p

    def _dispatch(self, name, rows, parameters, reals, words, sizes):
        pipeline, layout = self._pipeline(name)
        device, usage = self._device, self._wgpu.BufferUsage

        def filled(parts, dtype):
            # One number more, since no buffer may be empty.
            data = np.concatenate([*parts, np.zeros(1, dtype)])
            return device.create_buffer_with_data(data=data, usage=usage.STORAGE)

        def empty(size):
            flags = usage.STORAGE | usage.COPY_SRC
            return device.create_buffer(size=4 * max(size, 1), usage=flags)

        out = {kind: empty(size) for kind, size in sizes.items()}
        buffers = [
            filled([parameters], np.uint32),
            filled(reals, np.float32),
            filled(words, np.uint32),
            out["f"],
            out["u"],
        ]
        entries = [
            {"binding": k, "resource": {"buffer": b, "offset": 0, "size": b.size}}
            for k, b in enumerate(buffers)
        ]
        group = device.create_bind_group(layout=layout, entries=entries)
        encoder = device.create_command_encoder()
        run = encoder.begin_compute_pass()
        run.set_pipeline(pipeline)
        run.set_bind_group(0, group)
        run.dispatch_workgroups(-(-rows // 64))
        run.end()
        device.queue.submit([encoder.finish()])
        types = {"f": np.float32, "u": np.uint32}
        return {
            kind: np.frombuffer(device.queue.read_buffer(b), types[kind]).copy()
            for kind, b in out.items()
        }


def as_read(array):
    """The array in the number type in which the shader reads its kind."""
    array = np.asarray(array)
    dtype = {"f": "<f4", "i": "<i4", "u": "<u4"}[array.dtype.kind]
    return np.ascontiguousarray(array, dtype)


def adapters():
    """Adapters of this machine, those on real devices first."""
    # Mesa complains on stderr where this is not set.
    os.environ["XDG_RUNTIME_DIR"] = os.environ.get("XDG_RUNTIME_DIR") or "/tmp"
    import wgpu

    return sorted(
        wgpu.gpu.enumerate_adapters_sync(),
        key=lambda a: (
            a.info["adapter_type"] == "CPU",
            a.info["backend_type"] == "OpenGL",
        ),
    )


def best_adapter():
    """The first adapter whose name holds ``RESTIR_ADAPTER``."""
    wanted = os.environ.get("RESTIR_ADAPTER", "").lower()
    found = [a for a in adapters() if wanted in a.summary.lower()]
    if not found:
        raise RuntimeError(
            "no adapter for shaders; without a GPU install mesa-vulkan-drivers"
        )
    return found[0]


BACKEND = WgslBackend()

if __name__ == "__main__":
    if "--list-plants" in sys.argv:
        print("\n".join(PLANTS))
    else:
        for name in PLANTS:
            print("plant", name)
        for adapter in adapters():
            print("adapter", adapter.summary)
