"""Packed GI reservoirs of RTXDI: 32 bytes, of which the last four are not used.

Facts, not code, of RTXDI: the fields from GI/ReSTIRGIParameters.h, their bits from
GI/Reservoir.hlsli, LogLuv and octahedral map from RtxdiMath.hlsli, and the order of a
buffer from Utils/ReservoirAddressing.hlsli, RtxdiParameters.h and RtxdiUtils.cpp.  The
visible point is not stored: it is taken from the G-buffer.  The code there runs in
float32, so a code may be the neighbour of ours where a value is within rounding of the
edge of a cell.  Not covered: checkerboard rendering, which halves the width.
"""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.resampling.packing.log_luv import (
    decode_log_luv,
    encode_log_luv,
)
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
        ("x_s", "<f4", 3),  # byte 0
        ("M", "u1"),  # 12: bits 7:0 of a word
        ("age", "u1"),  # 13: bits 15:8
        ("misc", "<u2"),  # 14: bits 31:16
        ("L_o", "<u4"),  # 16
        ("W", "<f4"),  # 20
        ("n_s", "<i2", 2),  # 24
        ("unused", "<u4"),  # 28
    ]
)
"""32 bytes, little-endian, no padding, each field aligned as C aligns it."""

BLOCK = 16
"""Pixels on a side of the blocks that a buffer consists of."""


def pack(r: Reservoirs, age: UInts, misc: UInts) -> NDArray[np.void]:
    """Reservoirs as RTXDI stores them.

    Parameters
    ----------
    r : Reservoirs; N rows, whose samples are `Samples`
    age : (N,) unsigned int; frames that the sample has survived
    misc : (N,) uint16
        The application's own; RTXDI writes 0.  Its functions take and return these bits
        shifted left by 16.

    Returns
    -------
    (N,) `RESERVOIR`
        Errors: position and W relative 2⁻²⁴, normal 6.474e-5 radians, radiance as
        stated for :func:`.log_luv.decode_log_luv`, M 1/2 and none where it is whole.
        M and age beyond 255 become 255, W beyond float32 its largest number, NaN 0.
        Rows with W = 0 stay nulls, with their M; radiance of a luminance below 9.553e-7
        becomes black.

    Raises
    ------
    ValueError
        A column that does not have N rows; one row serves all.
    """
    codes = np.zeros(len(r.W), RESERVOIR)
    codes["x_s"] = nearest_float(r.y.position, np.float32)
    codes["M"] = nearest_count(r.M, 255)
    codes["age"] = nearest_count(age, 255)
    codes["misc"] = misc
    codes["L_o"] = encode_log_luv(r.y.radiance)
    codes["W"] = nearest_float(r.W, np.float32)
    codes["n_s"] = encode_normal(r.y.normal)
    return codes


def unpack(codes: NDArray[np.void]) -> tuple[Reservoirs, UInts, UInts]:
    """Reservoirs as RTXDI stored them.

    Any bits give finite numbers: an infinite float is read as the largest one, NaN as
    0.  `pack` gives back the same bits, unless there was one of these, a normal or a
    radiance whose code is not written, or something in the unused bytes.

    Parameters
    ----------
    codes : (N,) `RESERVOIR`
        As from ``np.fromfile(dump, RESERVOIR)[buffer_index(width, height)]``.

    Returns
    -------
    r : Reservoirs
        N rows of float64 and `Samples`.  W is what RTXDI calls the weight, after its
        finalization.
    age : (N,) uint8; frames that the sample has survived
    misc : (N,) uint16; the application's own
    """
    y = Samples(
        position=widened(codes["x_s"]),
        normal=decode_normal(codes["n_s"]),
        radiance=decode_log_luv(codes["L_o"]),
    )
    r = Reservoirs(y=y, W=widened(codes["W"]), M=codes["M"].astype(np.float64))
    return r, codes["age"].copy(), codes["misc"].copy()


def buffer_index(width: int, height: int) -> Indices:
    """Where the reservoir of each row of a frame stands in a buffer of RTXDI.

    Blocks of 16 × 16 pixels follow each other in rows of blocks, and within a block the
    pixels in rows; blocks at the right and lower edge are stored whole.

    Returns
    -------
    (N,) int64
        For row y · width + x of N = width · height.  Add k · 256 · ⌈width / 16⌉ ·
        ⌈height / 16⌉ for the buffer of number k.
    """
    y, x = np.divmod(np.arange(width * height), width)
    blocks_across = -(-width // BLOCK)
    block = (y // BLOCK) * blocks_across + x // BLOCK
    index: Indices = (block * BLOCK + y % BLOCK) * BLOCK + x % BLOCK
    return index
