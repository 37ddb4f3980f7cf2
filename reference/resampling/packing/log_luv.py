"""Radiance in four bytes: logarithm of luminance, and chromaticity u′, v′ of CIE 1976.

::

    bits 31:18  L = floor(409.6 (log₂ Y + 20)), 14 bits for Y from 2⁻²⁰ to 2²⁰
    bits 17:9   floor(820 u′), 9 bits
    bits 8:0    floor(820 v′), 9 bits

A word stands for the middle of its cell; L = 0 stands for black.
"""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Vec3s, divide_or_zero, dot, vectors

LEVELS_PER_STOP = 409.6
DARKEST = 2.0**-20
CHROMA_SCALE = 820


def _rgb_to_xyz() -> NDArray[np.float64]:
    """Matrix from linear Rec. 709 to CIE XYZ: primaries as columns, white of Y = 1."""
    xy = np.array([(0.64, 0.33), (0.30, 0.60), (0.15, 0.06), (0.3127, 0.3290)])
    xyz = np.column_stack([xy, 1 - xy.sum(axis=1)]).T
    primaries, white = xyz[:, :3], xyz[:, 3] / xyz[1, 3]
    matrix: NDArray[np.float64] = primaries * np.linalg.solve(primaries, white)
    return matrix


RGB_TO_XYZ = _rgb_to_xyz()
XYZ_TO_RGB = np.linalg.inv(RGB_TO_XYZ)


def encode_log_luv(color: Vec3s) -> NDArray[np.uint32]:
    """LogLuv word of linear colours.

        u′ = 4 X / (X + 15 Y + 3 Z),  v′ = 9 Y / (X + 15 Y + 3 Z)

    The format of RTXDI, RtxdiMath.hlsli, from which are the order of the fields, 409.6,
    820, the truncation, and Rec. 709.  RTXDI computes in float32: for a colour within
    rounding of the edge of a cell its word may be the neighbour of ours.

    Parameters
    ----------
    color : (N, 3) float
        Linear Rec. 709 radiance.  Negative channels and NaN count as 0, what is beyond
        float32 as its largest number.

    Returns
    -------
    (N,) uint32
        0 where L is 0, that is below the luminance 2^(1/409.6 - 20) = 9.553e-7; L is
        16383 from 2^(16383/409.6 - 20) = 1.0468e6 upwards.
    """
    color = np.nan_to_num(color.astype(np.float64), nan=0.0)
    rgb = np.clip(color, 0.0, np.finfo(np.float32).max)
    X, Y, Z = (dot(rgb, row) for row in RGB_TO_XYZ)
    level = LEVELS_PER_STOP * np.log2(np.maximum(Y, DARKEST) / DARKEST)
    divisor = X + 15 * Y + 3 * Z
    u = CHROMA_SCALE * divide_or_zero(4 * X, divisor)
    v = CHROMA_SCALE * divide_or_zero(9 * Y, divisor)
    L, u, v = (
        np.clip(field, 0, most).astype(np.uint32)
        for field, most in ((level, 16383), (u, 511), (v, 511))
    )
    return np.where(L == 0, L, (L << 18) | (u << 9) | v)


def decode_log_luv(words: NDArray[np.uint32]) -> Vec3s:
    """Linear colours of LogLuv words.

        X = Y · 9 u′ / (4 v′),  Z = Y · (12 - 3 u′ - 20 v′) / (4 v′)

    Parameters
    ----------
    words : (N,) uint32

    Returns
    -------
    (N, 3) float64
        Black where L is 0.  Channels are not negative: where the middle of a cell is
        outside the triangle of Rec. 709, what is below 0 becomes 0.

    Notes
    -----
    Let a colour have the luminance Y from 9.553e-7 to 2²⁰.  If the middle of its cell
    is inside the triangle, the luminance is off by at most 2^(1/819.2) - 1 = 8.465e-4
    of Y.  Along the sides of the triangle, in 1.4 % of the cells, the middle is not;
    cutting off what is negative makes these brighter, by up to 1.14e-2 of Y.  A channel
    is off by at most 0.09 Y: that is beside the blue primary, where blue is 13.9 Y.

    `encode_log_luv` gives back 0, and each word with L > 0 whose cell has its middle
    inside the triangle; not, in general, other words.
    """
    level = words >> 18
    Y = np.where(level > 0, DARKEST * np.exp2((level + 0.5) / LEVELS_PER_STOP), 0.0)
    u, v = ((words >> bit & 511) + 0.5 for bit in (9, 0))
    u, v = u / CHROMA_SCALE, v / CHROMA_SCALE
    X, Z = Y * (9 * u) / (4 * v), Y * (12 - 3 * u - 20 * v) / (4 * v)
    xyz = vectors(X, Y, Z)
    return vectors(*(np.maximum(dot(xyz, row), 0.0) for row in XYZ_TO_RGB))
