"""The reservoir of the paper in 48 bytes, and the memory of all its buffers."""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.resampling.packing.octahedral import (
    decode_normal,
    encode_normal,
)
from restir_gi.reference.resampling.packing.rounding import (
    UInts,
    nearest_count,
    nearest_float,
    widened,
)
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples

RESERVOIR = np.dtype(
    [
        ("x_v", "<f4", 3),  # byte 0
        ("n_v", "<i2", 2),  # 12
        ("x_s", "<f4", 3),  # 16
        ("n_s", "<i2", 2),  # 28
        ("L_o", "<f2", 3),  # 32
        ("M", "<u2"),  # 38
        ("W", "<f4"),  # 40
        ("seed", "<u4"),  # 44
    ]
)
"""Little-endian, no padding, each field aligned as C aligns it.

The paper says which fields there are and that they take 48 bytes.  Their order is that
of ReSTIR_PT: M stands before W, which else would begin at byte 38.
"""

BUFFERS = 5
"""Initial reservoirs, and two of temporal and of spatial ones: read one, write one."""


def pack(x_v: Vec3s, n_v: Vec3s, r: Reservoirs, seed: UInts) -> NDArray[np.void]:
    """Reservoirs as 48 bytes each.

    [Ouyang21, section 5].  The running w is not stored: it is rebuilt from W and M.
    Rounding is not dithered, so each error is a bias of its size at most.

    Parameters
    ----------
    x_v, n_v : (N, 3) float, m and 1
        Visible points that own the reservoirs, and their unit normals.
    r : Reservoirs; N rows, whose samples are `Samples`
    seed : (N,) uint32; what the path of the sample was drawn with

    Returns
    -------
    (N,) `RESERVOIR`
        Rounded to nearest.  Errors: positions and W relative 2⁻²⁴, a channel of L_o
        relative 2⁻¹¹ from 2⁻¹⁴ upwards and absolute 2⁻²⁵ below, normals 6.474e-5
        radians, M 1/2 and none where it is whole.  What is too large for its field, as
        radiance beyond 65504 and M beyond 65535, becomes the largest number that fits;
        NaN becomes 0.  Rows with W = 0 stay nulls, with their M.

    Raises
    ------
    ValueError
        A column that does not have N rows; one row serves all.
    """
    codes = np.zeros(len(r.W), RESERVOIR)
    codes["x_v"] = nearest_float(x_v, np.float32)
    codes["n_v"] = encode_normal(n_v)
    codes["x_s"] = nearest_float(r.y.position, np.float32)
    codes["n_s"] = encode_normal(r.y.normal)
    codes["L_o"] = nearest_float(r.y.radiance, np.float16)
    codes["M"] = nearest_count(r.M, 65535)
    codes["W"] = nearest_float(r.W, np.float32)
    codes["seed"] = seed
    return codes


def unpack(codes: NDArray[np.void]) -> tuple[Vec3s, Vec3s, Reservoirs, UInts]:
    """Reservoirs from 48 bytes each: all that `pack` was given, as it was rounded.

    [Ouyang21, section 5].  Any bits give finite numbers: an infinite half is read as
    ±65504, an infinite float as the largest one, NaN as 0.  `pack` gives back the same
    bits, unless there was one of these, or a normal whose code `encode_normal` does not
    write.

    Parameters
    ----------
    codes : (N,) `RESERVOIR`; made by `pack`, or read from elsewhere

    Returns
    -------
    x_v, n_v : (N, 3) float64, m and 1; visible points and their unit normals
    r : Reservoirs; N rows of float64 and `Samples`
    seed : (N,) uint32; as stored
    """
    y = Samples(
        position=widened(codes["x_s"]),
        normal=decode_normal(codes["n_s"]),
        radiance=widened(codes["L_o"]),
    )
    r = Reservoirs(y=y, W=widened(codes["W"]), M=codes["M"].astype(np.float64))
    return widened(codes["x_v"]), decode_normal(codes["n_v"]), r, codes["seed"].copy()


def buffer_bytes(width: int, height: int) -> int:
    """Memory of all reservoirs of a frame: 5 buffers of 48 bytes a pixel.

    [Ouyang21, section 5] prints 475 MB for it.  Without the G-buffer.

    Bytes: 474.6 · 2²⁰ for 1920 × 1080.
    """
    return BUFFERS * RESERVOIR.itemsize * width * height
