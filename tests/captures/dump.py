"""Frames of the engine as files of a capture, as an engineer would copy them."""

import numpy as np

from tests.captures.packed import F

BLOCK = 16

HEAD = """\
schema = "restir-capture 1"
width = {size}
height = {size}
frames = {frames}
declaration = "declaration.toml"
"""

PASSES = """\

[passes.temporal]
cap = 20
surface = "{surface}"

[passes.spatial]
cap = 255
surface = "{surface}"
"""

VISIBLE_POINTS = """\

[buffers.position]
role = "gbuffer"
file = "position.{{frame}}.bin"
stride = 16
fields = [{{ name = "visible_position", kind = "float32" }}]

[buffers.normal]
role = "gbuffer"
file = "normal.{{frame}}.bin"
stride = 16
fields = [{{ name = "visible_normal", kind = "float32" }}]

[buffers.albedo]
role = "gbuffer"
file = "albedo.{{frame}}.bin"
stride = 16
fields = [{{ name = "albedo", kind = "float32" }}]
"""

RESERVOIRS = """\

[buffers.initial]
file = "initial.{{frame}}.bin"
layout = "rtxdi"

[buffers.history]
file = "history.{{frame}}.bin"
fields = [{{ name = "row", kind = "int32" }}]

[buffers.temporal]
file = "temporal.{{frame}}.bin"
layout = "rtxdi"

[buffers.visible_temporal]
file = "visible_temporal.{{frame}}.bin"
fields = [{{ name = "visible", kind = "uint32", count = 2 }}]

[buffers.neighbors]
file = "neighbors.{{frame}}.bin"
fields = [{{ name = "neighbors", kind = "int32", count = {around}, given = "rows" }}]

[buffers.spatial]
file = "spatial.{{frame}}.bin"
layout = "rtxdi"

[buffers.visible_spatial]
file = "visible_spatial.{{frame}}.bin"
fields = [{{ name = "visible", kind = "uint32", count = {viewers} }}]
"""

SHADING = """\

[buffers.visible_shade]
file = "visible_shade.{{frame}}.bin"
fields = [{{ name = "visible", kind = "uint32" }}]

[buffers.shade]
file = "shade.{{frame}}.bin"
stride = 16
fields = [{{ name = "color", kind = "float32" }}]
"""

FUSED_PASS = """\

[passes.fused]
cap = 20
"""

FUSED_RESERVOIRS = """\

[buffers.initial]
file = "initial.{{frame}}.bin"
layout = "rtxdi"

[buffers.sources]
file = "sources.{{frame}}.bin"
fields = [{{ name = "sources", kind = "int32", count = {around}, given = "rows" }}]

[buffers.fused]
file = "fused.{{frame}}.bin"
layout = "rtxdi"

[buffers.visible_fused]
file = "visible_fused.{{frame}}.bin"
fields = [{{ name = "visible", kind = "uint32", count = {viewers} }}]
"""

MATERIAL = """\

[buffers.view]
role = "gbuffer"
file = "view.{{frame}}.bin"
stride = 16
fields = [{{ name = "view", kind = "float32" }}]

[buffers.alpha]
role = "gbuffer"
file = "alpha.{{frame}}.bin"
fields = [{{ name = "alpha", kind = "float32" }}]

[buffers.f0]
role = "gbuffer"
file = "f0.{{frame}}.bin"
stride = 16
fields = [{{ name = "f0", kind = "float32" }}]
"""

DECLARATION = """\
schema = "restir-declaration 1"
name = "an engine in the manner of RTXDI"

[choices]
generator = "own"
order = "own-first"
cap = "on arrival"
mis = "balance"
mis_jacobian = false
visibility = "shading"
"""


def dump(engine, folder, frames):
    """Run an engine, and copy its buffers into a folder."""
    size, around = engine.size, engine.around
    for frame, buffers in enumerate(engine.run(frames)):
        for name, array in _files(buffers, size).items():
            (folder / f"{name}.{frame}.bin").write_bytes(array.tobytes())
    about = {"size": size, "frames": list(range(frames)), "surface": engine.surface}
    text = _manifest(engine).format(**about, around=around, viewers=around + 1)
    (folder / "capture.toml").write_text(text)
    (folder / "declaration.toml").write_text(DECLARATION)
    return folder


def _manifest(engine):
    """``capture.toml``, but for its numbers."""
    if engine.fused:
        return HEAD + FUSED_PASS + VISIBLE_POINTS + FUSED_RESERVOIRS + SHADING
    form = HEAD + PASSES + VISIBLE_POINTS + RESERVOIRS + SHADING
    return form + MATERIAL if engine.surface == "ggx" else form


def _files(buffers, size):
    found = {}
    for name in ("position", "normal", "albedo", "view", "f0"):
        if name in buffers["gbuffer"]:
            found[name] = _texture(buffers["gbuffer"][name])
    if "alpha" in buffers["gbuffer"]:
        found["alpha"] = buffers["gbuffer"]["alpha"]
    for name in buffers.keys() & {"initial", "temporal", "spatial", "fused"}:
        found[name] = in_blocks(buffers[name], size)
    for name in buffers.keys() & {"history", "neighbors", "sources"}:
        found[name] = buffers[name].astype(np.int32)
    for name in (name for name in buffers if name.startswith("visible_")):
        found[name] = buffers[name].astype(np.uint32)
    return found | {"shade": _texture(buffers["shade"])}


def _texture(vectors):
    """Four floats a pixel."""
    return np.column_stack([vectors, np.zeros(len(vectors))]).astype(F)


def in_blocks(reservoirs, size):
    """Pixels in blocks of 16 × 16, as RTXDI stores them."""
    across = -(-size // BLOCK)
    y, x = np.divmod(np.arange(size * size), size)
    block = (y // BLOCK) * across + x // BLOCK
    place = (block * BLOCK + y % BLOCK) * BLOCK + x % BLOCK
    out = np.zeros(across * across * BLOCK * BLOCK, reservoirs.dtype)
    out[place] = reservoirs
    return out
