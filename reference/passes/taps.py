"""Other places of the last frame at which a pixel may look for its history."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.records import NONE
from reference.rng import Draw

FLIP = 3
"""Bits of x and y that are turned over: a permutation within blocks of 4 x 4 pixels."""


def permuted(rows: Indices, width: int, height: int, frame: int) -> Indices:
    """Pixels shuffled within blocks of 4 x 4, which lie elsewhere in each frame.

    Parameters
    ----------
    rows : (N,) int
        Pixels of the last frame, or ``NONE``.
    width, height : int, pixels
        Of the image.
    frame : int
        From 0.

    Returns
    -------
    (N,) int
        The pixel's partner, whose own partner it is; itself where that would lie
        outside of the image; ``NONE`` stays.

    Notes
    -----
    It breaks up the patterns of history that stays with its pixel.  Place and time
    alone decide.
    """
    shift_x, shift_y = frame % 4, frame // 4 % 4
    y, x = np.divmod(np.maximum(rows, 0), width)
    x_to = ((x + shift_x) ^ FLIP) - shift_x
    y_to = ((y + shift_y) ^ FLIP) - shift_y
    inside = (x_to >= 0) & (x_to < width) & (y_to >= 0) & (y_to < height)
    partner = np.where(inside, y_to * width + x_to, rows)
    return np.where(rows == NONE, NONE, partner)


def nearby(x: Scalars, y: Scalars, u: Draw, radius: float) -> tuple[Scalars, Scalars]:
    """A random place near a place of the image.

    Parameters
    ----------
    x, y : (N,) float64, pixels
        Places, NaN where there is none.
    u : four (N,) float64
        Lanes 0 and 1.
    radius : float, pixels
        Half of the side of the square that is searched.

    Returns
    -------
    (N,), (N,) float64, pixels
        Also outside of the image.
    """
    return x + radius * (2.0 * u[0] - 1.0), y + radius * (2.0 * u[1] - 1.0)
