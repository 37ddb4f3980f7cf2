"""Fields of packed reservoirs beside what they should hold."""

import numpy as np
from numpy.typing import DTypeLike, NDArray

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.judgement import Compared

SINGLE, SMALL_SINGLE = 2.0**-24, float(np.finfo(np.float32).tiny)
"""Relative error of a float32; smaller ones may be flushed to 0."""

MOST_SINGLE = float(np.finfo(np.float32).max)


def records(
    words: NDArray[np.uint32],
    unit: DTypeLike,
    places: tuple[int, ...],
    layout: DTypeLike,
) -> NDArray[np.void]:
    """Words as records of a layout, their parts back at the places that it has.

    Parameters
    ----------
    words : (N, K) uint32; as a backend wrote them, or reads them
    unit : dtype; of the parts, bytes or halves of words
    places : tuple of int; where each part of the layout stands

    Returns
    -------
    (N,) of the layout
    """
    parts = np.ascontiguousarray(words, "<u4").view(unit)[:, list(places)]
    return np.ascontiguousarray(parts).view(layout)[:, 0]


def single(name: str, raw: Scalars, read: Scalars, given: Scalars) -> Compared:
    """Numbers of float32, which are never infinite nor NaN.

    Parameters
    ----------
    raw : (N,) or (N, 3) float32; as they stand in the words
    read : array of float64; as the layout reads them
    given : array; what was to be written
    """
    wide = given.astype(np.float64)
    held = np.clip(wide, -MOST_SINGLE, MOST_SINGLE)
    allowed = np.maximum(np.abs(held) * SINGLE, SMALL_SINGLE)
    found = np.where(np.isfinite(raw), read, np.inf)
    saturated = np.abs(wide) > MOST_SINGLE
    return Compared(f"words: {name}", found, held, np.where(saturated, 0.0, allowed))


def copied(name: str, outputs: Buffers, expected: Scalars) -> Compared:
    """Numbers of float32 that were read; those below the normal ones may be 0.

    Parameters
    ----------
    expected : (N,) or (N, 3) float64
    """
    small = np.abs(expected) < SMALL_SINGLE
    return Compared(name, outputs[name], expected, np.where(small, SMALL_SINGLE, 0.0))
