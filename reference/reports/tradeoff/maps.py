"""Where a setting is wrong: maps of the signed bias, in standard errors."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.reference.images.image import luminance, to_image
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.figures.canvas import SIDE, Tile, blank, draw_tiles

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

MOST = 6.0
"""Standard errors at which a colour is full."""

MAPS = 6
"""In a row."""


def deviations(colors: Scalars, truth: Moments) -> Scalars:
    """Mean of runs less the truth, in its standard errors.

    Parameters
    ----------
    colors : (R, N, 3) float; runs
    truth : Moments; path-traced

    Returns
    -------
    (N,) float64; of the luminance; 0 where neither has met any light
    """
    rows = np.array([luminance(c.astype(np.float64)) for c in colors])
    off = rows.mean(axis=0) - luminance(truth.mean)
    # Channels of a sample rise and fall together: their errors add up.
    noise = luminance(truth.standard_error())
    error = np.hypot(rows.std(axis=0, ddof=1) / np.sqrt(len(rows)), noise)
    found: Scalars = off / np.where(error > 0, error, np.inf)
    return found


def draw_maps(maps: Sequence[tuple[str, Scalars]], width: int) -> "Figure":
    """Maps in a row: blue for too dark, red for too bright.

    Parameters
    ----------
    maps : sequence of (str, (N,) float64); a name, and deviations in standard errors

    Returns
    -------
    Figure
        Without bias one pixel in 22 is beyond two standard errors, and one in 16,000
        beyond four, either way.
    """
    from matplotlib import colormaps

    colormap = colormaps["RdBu_r"]
    tiles = []
    for name, values in maps:
        shares = colormap(0.5 + 0.5 * np.clip(values / MOST, -1.0, 1.0))[:, :3]
        rows = to_image(255 * shares, width, len(shares) // width)
        pixels = np.rint(rows).astype(np.uint8)
        beyond = float(np.mean(np.abs(values) > 4.0))
        tiles.append(Tile(pixels, name, f"{100 * beyond:.2g} % beyond 4 s.e."))
    grid = [tiles[i : i + MAPS] for i in range(0, len(tiles), MAPS)]
    empty = Tile(np.full_like(tiles[0].pixels, 255))
    grid[-1] += [empty] * (len(grid[0]) - len(grid[-1]))
    picture = blank(SIDE * len(grid[0]), (SIDE + 0.5) * len(grid))
    draw_tiles(picture, grid)
    return picture
