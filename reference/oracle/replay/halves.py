"""Weights and confidences that a backend of its own passes keeps in 16 bits.

A half has 11 bits: to the nearest it is off by 2⁻¹¹ of the number at most, that is half
a step of 2⁻¹⁰ of the power of two below it; cut off towards 0 it is off by a whole
step, one way.  Numbers beyond the largest are held as the largest: infinity would be
W of a sample, and light that never ends.  Below the least normal number steps are 2⁻²⁴,
or there is 0.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.judgement import Compared
from restir_gi.reference.oracle.replay.storage import HALF_LEAST, HALF_MOST

HALVES: Mapping[str, str] = {
    "half": "to the nearest",
    "half, cut": "towards 0",
    "half, infinite": "to the nearest, and infinity beyond 65504",
}
"""Ways to hold a number in 16 bits, beside 'exact'; the last of them is wrong."""

RELATIVE, SMALL_STEP, WHOLE = 2.0**-11, 2.0**-24, 2.0**11
"""Error to the nearest; step of subnormal numbers; whole numbers below are held."""

INFINITE_FROM = 65520.0
"""What is nearer to the next power of two than to the largest half."""


def held_in_half(x: Bounded, how: str) -> Bounded:
    """Numbers from 0 on as they are held, (N,); 'exact', or by a name of `HALVES`."""
    if how == "exact":
        return x
    infinite = how == "half, infinite"
    over = x.value + x.error >= (INFINITE_FROM if infinite else np.inf)
    surely = x.value - x.error >= INFINITE_FROM
    value = np.minimum(x.value, HALF_MOST)
    error = RELATIVE * value
    if how == "half, cut":
        # Anywhere in the step below.
        value = value - error
    flushed = value < HALF_LEAST
    error = np.where(flushed, np.maximum(value, SMALL_STEP), error)
    error = np.where(x.value == 0, 0.0, error) + x.error
    if infinite:
        # As infinity is handed on to whoever judges.
        value = np.where(surely, _largest(x), value)
        error = np.where(over & ~surely, np.inf, error)
    return Bounded(value, error, x.rounding)


def _largest(x: Bounded) -> float:
    """The largest number of the type that a backend calculates in."""
    types = np.finfo(np.float32), np.finfo(np.float64)
    return next(float(t.max) for t in types if float(t.tiny) == x.rounding.tiny)


def up_to_the_largest(found: NDArray[np.floating]) -> NDArray[np.floating]:
    """Numbers of a backend, the largest of their type in place of infinity, (N,)."""
    held: NDArray[np.floating] = np.minimum(found, np.finfo(found.dtype).max)
    return held


def counted_in_half(M: Bounded, how: str) -> Bounded:
    """Confidences as they are held, (N,): whole numbers up to 2048 as they were."""
    held = held_in_half(M, how)
    whole = (np.rint(M.value) == M.value) & (M.value <= WHOLE)
    return Bounded(
        np.where(whole, M.value, held.value),
        np.where(whole, M.error, held.error),
        M.rounding,
    )


def beside_halves(name: str, found: NDArray[np.floating], how: str) -> list[Compared]:
    """What is given, (N,), beside the nearest half: nothing is allowed between."""
    if how == "exact":
        return []
    with np.errstate(over="ignore", invalid="ignore"):
        half = found.astype(np.float16).astype(np.float64)
    infinite = how == "half, infinite"
    allowed: Scalars = np.where(np.isinf(half) & infinite, np.inf, 0.0)
    half = np.minimum(half, HALF_MOST)
    return [Compared(f"{name} as a half", found, half, allowed)]
