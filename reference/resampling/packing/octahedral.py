"""Unit normals in four bytes: octahedral coordinates as two 16-bit integers.

The sphere is projected onto the octahedron |x| + |y| + |z| = 1, and that is looked at
from +z.  The upper half is seen as the square |u| + |v| <= 1; the faces of the lower
half are folded outward over its sides and fill the rest of [-1, 1]².
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import (
    Scalars,
    Vec3s,
    divide_or_zero,
    normalize,
    vectors,
)

UNIT = 32767
"""Code of the coordinate 1.  -32768 is never written and read as -32767."""

WORST_ANGLE = 3 / (2**0.5 * UNIT)
"""Largest angle between a normal and its decoded code: 6.474e-5 radians, 13.4″."""


def encode_normal(n: Vec3s) -> NDArray[np.int16]:
    """Octahedral code of unit normals: the nearest point of a grid of step 1/32767.

        (u, v) = (x, y) / (|x| + |y| + |z|), and where z < 0
        (u, v) = ((1 - |v|) sign u, (1 - |u|) sign v), with sign 0 = +1

    Parameters
    ----------
    n : (N, 3) float; unit normals, or 0

    Returns
    -------
    (N, 2) int16
        32767 (u, v), rounded to nearest, ties to even: from -32767 to 32767.  One code
        for one normal: v >= 0 where |u| = 32767, and u >= 0 where |v| = 32767.  The
        zero vector, which a null may have, becomes (0, 0), that is +z.  Components that
        are not finite count as 0.

    Notes
    -----
    The map of [Cigolle14], each coordinate rounded on its own.  The angle between a
    normal and its decoded code is at most `WORST_ANGLE` = 3 / (√2 · 32767).  For: a
    step dp = (du, dv) in the square is, but for order and signs, the step (du, dv,
    du + dv) on a face, no longer than √3 |dp|; a face is 1/√3 from the centre, so that
    it is seen under no more than 3 |dp|; edges and folds only join such pieces; and
    rounding has |dp| <= √2 · (1/2) / 32767.  The bound is met where a face is nearest,
    about (±1, ±1, ±1) / √3.
    """
    n = np.where(np.isfinite(n), n, 0.0).astype(np.float64)
    total = abs(n[:, 0]) + abs(n[:, 1]) + abs(n[:, 2])
    u = UNIT * divide_or_zero(n[:, 0], total)
    v = UNIT * divide_or_zero(n[:, 1], total)
    u, v = _fold_where(n[:, 2] < 0, u, v)
    u, v = np.rint(u), np.rint(v)
    # The sides of the square are folded onto themselves: keep one half of each.
    v = np.where(abs(u) == UNIT, abs(v), v)
    u = np.where(abs(v) == UNIT, abs(u), u)
    codes: NDArray[np.int16] = np.stack([u, v], axis=-1).astype(np.int16)
    return codes


def decode_normal(codes: NDArray[np.int16]) -> Vec3s:
    """Unit normals of octahedral codes.

    The point on the octahedron is a vector of whole numbers, |x| + |y| + |z| = 32767,
    without an error; only its length is rounded.

    Parameters
    ----------
    codes : (N, 2) int16; any; -32768 is read as -32767

    Returns
    -------
    (N, 3) float64
        Of unit length to rounding.  `encode_normal` gives back the same codes, except
        for -32768 and for those halves of the square's sides that it does not write;
        other encoders write them for normals a hair beyond the planes x = 0 and y = 0.
    """
    u, v = (np.maximum(codes[:, i].astype(np.int32), -UNIT) for i in range(2))
    z = UNIT - abs(u) - abs(v)
    x, y = _fold_where(z < 0, u, v)
    return normalize(vectors(x, y, z).astype(np.float64))


def _fold_where(below: NDArray[Any], u: Scalars, v: Scalars) -> tuple[Scalars, Scalars]:
    """Fold a side over its edge, out or in: the map is its own inverse."""
    sign_u, sign_v = np.where(u < 0, -1, 1), np.where(v < 0, -1, 1)
    folded_u, folded_v = (UNIT - abs(v)) * sign_u, (UNIT - abs(u)) * sign_v
    return np.where(below, folded_u, u), np.where(below, folded_v, v)
