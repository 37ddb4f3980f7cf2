"""Ranges of numbers, and the one line that says where one is left."""

from typing import NoReturn

import numpy as np

from reference.arrays import Scalars
from reference.errors import UsageError

BRIGHTEST = 1e30
"""Largest radiance, intensity or irradiance.

A pixel may sum many of it, and is float32 in a file, which ends at 3.4e38.
"""


def refuse(where: str, wrong: str, right: str) -> NoReturn:
    """Stop: the scene cannot be rendered as it is.

    Parameters
    ----------
    where : str
        Part of the scene: 'mesh "floor"'.
    wrong : str
        What is wrong with it.
    right : str
        What would be right.

    Raises
    ------
    UsageError
        Always.
    """
    raise UsageError(f"{where}: {wrong}; {right}")


def need_rows(where: str, what: str, values: Scalars, columns: int) -> None:
    """Require an array of finite rows.

    Parameters
    ----------
    where, what : str
        Part of the scene, and a row of the array: 'mesh "floor"', 'vertex'.
    values : array
        Should be (N, columns) finite numbers.
    columns : int
        Numbers in a row.

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

    Parameters
    ----------
    where, what : str
        Part of the scene, and its property: 'sphere "ball"', 'radius'.
    values : array_like
        One number or several.
    low, high : float
        Bounds, inclusive.
    count : int or None
        How many numbers there must be; ``None`` for any.

    Raises
    ------
    UsageError
        A number is not finite or out of bounds, or there are too few or too many.
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
    """Numbers as a reader expects them.

    Parameters
    ----------
    values : (K,) float
        A point, a colour, or one number.

    Returns
    -------
    str
        "0.5" or "(nan, 0, 1)".
    """
    words = [f"{value:g}" for value in np.ravel(values)]
    return words[0] if len(words) == 1 else f"({', '.join(words)})"
