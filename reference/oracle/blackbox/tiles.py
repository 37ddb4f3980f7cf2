"""Means of a picture and of its tiles."""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars

TILES = 4
"""On a side of the picture."""

PLACES = 1 + TILES**2
"""The picture, and its tiles row by row."""

CHANNELS = ("red", "green", "blue")

COLUMNS = PLACES * (1 + len(CHANNELS))
"""What is tested: means over all channels of each place, then those of each channel."""


def tile_means(color: NDArray[np.floating]) -> NDArray[np.float64]:
    """Mean of a picture, and those of its tiles, in each channel.

    Parameters
    ----------
    color : (H, W, 3); of sides that `TILES` divides

    Returns
    -------
    (PLACES, 3) float64
    """
    pixels = color.astype(np.float64)
    height, width = (side // TILES for side in pixels.shape[:2])
    cut = pixels.reshape(TILES, height, TILES, width, 3)
    tiles = cut.mean(axis=(1, 3)).reshape(-1, 3)
    return np.concatenate([pixels.mean(axis=(0, 1))[None], tiles])


def columns(means: NDArray[np.float64]) -> Scalars:
    """Columns of the means of places.

    Parameters
    ----------
    means : (..., PLACES, 3) float64

    Returns
    -------
    (..., COLUMNS) float64; first the means over the channels
    """
    apart = means.reshape(*means.shape[:-2], -1)
    return np.concatenate([means.mean(axis=-1), apart], axis=-1)


def name_of(column: int) -> str:
    """A column in words."""
    if column >= PLACES:
        place, channel = divmod(column - PLACES, len(CHANNELS))
        return f"{CHANNELS[channel]} in {name_of(place)}"
    if column == 0:
        return "the picture"
    row, place = divmod(column - 1, TILES)
    return f"tile ({place}, {row})"
