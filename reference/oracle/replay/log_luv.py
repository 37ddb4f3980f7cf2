"""Replay of radiance as a logarithm of luminance, and chromaticities."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.judgement import Compared, between, in_rows
from restir_gi.reference.oracle.replay.verbs import choose
from restir_gi.reference.resampling.packing.log_luv import (
    CHROMA_SCALE,
    LEVELS_PER_STOP,
    RGB_TO_XYZ,
    XYZ_TO_RGB,
    encode_log_luv,
)

STOPS, MOST_LEVEL, MOST_CHROMA = 20.0, 16383.0, 511.0

DARK = 2.0**-40
"""A luminance far below the first level, in place of all that is darker."""

CHANNEL = 0.09
"""By how much of its luminance channels may change, from 9.553e-7 upwards."""

BRIGHTEST = 2.0 ** (MOST_LEVEL / LEVELS_PER_STOP - STOPS)
"""Luminance of the highest level, in which all that is brighter is too."""

Words = NDArray[np.uint32]


@dataclass(frozen=True, slots=True)
class LogLuv:
    """Radiance as a logarithm of luminance, and chromaticities.

    Attributes
    ----------
    natural : bool; the logarithm is to the base e
    rounded : bool; written is the nearest edge of a cell, not the one below
    at_edge : bool; a cell is read at its lower edge, not at its middle
    v_first : bool; v′ stands above u′
    negative : bool; channels below 0 are kept
    """

    natural: bool = False
    rounded: bool = False
    at_edge: bool = False
    v_first: bool = False
    negative: bool = False


def binary_logarithm(x: Bounded) -> Bounded:
    """Logarithms to the base 2, (N,).

    Devices calculate them to 3 units in the last place, or to 2⁻²¹ between 1/2 and 2:
    these are less than two of `Rounding.unit`, of the result or of 1.  So is a natural
    logarithm that is divided.

    Parameters
    ----------
    x : Bounded; (N,), above 0
    """
    value = np.log2(x.value)
    share = np.minimum(x.error / x.value, 0.5)
    own = 2 * x.rounding.unit * np.maximum(np.abs(value), 1.0)
    return Bounded(value, own - np.log2(1 - share), x.rounding)


def power_of_2(x: Bounded) -> Bounded:
    """Powers of 2, (N,).

    Devices calculate 2^x to 3 + 2 |x| units in the last place, that is 1.5 + |x| of
    `Rounding.unit`.  As a power of any base it is that of x log₂ 2, with the error of
    the logarithm: 2⁻²¹ |x| in the exponent, 1.4 |x| units of the result.

    Parameters
    ----------
    x : Bounded; (N,)
    """
    value = np.exp2(x.value)
    own = (2 + 3 * np.abs(x.value)) * x.rounding.unit
    return Bounded(value, value * (np.expm1(np.log(2) * x.error) + own), x.rounding)


@dataclass(frozen=True, slots=True, eq=False)
class OpenCell:
    """A code that is the floor of a number with an error, N rows.

    Attributes
    ----------
    name : str; what it stands for
    least, most : (N,) float64; the codes that rounding leaves open
    """

    name: str
    least: Scalars
    most: Scalars


def cells_of(given: Bounded, rules: LogLuv) -> tuple[OpenCell, OpenCell, OpenCell]:
    """Cells of colours: of the level, of u′ and of v′.

    Parameters
    ----------
    given : Bounded; (N, 3), not negative
    """
    X, Y, Z = (_row(given, row) for row in RGB_TO_XYZ)
    lit = Bounded(np.maximum(Y.value, DARK), Y.error, Y.rounding)
    level = binary_logarithm(lit)
    if rules.natural:
        level = level * constant(float(np.log(2)), level)
    level = (level + constant(STOPS, level)) * constant(LEVELS_PER_STOP, level)
    divisor = X + constant(15.0, X) * Y + constant(3.0, X) * Z
    u, v = (
        constant(CHROMA_SCALE, X) * (constant(factor, X) * of) / divisor
        for factor, of in ((4.0, X), (9.0, Y))
    )
    return (
        _cell("L", level, MOST_LEVEL, rules),
        _cell("u′", u, MOST_CHROMA, rules),
        _cell("v′", v, MOST_CHROMA, rules),
    )


def as_log_luv(
    words: Words, given: Vec3s, rules: LogLuv, rounding: Rounding
) -> tuple[Compared, ...]:
    """LogLuv words beside those of what they stand for.

    Where a number is about a whole one, both cells are allowed.  Of black the
    chromaticities are not looked at.

    Parameters
    ----------
    words : (N,) uint32; by the backend
    given : (N, 3) float; radiance, not negative
    """
    found = _codes(words, rules)
    L, u, v = (
        between(f"words: {cell.name} of radiance", code, cell.least, cell.most)
        for cell, code in zip(
            cells_of(exact(given, rounding), rules), found, strict=True
        )
    )
    lit = found[0] > 0
    return L, in_rows(lit, u), in_rows(lit, v)


def _row(rgb: Bounded, row: Scalars) -> Bounded:
    """A row of a matrix times vectors, (N,)."""
    terms = [constant(float(c), rgb[:, i]) * rgb[:, i] for i, c in enumerate(row)]
    return terms[0] + terms[1] + terms[2]


def _codes(words: Words, rules: LogLuv) -> tuple[Scalars, Scalars, Scalars]:
    """L, u′ and v′ of words."""
    upper, lower = words >> np.uint32(9) & np.uint32(511), words & np.uint32(511)
    u, v = (lower, upper) if rules.v_first else (upper, lower)
    level, first, second = (
        code.astype(np.float64) for code in (words >> np.uint32(18), u, v)
    )
    return level, first, second


def _cell(name: str, number: Bounded, most: float, rules: LogLuv) -> OpenCell:
    shift = 0.5 if rules.rounded else 0.0
    # Of black, where the divisor is 0, any chromaticity will do.
    error = np.minimum(number.error, most + 1)
    ends = (number.value + sign * error + shift for sign in (-1, 1))
    return OpenCell(name, *(np.clip(np.floor(end), 0.0, most) for end in ends))


def read_log_luv(words: Words, rules: LogLuv, rounding: Rounding) -> Bounded:
    """Colours of LogLuv words, as a backend calculates them in its own type.

    Parameters
    ----------
    words : (N,) uint32

    Returns
    -------
    Bounded; (N, 3)
    """
    return read_codes(_codes(words, rules), rules, rounding)


def read_codes(codes: Sequence[Scalars], rules: LogLuv, rounding: Rounding) -> Bounded:
    """Colours of a level and chromaticities, (N, 3).

    By way of the chromaticities x and y, which rounds most.

    Parameters
    ----------
    codes : three of (N,) float64; L, u′ and v′, whole
    """
    half = 0.0 if rules.at_edge else 0.5
    L, u, v = (exact(code + half, rounding) for code in codes)
    exponent = L / constant(LEVELS_PER_STOP, L) - constant(STOPS, L)
    if rules.natural:
        exponent = exponent * constant(float(1 / np.log(2)), L)
    Y = power_of_2(exponent)
    u, v = (c / constant(CHROMA_SCALE, L) for c in (u, v))
    divisor = constant(6.0, u) * u - constant(16.0, u) * v + constant(12.0, u)
    x, y = constant(9.0, u) * u / divisor, constant(4.0, u) * v / divisor
    scale = Y / y
    xyz = _columns([scale * x, Y, scale * (constant(1.0, x) - x - y)])
    color = _columns([_row(xyz, row) for row in XYZ_TO_RGB])
    if not rules.negative:
        # A maximum moves by no more than the number does.
        color = Bounded(np.maximum(color.value, 0.0), color.error, rounding)
    return choose(codes[0] > 0, color, exact(np.zeros_like(color.value), rounding))


def _columns(parts: list[Bounded]) -> Bounded:
    """Numbers side by side, (N, 3)."""
    value, error = (
        np.stack([getattr(part, n) for part in parts], axis=1)
        for n in ("value", "error")
    )
    return Bounded(value, error, parts[0].rounding)


def stored_in_log_luv(color: Bounded) -> Bounded:
    """Colours that may have been stored as LogLuv, or not.

    A colour that is known exactly is moved to the middle of its cell, or of one of the
    next, where rounding leaves open which it is.  One that has been stored is in the
    middle already, unless that was cut off: then no more is known than how far any
    colour is moved.  Of what is brighter than the brightest level nothing is known.

    Parameters
    ----------
    color : Bounded; (N, 3), not negative
    """
    known = (color.error == 0).all(axis=1) & color.value.any(axis=1)
    luminance = (color.value + color.error) @ RGB_TO_XYZ[1]
    error = color.error + CHANNEL * luminance[:, None]
    if known.any():
        error[known] = _moved(exact(color.value[known], color.rounding))
    error[luminance > BRIGHTEST] = np.inf
    return Bounded(color.value, error, color.rounding)


def _moved(color: Bounded) -> Scalars:
    """How far each channel may be from what it becomes, (N, 3)."""
    cells = [(c.least, c.most) for c in cells_of(color, LogLuv())]
    error = np.zeros_like(color.value)
    for codes in product(*cells):
        stored = read_codes(codes, LogLuv(), color.rounding)
        error = np.maximum(error, np.abs(stored.value - color.value) + stored.error)
    return error


def beside_log_luv(radiance: Scalars) -> Compared:
    """Colours beside those of the nearest cells, to the rounding of a decoder.

    A colour with a channel of 0 may have been cut off, and is not looked at; nor is
    what is brighter than the brightest level.

    Parameters
    ----------
    radiance : (N, 3) float, W/(m² sr); as a backend gives it
    """
    wide = radiance.astype(np.float64)
    stored = read_log_luv(encode_log_luv(wide), LogLuv(), rounding_of("float32"))
    cut = (wide == 0).any(axis=1) & wide.any(axis=1)
    beyond = wide @ RGB_TO_XYZ[1] > BRIGHTEST * 2 ** (1 / LEVELS_PER_STOP)
    compared = Compared("radiance as stored", wide, stored.value, stored.error)
    return in_rows(~(cut | beyond), compared)
