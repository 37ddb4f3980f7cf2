"""Lines 4 to 8 of Algorithm 4: similar pixels nearby, sought ever closer."""

from collections.abc import Callable

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.rng import Draw, Uniforms
from restir_gi.reference.passes.gbuffer import similar
from restir_gi.reference.passes.pixels import FrameReservoirs, NeighborPixels, Pixels
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.settings import Search


def neighbors_of(
    q: Pixels,
    source: FrameReservoirs,
    rows: Indices,
    uniforms: Uniforms,
    tries: int,
    keeper: Callable[[Indices], Indices] | None = None,
) -> list[tuple[NeighborPixels, Scalars]]:
    """Similar pixels near each q, with the number that decides on each.

    Parameters
    ----------
    q : Pixels; K pixels
    source : FrameReservoirs; of the frame in which neighbours are sought
    rows : (K,) int; where q is in that frame, or ``NONE``: then it has no neighbours
    uniforms : Uniforms
        K rows.  Dimension s: lanes 0 and 1 find neighbour s, lane 2 decides on it.
    keeper : callable, optional; as of `find_neighbors`

    Returns
    -------
    list of (NeighborPixels, (K,)); one for each try
    """
    there, width = rows != NONE, source.world.camera.width
    draws = [uniforms.draw(s) for s in range(tries)]
    found = find_neighbors(
        np.maximum(rows, 0), source.visible, width, q.settings, draws, keeper
    )
    return [
        (source.neighbors(q, np.where(there, row, NONE)), u[2])
        for row, u in zip(found, draws, strict=True)
    ]


def in_disk(radius: Scalars, u: Draw) -> tuple[Indices, Indices]:
    """Whole columns and rows to a point of a disk, uniform on it, (K,) int each."""
    r, phi = radius * np.sqrt(u[0]), 2.0 * np.pi * u[1]
    dx, dy = np.rint(r * np.cos(phi)), np.rint(r * np.sin(phi))
    return dx.astype(np.int64), dy.astype(np.int64)


def open_border(at: Indices, size: int) -> Indices:
    """Places along an axis of an image, (K,) int: nothing stands for those outside."""
    return at


def find_neighbors(
    rows: Indices,
    visible: VisiblePoints,
    width: int,
    settings: Search,
    draws: list[Draw],
    keeper: Callable[[Indices], Indices] | None = None,
    offset: Callable[[Scalars, Draw], tuple[Indices, Indices]] = in_disk,
    border: Callable[[Indices, int], Indices] = open_border,
) -> list[Indices]:
    """Neighbours drawn in a disk around each pixel, one a draw.

    [Ouyang21, section 5]: the radius starts at 10 % of the width; a neighbour that
    cannot be used halves it, down to 3 pixels.  Only geometry decides, never a sample.

    Parameters
    ----------
    rows : (K,) int; pixels that search
    draws : list of four (K,) float64; lanes 0 and 1 of each give a point of the disk
    keeper : callable, optional
        From pixels to those that keep a reservoir for them; by default their own.
    offset : callable; from a radius and a draw to columns and rows, (K,) int each
    border : callable
        From places along an axis and its length to those that stand for them.

    Returns
    -------
    list of (K,) int; row of the neighbour, or ``NONE``
    """
    height = len(visible.depth) // width
    x, y = rows % width, rows // width
    n = visible.surface.shading
    n_row, depth_row = take(n, rows), visible.depth[rows]
    least = settings.min_radius
    radius = np.full(len(rows), max(settings.radius * width, least))
    found = []
    for u in draws:
        dx, dy = offset(radius, u)
        x_to, y_to = border(x + dx, width), border(y + dy, height)
        inside = (x_to >= 0) & (x_to < width) & (y_to >= 0) & (y_to < height)
        neighbor = np.where(inside, y_to * width + x_to, rows)
        if keeper is not None:
            neighbor = keeper(neighbor)
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
