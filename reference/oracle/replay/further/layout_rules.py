"""What layouts of reservoirs are replayed with: the contract, or a known mistake."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.oracle.replay.log_luv import LogLuv
from restir_gi.reference.resampling.packing.rounding import UInts

BYTE = np.uint32(255)
LOG_LUV = LogLuv()


@dataclass(frozen=True, slots=True)
class Octahedron:
    """Normals as two integers.

    Attributes
    ----------
    folds : bool; the lower half is folded outward, over the sides of the upper one
    divided : bool; by |x| + |y| + |z|; else (u, v) = (x, y)
    steps : int; code of the coordinate 1
    v_first : bool; v stands in the lower bits
    toward_zero : bool; rounded toward 0, not to nearest
    runs_over : bool; the sign of a negative u fills the bits of v
    signed : bool; codes are read as numbers with a sign
    normalized : bool; what was read is made a unit vector
    """

    folds: bool = True
    divided: bool = True
    sign_of_zero: int = 1
    steps: int = 32767
    v_first: bool = False
    toward_zero: bool = False
    runs_over: bool = False
    signed: bool = True
    normalized: bool = True


OCTAHEDRON = Octahedron()


def counts_of_rtxdi(M: UInts, age: UInts, misc: UInts) -> UInts:
    """Word 3 of layout rtxdi.

    Parameters
    ----------
    M, age, misc : (N,) uint32

    Returns
    -------
    (N,) uint32
        M in bits 7:0 and age in 15:8, 255 at most; misc in 31:16.
    """
    held = np.minimum(M, BYTE), np.minimum(age, BYTE)
    word: UInts = held[0] | held[1] << np.uint32(8) | misc << np.uint32(16)
    return word


def flags_of_path(age: UInts, boosts: UInts) -> UInts:
    """Word 11 of layout rtxdi_path, but for its upper three bytes.

    Parameters
    ----------
    age, boosts : (N,) uint32

    Returns
    -------
    (N,) uint32
        The low five bits of the age, and boosts in bit 7; what runs over is there too.
    """
    return age & np.uint32(31) | boosts << np.uint32(7)


def age_and_boosts(byte: UInts) -> tuple[UInts, UInts]:
    """What is read of the lowest byte of word 11 of layout rtxdi_path.

    Parameters
    ----------
    byte : (N,) uint32; from 0 to 255

    Returns
    -------
    age, boosts : (N,) uint32
    """
    return byte & np.uint32(31), byte >> np.uint32(7)


@dataclass(frozen=True, slots=True)
class RtxdiRules:
    """Layout rtxdi.

    Attributes
    ----------
    bytes : tuple of int; at which byte of 32 each byte of the layout stands
    counts : callable; as the function of this module
    """

    bytes: tuple[int, ...] = tuple(range(32))
    log_luv: LogLuv = LOG_LUV
    counts: Callable[[UInts, UInts, UInts], UInts] = counts_of_rtxdi


RTXDI_RULES = RtxdiRules()


@dataclass(frozen=True, slots=True)
class PathRules:
    """Layout rtxdi_path.

    Attributes
    ----------
    bytes : tuple of int; at which byte of 64 each byte of the layout stands
    offset : bool; a component of 0 has the code 32767, and no code has a sign
    cut : bool; components are rounded down
    normalized : bool; normals that were read are made unit vectors
    half : bool; M is a float16; else a uint16
    overflows : bool; an M that is too large becomes infinity
    flags, flags_read : callable
        As `flags_of_path` and `age_and_boosts`.
    marked : bool; a light that was sampled is told from radiance
    """

    bytes: tuple[int, ...] = tuple(range(64))
    offset: bool = True
    cut: bool = False
    normalized: bool = True
    half: bool = True
    overflows: bool = False
    flags: Callable[[UInts, UInts], UInts] = flags_of_path
    flags_read: Callable[[UInts], tuple[UInts, UInts]] = age_and_boosts
    marked: bool = True


PATH_RULES = PathRules()
