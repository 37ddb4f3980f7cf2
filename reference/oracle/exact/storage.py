"""Kernels of numbers that are stored in fewer bits."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import Exact, exact, type_of
from restir_gi.reference.oracle.exact.vectors import Vector, inner
from restir_gi.reference.resampling.packing.octahedral import (
    WORST_ANGLE,
    decode_normal,
    encode_normal,
)
from restir_gi.reference.resampling.packing.rounding import nearest_float, widened

_HALF = type_of(np.float16)


def _run_half(given: Inputs) -> Scalars:
    radiance = given["radiance"]
    return widened(nearest_float(radiance, np.float16)).astype(radiance.dtype)


def _half(row: Row) -> Exact:
    """Rounded once: half a unit in the last place, or of the smallest subnormal."""
    x = row["radiance"]
    value = min(x.value, _HALF.most)
    return Exact(value, max(value * _HALF.unit, _HALF.least / 2), x.type)


HALF = Kernel(
    "radiance in half", "pack",
    lambda draws: {"radiance": draws("radiance")}, _run_half, _half,
    {
        "radiance at its limits": "at most 65504; below 2⁻¹⁴ to a multiple of 2⁻²⁴",
        "no light": "0",
    },
)  # fmt: skip


def _draw_normal(draws: Draws) -> dict[str, Scalars]:
    return {"n": draws.about_z()}


def _run_octahedral(given: Inputs) -> Vec3s:
    return decode_normal(encode_normal(given["n"])).astype(given["n"].dtype)


def _octahedral(row: Row) -> Vector:
    """The unit vector of n; the chord is shorter than the angle."""
    n = row["n"]
    size = inner(n, n).sqrt()
    near = exact(WORST_ANGLE, n[0].type).value
    x, y, z = (Exact(c.value, c.error + near, c.type) for c in (v / size for v in n))
    return x, y, z


OCTAHEDRAL = Kernel(
    "normal in four bytes", "pack", _draw_normal, _run_octahedral, _octahedral,
    {
        "edge-on": "within 6.474e-5 radians, across the fold too",
        "in a corner": "as edge-on",
    },
)  # fmt: skip

STORAGE = (HALF, OCTAHEDRAL)
