"""Numbers as the contract means them: exact, and of 50 digits where there is a root.

Sums and products of floating-point numbers end somewhere: here they are not rounded,
nor are the signs of their differences.  A quotient, a root, π and a cosine have 50
digits, and what comes of them is rounded once more, to float64.
"""

from typing import Any

import numpy as np
from mpmath import MPContext
from numpy.typing import NDArray

from reference.arrays import Masks, Scalars

# Array of mpf, of WHOLE or of DIGITS.
Exact = NDArray[Any]

# Contexts of our own: the precision of mpmath.mp is anybody's to set.
WHOLE = MPContext()
WHOLE.prec = 2**15
"""Bits that hold all of a sum of products of four float64: the exponents of such
products span less than 2¹⁴."""

DIGITS = MPContext()
DIGITS.dps = 50


def exactly(values: NDArray[Any]) -> Exact:
    """The very numbers of a buffer.

    Parameters
    ----------
    values : (N, ...) array; finite, of any type that float64 holds

    Returns
    -------
    (N, ...) array of mpf of `WHOLE`; not rounded, nor are their sums and products
    """
    return _each(WHOLE.convert, values.astype(np.float64).astype(object))


def digits(values: Exact) -> Exact:
    """Exact numbers from which to go on in 50 digits.

    Parameters
    ----------
    values : (N, ...) array of mpf of `WHOLE`

    Returns
    -------
    (N, ...) array of mpf of `DIGITS`; still exact; what is done with them is rounded
    """
    return _each(DIGITS.convert, values)


def inner(a: Exact, b: Exact) -> Exact:
    """Inner product of the rows of two arrays of vectors.

    Parameters
    ----------
    a, b : (N, 3) array of mpf of `WHOLE`

    Returns
    -------
    (N,) array of mpf of `WHOLE`; not rounded, nor is its sign
    """
    products = a * b
    total: Exact = products[:, 0] + products[:, 1] + products[:, 2]
    return total


def luminance(color: Exact) -> Exact:
    """Luminance Y of colours.

    Parameters
    ----------
    color : (N, 3) array of mpf of `WHOLE`; linear Rec. 709

    Returns
    -------
    (N,) array of mpf of `DIGITS`
        With the decimals of the contract, which no binary number is.
    """
    return digits(inner(color, np.array([[2126, 7152, 722]], object))) / 10_000


def root(values: Exact) -> Exact:
    """Square root, (N,) array of mpf of `DIGITS`; to 50 digits.

    Parameters
    ----------
    values : (N,) array of mpf of `WHOLE`; not negative
    """
    return _each(DIGITS.sqrt, digits(values))


def quotient(a: Exact, b: Exact) -> Exact:
    """Quotient a / b, and 0 where b is 0.

    Parameters
    ----------
    a, b : (N,) array of mpf of `DIGITS`

    Returns
    -------
    (N,) array of mpf of `DIGITS`; to 50 digits
    """
    there = b != 0
    return zero_but(there, a[there] / b[there])


def zero_but(mask: Masks, values: Exact) -> Exact:
    """Values of some rows among zeros.

    Parameters
    ----------
    mask : (N,) bool; which rows
    values : (K, ...) array of mpf of `DIGITS`; of those K rows

    Returns
    -------
    (N, ...) array of mpf of `DIGITS`; 0 in the others
    """
    filled: Exact = np.full((len(mask), *values.shape[1:]), DIGITS.zero)
    filled[mask] = values
    return filled


def cosine_of_turns(values: Exact) -> Exact:
    """Cosine of 2π t, (N,) array of mpf of `DIGITS`; to 50 digits.

    Parameters
    ----------
    values : (N,) array of mpf of `WHOLE`; turns t
    """
    return _each(DIGITS.cospi, digits(2 * values))


def cosine_of_degrees(angle: float) -> Any:
    """Cosine of an angle, to 50 digits.

    Exact where it is rational: for a rational number of degrees that are 0, ±1/2 and ±1
    alone.

    Parameters
    ----------
    angle : float; degrees, 0 to 180
    """
    halves = {0: 2, 60: 1, 90: 0, 120: -1, 180: -2}
    if angle in halves:
        return DIGITS.mpf(halves[int(angle)]) / 2
    return DIGITS.cospi(DIGITS.mpf(angle) / 180)


def rounded(values: Exact) -> Scalars:
    """Numbers to the nearest float64.

    Parameters
    ----------
    values : (N, ...) array of mpf

    Returns
    -------
    (N, ...) float64
        Infinite beyond the largest; below the smallest normal number it may be rounded
        twice.
    """
    nearest: Scalars = values.astype(np.float64)
    return nearest


def _each(function: Any, values: Exact) -> Exact:
    result: Exact = np.frompyfunc(function, 1, 1)(values)
    return result
