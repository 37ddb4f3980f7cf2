"""Boiling filter: reservoirs that outshine their surroundings are emptied."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, divide_or_zero, saturate
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.resampling.target import luminance

TILE = 16
"""Pixels on a side of the tiles within which reservoirs are compared."""

ROUNDING = 1.0 + TILE * TILE * 2.0**-52
"""The mean of that many equal numbers may round to below them."""


def boiling_filter(r: Reservoirs, width: int, strength: float) -> Reservoirs:
    """Empty the reservoirs whose light is far above the mean of their tile.

    Biased: it looks at the samples' values, and takes light away.  The mean is over the
    reservoirs of the tile that hold a sample, itself among them.

    Parameters
    ----------
    r : Reservoirs; of a whole frame, N rows
    strength : float
        Above 0, to 1: a reservoir may reach 10 / strength - 9 times the mean.

    Returns
    -------
    Reservoirs; W = 0 and M = 0 where luminance(L_o) · W is above that
    """
    with np.errstate(over="ignore"):
        light = saturate(luminance(r.y.radiance) * r.W)
        tile = _tiles(len(light), width)
        count = np.bincount(tile, light > 0)[tile]
        mean = np.bincount(tile, divide_or_zero(light, count))[tile]
        calm = light * strength <= mean * (10.0 - 9.0 * strength) * ROUNDING
    return replace(r, W=np.where(calm, r.W, 0.0), M=np.where(calm, r.M, 0.0))


def _tiles(pixels: int, width: int) -> Indices:
    y, x = np.divmod(np.arange(pixels), width)
    across = -(-width // TILE)
    tiles: Indices = y // TILE * across + x // TILE
    return tiles
