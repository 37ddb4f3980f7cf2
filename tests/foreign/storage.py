"""How renderers store a reservoir between two passes, in fewer bits than float32."""

from dataclasses import replace

import numpy as np

from tests.foreign.kernels import F, unit


def half(x):
    """Numbers as float16 holds them; what is too large becomes its largest."""
    return np.clip(x, -65504, 65504).astype(np.float16).astype(F)


def rgbe(color):
    """Three mantissas of eight bits, with one exponent."""
    top = color.max(axis=-1, keepdims=True)
    # frexp is the exponent exactly, which a logarithm is not.
    step = np.ldexp(F(1), np.frexp(top)[1] - 8).astype(F)
    found = np.clip(np.rint(color / step), 0, 255) * step
    return np.where(top > 1e-30, found, F(0)).astype(F)


RED, GREEN, BLUE = (
    (0.412391, 0.212639, 0.019331),
    (0.357584, 0.715169, 0.119195),
    (0.180481, 0.072192, 0.950532),
)
TO_XYZ = np.array([RED, GREEN, BLUE]).T
TO_RGB = np.linalg.inv(TO_XYZ)
"""Rec. 709 to six digits."""


def log_luv(color):
    """Level and chromaticities in cells of equal steps, read in their middle."""
    X, Y, Z = (color.astype(F) @ TO_XYZ.T.astype(F)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.clip(F(409.6) * (np.log2(Y) + F(20)), 0, 16383)
        sum_of_three = X + F(15) * Y + F(3) * Z
        u, v = (F(820) * c / sum_of_three for c in (F(4) * X, F(9) * Y))
    level, u, v = (np.floor(np.nan_to_num(c)) for c in (level, u, v))
    Y = np.exp2((level + F(0.5)) / F(409.6) - F(20))
    u, v = ((np.clip(c, 0, 511) + F(0.5)) / F(820) for c in (u, v))
    X, Z = Y * F(9) * u / (F(4) * v), Y * (12 - F(3) * u - F(20) * v) / (F(4) * v)
    found = np.stack([X, Y, Z], axis=-1) @ TO_RGB.T.astype(F)
    return np.where(level[:, None] > 0, np.maximum(found, 0), F(0)).astype(F)


def octahedral(normal, bits=16):
    """Unit normals in two numbers of so many bits."""
    most = 2 ** (bits - 1) - 1
    size = np.abs(normal).sum(axis=-1, keepdims=True)
    p = normal / np.where(size > 0, size, F(1))
    folded = (1 - np.abs(p[..., 1::-1])) * np.where(p[..., :2] < 0, F(-1), F(1))
    uv = np.rint(np.where(p[..., 2:] < 0, folded, p[..., :2]) * most) / F(most)
    z = 1 - np.abs(uv).sum(axis=-1, keepdims=True)
    back = (1 - np.abs(uv[..., ::-1])) * np.where(uv < 0, F(-1), F(1))
    xy = np.where(z < 0, back, uv)
    found = unit(np.concatenate([xy, z], axis=-1).astype(F))
    return np.where(size > 0, found, normal).astype(F)


def as_it_is(R):
    """Float32 throughout."""
    return R


def half_radiance(R):
    """Radiance in float16."""
    return replace(R, radiance=half(R.radiance))


def half_weight(R):
    """W in float16."""
    return replace(R, W=half(R.W))


def eight_bit_radiance(R):
    """Radiance as RGBE."""
    return replace(R, radiance=rgbe(R.radiance))


def short_normals(R):
    """Normals in four bytes."""
    return replace(R, normal=octahedral(R.normal))


def in_32_bytes(R):
    """Place 12, normal 4, RGBE 4, W as float16, M as a byte; the rest is an age."""
    return replace(
        R,
        normal=octahedral(R.normal),
        radiance=rgbe(R.radiance),
        W=half(R.W),
        M=np.minimum(np.floor(R.M), 255).astype(F),
    )


def as_rtxdi(R):
    """Place 12, normal 4, LogLuv 4, W 4, M as a byte; the rest is an age and unused."""
    return replace(
        R,
        normal=octahedral(R.normal),
        radiance=log_luv(R.radiance),
        M=np.minimum(np.floor(R.M), 255).astype(F),
    )


STORAGES = {
    "float32": as_it_is,
    "half radiance": half_radiance,
    "half W": half_weight,
    "RGBE": eight_bit_radiance,
    "octahedral": short_normals,
    "32 bytes": in_32_bytes,
    "RTXDI": as_rtxdi,
}

MIXING = ("RTXDI",)
"""Formats in which light of one channel comes back with a little of the others.  A
pixel that reflects none of the one then counts in Z, though it never made the sample:
what comes of such light is biased."""

ROUNDING = {"half radiance": 0, "half W": 2**-11, "32 bytes": 2**-11}
"""Largest relative error of W; that of a sample is another sample, and no bias."""
