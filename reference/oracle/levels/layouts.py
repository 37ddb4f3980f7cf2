"""Cases of reservoirs in the layouts of others, which have to be declared."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize, vectors
from restir_gi.reference.oracle.builtin.packing import pack
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.packing import RESTIR_PT, RTXDI, RTXDI_PATH
from restir_gi.reference.oracle.levels.draws import spread, unit_vectors
from restir_gi.reference.oracle.levels.further_views import ROWS, Parts
from restir_gi.reference.oracle.levels.packing import packing_cases
from restir_gi.reference.resampling.packing import rtxdi, rtxdi_path
from restir_gi.reference.resampling.packing.log_luv import (
    CHROMA_SCALE,
    LEVELS_PER_STOP,
    XYZ_TO_RGB,
)

Inputs = dict[str, Any]

AGES = [0, 1, 30, 31, 32, 128, 254, 255, 256, 65535, 65536, 2**24, 2**32 - 1]
"""About the ends of five, eight and sixteen bits."""


def layout_cases(rng: np.random.Generator) -> Iterator[Parts]:
    """Reservoirs in other layouts than the paper's, written and read."""
    yield from _restir_pt(rng)
    yield from _rtxdi(rng)
    yield from _rtxdi_path(rng)


def _of(layout: str, name: str, inputs: Inputs) -> Parts:
    """A case whose name has the layout behind the pass."""
    pass_name, _, rest = name.partition("-")
    words = (pass_name, layout.replace("_", "-"), rest)
    settings: dict[str, Value] = {"layout": layout}
    return "-".join(w for w in words if w), settings, inputs


def _restir_pt(rng: np.random.Generator) -> Iterator[Parts]:
    """As for the paper, with an age in place of the seed."""
    for name, _, inputs in packing_cases(rng):
        if name.startswith("pack"):
            inputs = {n: a for n, a in inputs.items() if n != "seed"}
            inputs |= {"age": _ages(rng)}
        yield _of(RESTIR_PT, name, inputs)


def _ages(rng: np.random.Generator) -> Scalars:
    young = rng.integers(0, 300, ROWS, np.uint32)
    ends = rng.choice(np.array(AGES, np.uint32), ROWS)
    return np.where(rng.random(ROWS) < 0.6, young, ends)


def _reservoirs(rng: np.random.Generator) -> Inputs:
    """Places, W and confidences over all decades; whole confidences."""
    return {
        "position": rng.normal(size=(ROWS, 3)) * 100,
        "normal": unit_vectors(rng, ROWS),
        "radiance": 10.0 ** rng.uniform(-6.5, 6, (ROWS, 3)),
        "W": spread(rng, -6, 6, ROWS) * (rng.random(ROWS) < 0.9),
        "M": np.where(
            rng.random(ROWS) < 0.6,
            rng.integers(0, 300, ROWS),
            rng.choice([254.0, 255.0, 256.0, 257.0, 1000.0, 65536.0, 1e5], ROWS),
        ),
    }


def _on_the_planes(rng: np.random.Generator) -> Vec3s:
    """Normals along axes, on the folds and a hair beside them, and none at all."""
    some = rng.integers(-1, 2, (ROWS, 3)).astype(float)
    beside = np.where(rng.random((ROWS, 1)) < 0.5, 1e-5, 0.0)
    return normalize(some + beside * rng.normal(size=some.shape))


# ------------------------------------------------ 32 bytes of RTXDI


def _rtxdi(rng: np.random.Generator) -> Iterator[Parts]:
    inputs = _reservoirs(rng) | {
        "age": _ages(rng),
        "misc": rng.integers(0, 2**16, ROWS, np.uint32),
    }
    yield _of(RTXDI, "pack", inputs)
    # Light of one channel and of two, grey, and none; at the edges of cells.
    some = inputs | {"normal": _on_the_planes(rng), "radiance": _colors(rng)}
    yield _of(RTXDI, "pack-colours", some)
    edges = inputs | {"radiance": _at_edges(rng)}
    yield _of(RTXDI, "pack-edges", edges)

    words = pack("float64", RTXDI, **(inputs | {"radiance": _colors(rng)}))["words"]
    yield _of(RTXDI, "unpack", {"words": words})
    # All codes, with chromaticities that no colour has; and whatever is not used.
    wild = np.ascontiguousarray(words).view(rtxdi.RESERVOIR)[:, 0].copy()
    L = rng.integers(0, 16384, ROWS, np.uint32) * (rng.random(ROWS) < 0.95)
    u, v = rng.integers(1, 512, (2, ROWS), np.uint32)
    wild["L_o"] = L.astype(np.uint32) << 18 | u << 9 | v
    ends = [-32768, -32767, -20000, -1, 0, 1, 12767, 32767]
    wild["n_s"] = rng.choice(ends, (ROWS, 2))
    for name in ("M", "age", "misc", "unused"):
        wild[name] = rng.integers(0, 2**32, ROWS, np.uint32)
    words = wild.view("<u4").reshape(ROWS, -1)
    yield _of(RTXDI, "unpack-extremes", {"words": words})


def _colors(rng: np.random.Generator) -> Vec3s:
    """Light of a channel, or of two, grey light and no light, over all decades."""
    there = rng.integers(0, 2, (ROWS, 3))
    tint = np.where(rng.random((ROWS, 1)) < 0.3, 1.0, rng.uniform(0.05, 1, (ROWS, 3)))
    color: Vec3s = spread(rng, -5.7, 6, ROWS)[:, None] * tint * there
    return color


def _at_edges(rng: np.random.Generator) -> Vec3s:
    """Light whose level, or whose chromaticity, is at the edge of a cell, or near it.

    A third of the levels are those about which light becomes black.
    """
    level = rng.integers(1, 16383, ROWS)
    level = np.where(rng.random(ROWS) < 0.3, rng.integers(1, 3, ROWS), level)
    u, v = rng.uniform(155, 185, ROWS), rng.uniform(370, 400, ROWS)
    which = np.arange(ROWS) % 3
    beside = rng.choice([0.0, 1e-5, 1e-3, 0.02], ROWS) * rng.choice([-1, 1], ROWS)
    u = np.where(which == 1, np.rint(u) + beside, u)
    v = np.where(which == 2, np.rint(v) + beside, v)
    L = np.where(which == 0, level + beside, level + rng.uniform(0.1, 0.9, ROWS))
    Y = 2.0 ** (L / LEVELS_PER_STOP - 20)
    u, v = u / CHROMA_SCALE, v / CHROMA_SCALE
    X, Z = Y * (9 * u) / (4 * v), Y * (12 - 3 * u - 20 * v) / (4 * v)
    color: Vec3s = np.maximum(vectors(X, Y, Z) @ XYZ_TO_RGB.T, 0.0)
    return color


# ------------------------------------------------ 64 bytes of RTXDI


def _rtxdi_path(rng: np.random.Generator) -> Iterator[Parts]:
    young = rng.integers(0, 32, ROWS, np.uint32)
    whole = {
        "age": np.where(rng.random(ROWS) < 0.7, young, _ages(rng)),
        "boosts": rng.integers(0, 2, ROWS, np.uint32),
        **{
            name: rng.integers(0, 256, ROWS, np.uint32)
            for name in ("reconnection_vertex", "path_length", "random_index")
        },
        "seed": rng.integers(0, 2**32, ROWS, np.uint32),
    }
    numbers = {
        "partial_jacobian": spread(rng, -6, 6, ROWS),
        "onward_pdf": spread(rng, -6, 6, ROWS) * (rng.random(ROWS) < 0.9),
        "target_function": 10.0 ** rng.uniform(-6, 6, (ROWS, 3)),
    }
    inputs = _with_lights(rng, _reservoirs(rng) | whole | numbers)
    yield _of(RTXDI_PATH, "pack", inputs)
    ends = [0.25, 1.5, 2047.0, 2049.0, 4095.0, 65504.0, 65519.0, 65520.0, 1e5]
    extremes = inputs | {
        "normal": _on_the_planes(rng),
        "M": np.where(
            rng.random(ROWS) < 0.5, rng.choice(ends, ROWS), spread(rng, 0, 5, ROWS)
        ),
    }
    yield _of(RTXDI_PATH, "pack-extremes", extremes)

    words = pack("float64", RTXDI_PATH, **inputs)["words"]
    yield _of(RTXDI_PATH, "unpack", {"words": words})
    # All codes of normals, but for the one that is no direction; unused bits; halves.
    wild = np.ascontiguousarray(words).view(rtxdi_path.RESERVOIR)[:, 0].copy()
    codes = rng.integers(0, 2**16, (ROWS, 3))
    some = rng.choice([0, 1, 32766, 32767, 32768, 65534, 65535], (ROWS, 3))
    codes = np.where(rng.random((ROWS, 1)) < 0.5, codes, some)
    codes[(codes == 32767).all(axis=1)] = [0, 0, 65534]
    wild["n_s"], wild["age"] = codes, rng.integers(0, 256, ROWS)
    wild["M"] = rng.integers(0x400, 0x7C00, ROWS, np.uint16).view(np.float16)
    words = wild.view("<u4").reshape(ROWS, -1)
    yield _of(RTXDI_PATH, "unpack-extremes", {"words": words})


def _with_lights(rng: np.random.Generator, inputs: Inputs) -> Inputs:
    """A third of the paths end at a light that was sampled, of any bits."""
    on_light = rng.random(ROWS) < 0.3
    words = rng.integers(0, 2**32, (2, ROWS), np.uint32)
    light, place = np.where(on_light, words, np.uint32(0))
    return inputs | {
        "radiance": np.where(on_light[:, None], 0.0, inputs["radiance"]),
        "on_light": on_light.astype(np.uint32),
        "light": light,
        "light_place": place,
    }
