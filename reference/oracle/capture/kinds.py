"""Kinds of numbers in a buffer: bytes in, values out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize, vectors
from restir_gi.reference.resampling.packing.log_luv import decode_log_luv
from restir_gi.reference.resampling.packing.octahedral import decode_normal

# Values as they stand in the buffer, (N, count).
Codes = NDArray[Any]


@dataclass(frozen=True, slots=True)
class NumberKind:
    """How a value is stored.

    Attributes
    ----------
    dtype : str; of a part as NumPy names it, without a byte order
    parts : int; of that type that make one value
    columns : int; numbers that a value is decoded to
    decode : callable; (N, parts) codes to (N, columns) values
    meaning : str; in one line
    unit : int; code of 1, where it may be another one; else 0
    """

    dtype: str
    parts: int
    columns: int
    decode: Callable[[Codes, int], Scalars]
    meaning: str
    unit: int = 0

    @property
    def size(self) -> int:
        """Bytes of a value."""
        return self.parts * np.dtype(self.dtype).itemsize

    @property
    def is_word(self) -> bool:
        """Whether it is a plain word, of which bits can be taken."""
        return self.decode is _as_it_is and self.dtype.startswith("u")

    @property
    def has_unit(self) -> bool:
        """Whether a field may say which code is 1."""
        return self.columns == 3 and self.unit > 1


def _as_it_is(codes: Codes, unit: int) -> Scalars:
    return codes


def _unorm(codes: Codes, unit: int) -> Scalars:
    return codes / float(unit)


def _snorm(codes: Codes, unit: int) -> Scalars:
    return np.maximum(codes / float(unit), -1.0)


def _from_square(codes: Codes, unit: int) -> Vec3s:
    """Normals whose octahedral coordinates are -1 to 1."""
    u, v = (np.clip(codes[:, i] / float(unit), -1.0, 1.0) for i in range(2))
    return _unfold(u, v)


def _from_unit_square(codes: Codes, unit: int) -> Vec3s:
    """Normals whose octahedral coordinates were moved from -1 … 1 to 0 … 1."""
    u, v = (np.clip(2.0 * codes[:, i] / float(unit) - 1.0, -1, 1) for i in range(2))
    return _unfold(u, v)


def _unfold(u: Scalars, v: Scalars) -> Vec3s:
    z = 1.0 - abs(u) - abs(v)
    sign_u, sign_v = np.where(u < 0, -1.0, 1.0), np.where(v < 0, -1.0, 1.0)
    x = np.where(z < 0, (1.0 - abs(v)) * sign_u, u)
    y = np.where(z < 0, (1.0 - abs(u)) * sign_v, v)
    return normalize(vectors(x, y, z))


def _whole_octahedral(codes: Codes, unit: int) -> Vec3s:
    return decode_normal(codes) if unit == 32767 else _from_square(codes, unit)


def _log_luv(codes: Codes, unit: int) -> Vec3s:
    return decode_log_luv(codes[:, 0].astype(np.uint32))


def _shared_exponent(codes: Codes, unit: int) -> Vec3s:
    """Three mantissas of 9 bits from bit 0 on, and an exponent in bits 31:27."""
    word = codes[:, 0].astype(np.int64)
    step = np.exp2((word >> 27) - 24.0)
    return vectors(*((word >> bit & 511) * step for bit in (0, 9, 18)))


def _small_floats(codes: Codes, unit: int) -> Vec3s:
    """Floats without a sign: exponents of 5 bits over mantissas of 6, 6 and 5."""
    word = codes[:, 0].astype(np.int64)
    red, green, blue = word & 2047, word >> 11 & 2047, word >> 22
    # Under a half's four or five lowest bits they are halves.
    halves = vectors(red << 4, green << 4, blue << 5).astype(np.uint16)
    return np.ascontiguousarray(halves).view(np.float16).astype(np.float64)


def _octahedral(
    dtype: str, square: Callable[[Codes, int], Vec3s], unit: int
) -> NumberKind:
    ends = "−1 to 1" if square is not _from_unit_square else "0 to 1"
    return NumberKind(
        dtype, 2, 3, square, f"unit vector, octahedral: u, v from {ends}", unit
    )


def _norm(bits: int, signed: bool) -> NumberKind:
    if signed:
        unit, lower = 2 ** (bits - 1) - 1, ", not below −1"
        return NumberKind(f"i{bits // 8}", 1, 1, _snorm, f"code / {unit}{lower}", unit)
    unit = 2**bits - 1
    return NumberKind(f"u{bits // 8}", 1, 1, _unorm, f"code / {unit}", unit)


KINDS: Mapping[str, NumberKind] = {
    "float16": NumberKind("f2", 1, 1, _as_it_is, "half"),
    "float32": NumberKind("f4", 1, 1, _as_it_is, "single"),
    "float64": NumberKind("f8", 1, 1, _as_it_is, "double"),
    "uint8": NumberKind("u1", 1, 1, _as_it_is, "whole number, 0 to 255"),
    "uint16": NumberKind("u2", 1, 1, _as_it_is, "whole number, 0 to 65535"),
    "uint32": NumberKind("u4", 1, 1, _as_it_is, "whole number, 0 to 2³² − 1"),
    "uint64": NumberKind("u8", 1, 1, _as_it_is, "word of which `bits` are taken"),
    "int8": NumberKind("i1", 1, 1, _as_it_is, "whole number, −128 to 127"),
    "int16": NumberKind("i2", 1, 1, _as_it_is, "whole number, −32768 to 32767"),
    "int32": NumberKind("i4", 1, 1, _as_it_is, "whole number, −2³¹ to 2³¹ − 1"),
    "unorm8": _norm(8, signed=False),
    "unorm16": _norm(16, signed=False),
    "unorm32": _norm(32, signed=False),
    "snorm8": _norm(8, signed=True),
    "snorm16": _norm(16, signed=True),
    "octahedral-snorm8": _octahedral("i1", _from_square, 127),
    "octahedral-snorm16": _octahedral("i2", _whole_octahedral, 32767),
    "octahedral-unorm8": _octahedral("u1", _from_unit_square, 255),
    "octahedral-unorm16": _octahedral("u2", _from_unit_square, 65535),
    "octahedral-float16": _octahedral("f2", _from_square, 1),
    "octahedral-float32": _octahedral("f4", _from_square, 1),
    "octahedral-unsigned-float16": _octahedral("f2", _from_unit_square, 1),
    "octahedral-unsigned-float32": _octahedral("f4", _from_unit_square, 1),
    "logluv32": NumberKind("u4", 1, 3, _log_luv, "radiance, LogLuv as RTXDI has it"),
    "rgb9e5": NumberKind("u4", 1, 3, _shared_exponent, "three numbers of one exponent"),
    "r11g11b10f": NumberKind("u4", 1, 3, _small_floats, "three floats without a sign"),
}
"""All kinds, by the names that manifests have."""
