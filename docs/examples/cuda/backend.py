"""A backend in CUDA: built by nvcc where there is a device, else as C++ for the host.

    restir check docs/examples/cuda/backend.py

The environment variable ``RESTIR_COMPILER`` names another compiler: nvcc, or one of C++
that takes the options of g++.  ``python backend.py`` tells which it is.
"""

import ctypes
import math
import os
import shutil
import subprocess
import tempfile
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).with_name("restir.cu")


def prefixed(prefix, names):
    """The same names with a prefix."""
    return tuple(f"{prefix}_{name}" for name in names)


SURFACE = ("visible_position", "visible_normal", "albedo")
SAMPLE = ("position", "normal", "radiance")
RESERVOIR = (*SAMPLE, "W", "M")

INPUTS = (
    *SURFACE,
    *prefixed("past", SURFACE),
    *RESERVOIR,
    *prefixed("past", RESERVOIR),
    *prefixed("new", SAMPLE),
    *("pdf", "new_pdf", "u", "u_own", "u_neighbors", "depth"),
    *("neighbors", "visible", "key", "x_from", "x_to"),
    *("w_a", "M_a", "w_b", "M_b", "w", "p_hat", "Z"),
    *("normal_a", "normal_b", "depth_a", "depth_b"),
)
"""Buffers that passes read, in the order of ``struct Inputs``."""

OUTPUTS = (
    *RESERVOIR,
    *("w", "p_hat", "pdf", "jacobian", "direction", "color"),
    *("words", "u", "second", "similar", "neighbors"),
)
"""Buffers that they write, in the order of ``struct Outputs``."""

REAL, BITS, INDEX = np.dtype("<f4"), np.dtype("<u4"), np.dtype("<i4")
TYPES = {"f": REAL, "u": BITS, "i": INDEX}

KEPT = dict.fromkeys(SAMPLE, (REAL, 3)) | {"W": (REAL,), "M": (REAL,)}

PASSES = {
    "random": {"words": (BITS, 4), "u": (REAL, 4)},
    "direction": {"direction": (REAL, 3), "pdf": (REAL,)},
    "target": {"p_hat": (REAL,)},
    "jacobian": {"jacobian": (REAL,)},
    "merge": {"second": (BITS,), "w": (REAL,), "M": (REAL,)},
    "finalize": {"W": (REAL,)},
    "similar": {"similar": (BITS,)},
    "initial": {"p_hat": (REAL,), "W": (REAL,), "M": (REAL,)},
    "temporal": KEPT,
    "moved": KEPT,
    "neighbors": {"neighbors": (INDEX, "K")},
    "spatial": KEPT,
    "shade": {"color": (REAL, 3)},
}
"""What each pass returns: type, and columns if it has any."""


class Inputs(ctypes.Structure):
    """Pointers to what a pass reads."""

    _fields_ = [(name, ctypes.c_void_p) for name in INPUTS]


class Outputs(ctypes.Structure):
    """Pointers to what it writes."""

    _fields_ = [(name, ctypes.c_void_p) for name in OUTPUTS]


WHOLE = ("rows", "count", "outgoing", "by_support", "uniform", "width")
REALS = ("radius", "min_radius", "min_cosine", "max_depth", "cap")


class Settings(ctypes.Structure):
    """``struct Settings``."""

    _fields_ = [
        *((name, ctypes.c_int) for name in WHOLE),
        *((name, ctypes.c_float) for name in REALS),
    ]


class Params(ctypes.Structure):
    """``struct Params``."""

    _fields_ = [("settings", Settings), ("inputs", Inputs), ("outputs", Outputs)]


class CudaBackend:
    """The passes of ``restir.cu``, which is compiled on the way in."""

    precision = "float32"

    def __init__(self):
        self._library = built(compiler())
        with ExitStack() as held:
            self._allocated(1, held)  # a device that is missing is told now

    def __getattr__(self, name):
        if name not in PASSES:
            raise AttributeError(name)
        return partial(self._run, name)

    def _run(self, name, **given):
        arrays = {key: given.pop(key) for key in INPUTS if key in given}
        rows = len(next(iter(arrays.values())))
        columns = {"neighbors": "u", "spatial": "neighbors"}.get(name)
        count = arrays[columns].shape[1] if columns else 0
        sizes = {"K": count}
        results = {
            key: np.empty((rows, *(sizes.get(size, size) for size in shape)), dtype)
            for key, (dtype, *shape) in PASSES[name].items()
        }
        if rows == 0:
            return results
        params = Params(settings=settings(rows, count, given))
        with ExitStack() as held:
            for key, array in arrays.items():
                setattr(params.inputs, key, self._copied(array, held))
            for key, result in results.items():
                setattr(params.outputs, key, self._allocated(result.nbytes, held))
            self._call(f"launch_{name}", ctypes.byref(params))
            for key, result in results.items():
                pointer = ctypes.c_void_p(getattr(params.outputs, key))
                size = ctypes.c_size_t(result.nbytes)
                self._call("to_host", result.ctypes, pointer, size)
        return results

    def _copied(self, array, held):
        """Where an array lies on the device, for as long as the stack is open."""
        array = np.ascontiguousarray(array, TYPES[array.dtype.kind])
        device = self._allocated(array.nbytes, held)
        size = ctypes.c_size_t(array.nbytes)
        self._call("to_device", device, array.ctypes, size)
        return device

    def _allocated(self, size, held):
        """So many bytes of the device, for as long as the stack is open."""
        device = ctypes.c_void_p()
        # Where there are no neighbours, buffers are empty.
        size = ctypes.c_size_t(max(size, 1))
        self._call("device_allocate", ctypes.byref(device), size)
        held.callback(self._call, "device_free", device)
        return device

    def _call(self, name, *arguments):
        function = getattr(self._library, name)
        function.restype = ctypes.c_char_p
        error = function(*arguments)
        if error:
            raise RuntimeError(f"CUDA, {name}: {error.decode()}")


def settings(rows, count, given):
    """``struct Settings`` of a call; what it is not asked for stays 0."""
    found = Settings(rows=rows, count=count)
    found.outgoing = given.get("target") == "outgoing"
    found.by_support = given.get("mis") == "1/Z"
    found.uniform = given.get("source") == "uniform"
    found.min_cosine = math.cos(math.radians(given.get("max_angle", 0.0)))
    for name in ("width", "radius", "min_radius", "max_depth", "cap"):
        setattr(found, name, given.get(name, 0))
    return found


# ---------------------------------------------------------------- the compiler


def has_device():
    """Whether the driver of CUDA finds a device."""
    try:
        driver = ctypes.CDLL("libcuda.so.1")
    except OSError:
        return False
    count = ctypes.c_int()
    found = driver.cuInit(0) == 0 and driver.cuDeviceGetCount(ctypes.byref(count)) == 0
    return found and count.value > 0


def compiler():
    """Path of the compiler: nvcc where there is a device, else one of C++."""
    wanted = os.environ.get("RESTIR_COMPILER")
    names = [wanted] if wanted else ["g++", "clang++", "c++"]
    if not wanted and has_device():
        names.insert(0, "nvcc")
    for name in names:
        path = shutil.which(name)
        if path:
            return path
    raise RuntimeError(f"no compiler ({', '.join(names)}) on the PATH; install g++")


def built(path):
    """Library of the passes."""
    options = ["-O2", "-std=c++17", "-shared"]
    if Path(path).stem == "nvcc":
        options += ["-arch=native", "-Xcompiler", "-fPIC", str(SOURCE)]
    else:
        options += ["-fPIC", "-x", "c++", str(SOURCE)]
    # A library that is loaded no longer needs its file.
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "restir.so"
        told = subprocess.run(
            [path, *options, "-o", str(library)], capture_output=True, text=True
        )
        if told.returncode:
            first = (told.stderr or told.stdout).strip().partition("\n")[0]
            raise RuntimeError(f"{path} cannot build {SOURCE.name}: {first}")
        return ctypes.CDLL(str(library))


if __name__ == "__main__":
    print("device" if has_device() else "no device", compiler(), sep=", ")
else:
    BACKEND = CudaBackend()
