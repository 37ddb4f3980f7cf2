"""Which pixels lend their samples: a search that narrows where the image is busy."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.passes.gbuffer import similar
from reference.passes.lattice import corner
from reference.records import NONE, take
from reference.rng import Draw
from reference.scene.surface import VisiblePoints
from reference.settings import Search


def find_neighbors(
    rows: Indices,
    visible: VisiblePoints,
    width: int,
    settings: Search,
    draws: list[Draw],
    lattice: int = 1,
) -> list[Indices]:
    """Neighbours drawn in a disk around each pixel, one a draw.

    Parameters
    ----------
    rows : (K,) int
        Pixels that search.
    visible : VisiblePoints
        Of the whole frame.
    width : int, pixels
        Of the image.
    settings : Search
        Radius and similarity.
    draws : list of four (K,) float64
        Lanes 0 and 1 of each give a point of the disk.
    lattice : int, pixels
        Side of the squares of which one pixel has a reservoir to lend.

    Returns
    -------
    list of (K,) int
        Row of the neighbour, or ``NONE``.

    Notes
    -----
    [Ouyang21, section 5]: the radius starts at 10 % of the width; a neighbour that
    cannot be used halves it, down to 3 pixels.  Only geometry decides, never a sample.
    """
    height = len(visible.depth) // width
    x, y = rows % width, rows // width
    n = visible.surface.shading
    n_row, depth_row = take(n, rows), visible.depth[rows]
    least = settings.min_radius
    radius = np.full(len(rows), max(settings.radius * width, least))
    found = []
    for u in draws:
        dx, dy = _in_disk(radius, u)
        x_to, y_to = x + dx, y + dy
        inside = (x_to >= 0) & (x_to < width) & (y_to >= 0) & (y_to < height)
        neighbor = np.where(inside, y_to * width + x_to, rows)
        if lattice > 1:
            neighbor = corner(neighbor, width, lattice)
        usable = inside & similar(
            n_row,
            depth_row,
            take(n, neighbor),
            visible.depth[neighbor],
            settings.max_angle,
            settings.max_depth,
        )
        radius = np.where(usable, radius, np.maximum(radius / 2.0, least))
        found.append(np.where(usable & (neighbor != rows), neighbor, NONE))
    return found


def _in_disk(radius: Scalars, u: Draw) -> tuple[Indices, Indices]:
    r, phi = radius * np.sqrt(u[0]), 2.0 * np.pi * u[1]
    dx, dy = np.rint(r * np.cos(phi)), np.rint(r * np.sin(phi))
    return dx.astype(np.int64), dy.astype(np.int64)
