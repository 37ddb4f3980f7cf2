"""Limits that implementations put on numbers."""

import numpy as np

from restir_gi.reference.oracle.replay.bounded import Bounded, constant


def within(x: Bounded, least: float, most: float) -> Bounded:
    """Numbers between two limits, which belong to what is kept, and 0 for others.

    Either, where rounding leaves open on which side of a limit a number is.
    """
    inside = (x.value >= least) & (x.value <= most)
    near = np.minimum(np.abs(x.value - least), np.abs(x.value - most))
    unsure = (near <= x.error) & (x.error > 0)
    error = np.where(inside, x.error, 0.0)
    error = np.where(unsure, np.abs(x.value) + x.error, error)
    return Bounded(np.where(inside, x.value, 0.0), error, x.rounding)


def clamped(x: Bounded, least: float, most: float) -> Bounded:
    """Numbers clamped between two limits."""
    value = np.clip(x.value, least, most)
    low, high = (np.clip(x.value + e, least, most) for e in (-x.error, x.error))
    # The limit is a literal, rounded as such, of another size than the number.
    error = np.maximum(high - value, value - low) + x.rounding.unit * value
    return Bounded(value, error, x.rounding)


def at_least(x: Bounded, least: float) -> Bounded:
    """Numbers, or a limit where they are below it."""
    low = constant(least, x)
    return Bounded(np.maximum(x.value, least), x.error + low.error, x.rounding)
