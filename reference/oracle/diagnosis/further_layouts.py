"""Known mistakes with the layouts of reservoirs that have to be declared.

Those with octahedral normals are among the others: they show in every layout that has
them.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from restir_gi.reference.oracle.diagnosis.further_packing import BITS, PACK, UNPACK
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, mistake
from restir_gi.reference.oracle.replay.further.layout_rules import (
    BYTE,
    PathRules,
    RtxdiRules,
    counts_of_rtxdi,
)
from restir_gi.reference.oracle.replay.further.rules import FurtherRules
from restir_gi.reference.oracle.replay.log_luv import LogLuv
from restir_gi.reference.resampling.packing.rounding import UInts

COUNTS_RIGHT = "word 3: M in bits 7:0, age in 15:8, misc in 31:16"
M_RIGHT = "M and age are 255 at most"
LEVEL_RIGHT = "L = ⌊409.6 (log₂ Y + 20)⌋"
WORD_11_RIGHT = "word 11: age in bits 4:0, boosts in bit 7, reconnection_vertex in 15:8"
NORMAL_RIGHT = "32767 (n + 1), rounded to nearest"
HALF_RIGHT = "M is a float16, 65504 at most"


def _moved(size: int, *to: tuple[int, Iterable[int]]) -> tuple[int, ...]:
    """Places of bytes, of which runs stand elsewhere.

    Parameters
    ----------
    size : int; bytes of a layout
    *to : (int, iterable of int); a byte of the layout, and where it and the next stand
    """
    places = list(range(size))
    for first, found in to:
        for k, place in enumerate(found):
            places[first + k] = place
    return tuple(places)


def _exchanged(size: int, one: int, other: int, width: int) -> tuple[int, ...]:
    """Places of bytes, of which two runs change places."""
    runs = range(one, one + width), range(other, other + width)
    return _moved(size, (one, runs[1]), (other, runs[0]))


def _rtxdi(**rules: Any) -> FurtherRules:
    return FurtherRules(rtxdi=RtxdiRules(**rules))


def _luv(**rules: bool) -> FurtherRules:
    return _rtxdi(log_luv=LogLuv(**rules))


def _path(**rules: Any) -> FurtherRules:
    return FurtherRules(rtxdi_path=PathRules(**rules))


# ------------------------------------------------ 32 bytes of RTXDI


def _M_runs_over(M: UInts, age: UInts, misc: UInts) -> UInts:
    return M | counts_of_rtxdi(np.zeros_like(M), age, misc)


def _M_wraps(M: UInts, age: UInts, misc: UInts) -> UInts:
    return counts_of_rtxdi(M & BYTE, age, misc)


def _age_runs_over(M: UInts, age: UInts, misc: UInts) -> UInts:
    return counts_of_rtxdi(M, np.zeros_like(age), misc) | age << np.uint32(8)


def _age_wraps(M: UInts, age: UInts, misc: UInts) -> UInts:
    return counts_of_rtxdi(M, age & BYTE, misc)


def _without_misc(M: UInts, age: UInts, misc: UInts) -> UInts:
    return counts_of_rtxdi(M, age, np.zeros_like(misc))


RTXDI = (
    mistake(
        "rtxdi-m-and-age-exchanged",
        "M and the age change places",
        "word 3: age in bits 7:0, M in 15:8",
        COUNTS_RIGHT,
        BITS,
        part=_rtxdi(bytes=_exchanged(32, 12, 13, 1)),
    ),
    mistake(
        "rtxdi-misc-below",
        "the application's bits stand below M and the age",
        "word 3: misc in bits 15:0, M in 23:16, age in 31:24",
        COUNTS_RIGHT,
        BITS,
        part=_rtxdi(bytes=_exchanged(32, 12, 14, 2)),
    ),
    mistake(
        "rtxdi-w-before-radiance",
        "W stands before the radiance",
        "word 4: W; word 5: radiance",
        "word 4: radiance; word 5: W",
        BITS,
        part=_rtxdi(bytes=_exchanged(32, 16, 20, 4)),
    ),
    mistake(
        "rtxdi-normal-last",
        "the word that is not used stands before the normal",
        "word 6: not used; word 7: normal",
        "word 6: normal; word 7: not used",
        BITS,
        part=_rtxdi(bytes=_exchanged(32, 24, 28, 4)),
    ),
    mistake(
        "rtxdi-m-runs-over",
        "an M that is too large fills the bits of the age",
        "M | age << 8 | misc << 16",
        M_RIGHT,
        PACK,
        part=_rtxdi(counts=_M_runs_over),
    ),
    mistake(
        "rtxdi-m-wraps",
        "an M that is too large starts over at 0",
        "M mod 256",
        M_RIGHT,
        PACK,
        part=_rtxdi(counts=_M_wraps),
    ),
    mistake(
        "rtxdi-age-runs-over",
        "an age that is too large fills the application's bits",
        "M | age << 8 | misc << 16",
        M_RIGHT,
        PACK,
        part=_rtxdi(counts=_age_runs_over),
    ),
    mistake(
        "rtxdi-age-wraps",
        "an age that is too large starts over at 0, and the sample is young again",
        "age mod 256",
        M_RIGHT,
        PACK,
        part=_rtxdi(counts=_age_wraps),
    ),
    mistake(
        "rtxdi-misc-left-out",
        "the application's bits become 0",
        "word 3: 0 in bits 31:16",
        COUNTS_RIGHT,
        PACK,
        part=_rtxdi(counts=_without_misc),
    ),
    mistake(
        "log-luv-natural",
        "the logarithm of the luminance is to the base e",
        "L = ⌊409.6 (ln Y + 20)⌋",
        LEVEL_RIGHT,
        BITS,
        part=_luv(natural=True),
    ),
    mistake(
        "log-luv-rounded",
        "level and chromaticities are rounded, although they are read at the middle",
        "L = [409.6 (log₂ Y + 20)], [820 u′], [820 v′]",
        f"{LEVEL_RIGHT}, ⌊820 u′⌋, ⌊820 v′⌋",
        PACK,
        part=_luv(rounded=True),
    ),
    mistake(
        "log-luv-without-half",
        "a cell is read at its lower edge: all light becomes darker",
        "log₂ Y = L / 409.6 − 20, u′ = u / 820, v′ = v / 820",
        "log₂ Y = (L + 1/2) / 409.6 − 20, u′ = (u + 1/2) / 820, v′ = (v + 1/2) / 820",
        UNPACK,
        part=_luv(at_edge=True),
    ),
    mistake(
        "log-luv-v-first",
        "the two chromaticities change places",
        "v′ in bits 17:9, u′ in 8:0",
        "u′ in bits 17:9, v′ in 8:0",
        BITS,
        part=_luv(v_first=True),
    ),
    mistake(
        "log-luv-negative",
        "channels of cells that are no colour are left below 0",
        "R, G, B of X, Y, Z",
        "max(0, R), max(0, G), max(0, B)",
        UNPACK,
        part=_luv(negative=True),
    ),
)


# ------------------------------------------------ 64 bytes of RTXDI


def _whole_age(age: UInts, boosts: UInts) -> UInts:
    return age | boosts << np.uint32(7)


def _oldest(age: UInts, boosts: UInts) -> UInts:
    held: UInts = np.minimum(age, np.uint32(31)) | boosts << np.uint32(7)
    return held


def _boosts_above_age(age: UInts, boosts: UInts) -> UInts:
    return age & np.uint32(31) | boosts << np.uint32(5)


def _whole_byte(byte: UInts) -> tuple[UInts, UInts]:
    return byte, byte >> np.uint32(7)


def _bit_5(byte: UInts) -> tuple[UInts, UInts]:
    return byte & np.uint32(31), byte >> np.uint32(5) & np.uint32(1)


PATH = (
    mistake(
        "rtxdi-path-m-below-z",
        "M stands below z of the normal",
        "word 5: M in bits 15:0, z in 31:16",
        "word 5: z in bits 15:0, M in 31:16",
        BITS,
        part=_path(bytes=_exchanged(64, 20, 22, 2)),
    ),
    mistake(
        "rtxdi-path-density-before-jacobian",
        "the density stands before the Jacobian",
        "word 6: onward_pdf; word 7: partial_jacobian",
        "word 6: partial_jacobian; word 7: onward_pdf",
        BITS,
        part=_path(bytes=_exchanged(64, 24, 28, 4)),
    ),
    mistake(
        "rtxdi-path-target-before-radiance",
        "the target function and the radiance change places",
        "words 8 to 10: target_function; 12 to 14: radiance",
        "words 8 to 10: radiance; 12 to 14: target_function",
        BITS,
        part=_path(bytes=_exchanged(64, 32, 48, 12)),
    ),
    mistake(
        "rtxdi-path-lengths-exchanged",
        "the vertex where it is joined and the length of the path change places",
        "word 11: path_length in bits 15:8, reconnection_vertex in 23:16",
        "word 11: reconnection_vertex in bits 15:8, path_length in 23:16",
        BITS,
        part=_path(bytes=_exchanged(64, 45, 46, 1)),
    ),
    mistake(
        "rtxdi-path-age-above",
        "the age stands in the highest byte, and the others in the other order, too",
        "word 11: random_index in bits 7:0, … age in 28:24, boosts in 31",
        WORD_11_RIGHT,
        BITS,
        part=_path(bytes=_moved(64, (44, range(47, 43, -1)))),
    ),
    mistake(
        "rtxdi-path-age-runs-over",
        "an age that is too large fills the bits above it",
        "age | boosts << 7 | reconnection_vertex << 8 | …",
        WORD_11_RIGHT,
        PACK,
        part=_path(flags=_whole_age),
    ),
    mistake(
        "rtxdi-path-age-not-masked",
        "the age is read with the bits above it",
        "age = word & 0xFF",
        "age = word & 31",
        UNPACK,
        part=_path(flags_read=_whole_byte),
    ),
    mistake(
        "rtxdi-path-age-stops",
        "an age that is too large becomes the largest",
        "min(age, 31)",
        "age & 31",
        PACK,
        part=_path(flags=_oldest),
    ),
    mistake(
        "rtxdi-path-boosts-in-bit-5",
        "the flag stands right above the age",
        "word 11: boosts in bit 5",
        "word 11: boosts in bit 7",
        BITS,
        part=_path(flags=_boosts_above_age, flags_read=_bit_5),
    ),
    mistake(
        "rtxdi-path-normal-with-sign",
        "components of normals are numbers with a sign",
        "the int16 of 32767 n",
        "the uint16 of 32767 (n + 1)",
        BITS,
        part=_path(offset=False),
    ),
    mistake(
        "rtxdi-path-normals-cut",
        "components of normals are cut off",
        "uint(32767 (n + 1))",
        NORMAL_RIGHT,
        PACK,
        part=_path(cut=True),
    ),
    mistake(
        "rtxdi-path-normals-not-normalized",
        "normals that were read are not made unit vectors",
        "n = codes / 32767 − 1",
        "n = codes / 32767 − 1, and divided by its length",
        UNPACK,
        part=_path(normalized=False),
    ),
    mistake(
        "rtxdi-path-m-overflows",
        "an M that is too large for a half becomes infinity",
        "infinity from 65520 upwards",
        HALF_RIGHT,
        PACK,
        "RTXDI, where M may be capped at 65535",
        part=_path(overflows=True),
    ),
    mistake(
        "rtxdi-path-m-is-a-count",
        "M is stored as a whole number",
        "M is a uint16",
        HALF_RIGHT,
        BITS,
        part=_path(half=False),
    ),
    mistake(
        "rtxdi-path-light-not-marked",
        "radiance is stored, and read, where a light was sampled",
        "words 8 to 10: radiance, whatever on_light is",
        "words 8 to 10: infinity, light, light_place where on_light is 1",
        BITS,
        part=_path(marked=False),
    ),
)

LAYOUT_MISTAKES: tuple[Hypothesis, ...] = (*RTXDI, *PATH)
