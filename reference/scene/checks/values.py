"""Ranges of numbers, and the one line that says where one is left."""

from typing import NoReturn

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.system.errors import UsageError

BRIGHTEST = 1e30
"""Largest radiance, intensity or irradiance.

A pixel may sum many of it, and is float32 in a file, which ends at 3.4e38.
"""


def refuse(where: str, wrong: str, right: str) -> NoReturn:
    """Stop: the scene cannot be rendered as it is.

    Raises UsageError.
    """
    raise UsageError(f"{where}: {wrong}; {right}")


def need_rows(where: str, what: str, values: Scalars, columns: int) -> None:
    """Require an array of finite rows.

    Parameters
    ----------
    where, what : str
        Part of the scene, and a row of the array: 'mesh "floor"', 'vertex'.
    values : array; should be (N, columns) finite numbers

    Raises
    ------
    UsageError
        Names the first bad row.
    """
    if values.ndim != 2 or values.shape[1] != columns:
        shape = "x".join(map(str, values.shape)) or "one number"
        refuse(where, f"an array of {shape} holds each {what}", f"use (N, {columns})")
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        row = told(values[bad[0]])
        refuse(where, f"{what} {bad[0]} is {row}", "its numbers must be finite")


def need_numbers(
    where: str,
    what: str,
    values: object,
    low: float = -np.inf,
    high: float = np.inf,
    count: int | None = None,
) -> None:
    """Require finite numbers within bounds.

    Raises UsageError: a number is not finite or out of bounds, or there are too few or
    too many.

    Parameters
    ----------
    where, what : str; part of the scene, and its property: 'sphere "ball"', 'radius'
    low, high : float; bounds, inclusive
    count : int or None; how many numbers there must be; ``None`` for any
    """
    numbers = np.asarray(values, float).ravel()
    if count is not None and len(numbers) != count:
        refuse(where, f"{what} has {len(numbers)} numbers", f"it must have {count}")
    bad = ~(np.isfinite(numbers) & (numbers >= low) & (numbers <= high))
    if not bad.any():
        return
    bounds = "must be finite"
    if low > -np.inf:
        bounds = f"must be finite and at least {low:g}"
    if high < np.inf:
        bounds = f"must be {low:g} to {high:g}"
    shown = told(numbers) if len(numbers) <= 3 else f"{numbers[bad][0]:g} somewhere"
    refuse(where, f"{what} is {shown}", f"it {bounds}")


def told(values: Scalars) -> str:
    """Numbers as a reader expects them: "0.5" or "(nan, 0, 1)".

    Parameters
    ----------
    values : (K,) float; a point, a colour, or one number
    """
    words = [f"{value:g}" for value in np.ravel(values)]
    return words[0] if len(words) == 1 else f"({', '.join(words)})"
