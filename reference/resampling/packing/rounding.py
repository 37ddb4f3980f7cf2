"""Numbers of few bits: rounded to nearest, saturated, and never infinite or NaN."""

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from restir_gi.reference.numerics.arrays import Scalars

UInts = NDArray[np.unsignedinteger[Any]]


def nearest_float(x: Scalars, dtype: DTypeLike) -> Scalars:
    """Nearest number of a narrower floating-point type, saturated.

    Parameters
    ----------
    x : (N,) or (N, 3) float16, float32 or float64; any values
    dtype : float16 or float32; the narrower type, of p bits (11 or 24)

    Returns
    -------
    (N,) or (N, 3) of ``dtype``
        Ties go to the even number.  Relative error at most 2⁻ᵖ, that is 2⁻¹¹ or 2⁻²⁴,
        where |x| is between the smallest normal number (2⁻¹⁴, 2⁻¹²⁶) and the largest
        one (65504, 3.4e38); below it the absolute error is at most half the smallest
        subnormal number: 2⁻²⁵, 2⁻¹⁵⁰.  Beyond the largest number, and for infinity,
        the largest number; for NaN, 0.  Signs are kept, also that of 0.
    """
    with np.errstate(over="ignore"):
        rounded = x.astype(dtype)
    return _finite(rounded)


def widened(codes: Scalars) -> Scalars:
    """Numbers of a narrow floating-point type as float64, without an error.

    Parameters
    ----------
    codes : (N,) or (N, 3) float16 or float32; as stored, by whomever

    Returns
    -------
    (N,) or (N, 3) float64
        Infinity becomes the largest number of the type of ``codes``, NaN becomes 0:
        `nearest_float` writes neither, others do.
    """
    return _finite(codes).astype(np.float64, order="F")


def nearest_count(x: Scalars, most: int) -> UInts:
    """Nearest whole number from 0 to ``most``.

    Parameters
    ----------
    x : (N,) float or int; a confidence M or an age
    most : int; largest number that the field holds, below 2³²

    Returns
    -------
    (N,) uint32
        Ties go to the even number: the error is at most 1/2 between 1 and ``most``.
        What is positive is at least 1, since a reservoir of M = 0 would lose its sample
        at the next merge; what is not, NaN too, is 0.
    """
    x = x.astype(np.float64)
    count = np.where(x > 0, np.clip(np.rint(x), 1, most), 0)
    return count.astype(np.uint32)


def _finite(x: Scalars) -> Scalars:
    finite: Scalars = np.nan_to_num(x, nan=0.0)
    return finite
