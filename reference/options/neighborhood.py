"""Other neighbours: of the last frame, with spatial reservoirs as well, of a table."""

from collections.abc import Callable
from functools import partial

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.records import NONE, indices
from restir_gi.reference.numerics.rng import Draw, Uniforms
from restir_gi.reference.options.reduced_resolution import corner
from restir_gi.reference.passes.neighbors import neighbors_of
from restir_gi.reference.passes.pixels import (
    FrameReservoirs,
    History,
    NeighborPixels,
    Pixels,
)
from restir_gi.reference.settings import Settings

Neighbors = list[tuple[NeighborPixels, Scalars]]


def special_neighbors(
    frame: FrameContext[Settings],
    history: History | None,
    temporal: FrameReservoirs | None,
    q: Pixels,
    rows: slice | Indices,
    uniforms: Uniforms,
    tries: int,
) -> Neighbors:
    """Neighbours as the settings have them.

    Parameters
    ----------
    history : History or None; what the last frame hands on
    temporal : FrameReservoirs or None
        Temporal reservoirs of this frame, unless they are not to be read.
    q : Pixels; K pixels
    rows : slice or (K,) int
    uniforms : Uniforms
        As of :func:`restir_gi.reference.passes.neighbors.neighbors_of`; lane 3 of a
        dimension decides on the spatial reservoir of the same neighbour.

    Returns
    -------
    list of (NeighborPixels, (K,))
        One or two for each try: with ``boost_below`` pixels of few samples reuse the
        spatial reservoirs of their neighbours, too [Ouyang21, Fig. 10].
    """
    around, keeper = indices(rows), _keeper(frame)
    if temporal is not None:
        found = neighbors_of(q, temporal, around, uniforms, tries, keeper)
    elif history is None:
        return []
    else:
        around = indices(history.rows(rows))
        found = neighbors_of(q, history.temporal, around, uniforms, tries, keeper)
    if not (frame.settings.boost_below and history):
        return found
    few = frame.settings.boost_below > history.confidence(history.spatial, rows)
    each: Neighbors = []
    for s, (q_n, u) in enumerate(found):
        row = q_n.rows
        if temporal is not None and history.pixel is not None:
            row = np.where(row != NONE, history.pixel[row], NONE)
        row = np.where(few, row, NONE)
        boosted = history.spatial.neighbors(q, row)
        each += [(q_n, u), (boosted, uniforms.draw(s)[3])]
    return each


def of_table(radius: Scalars, u: Draw) -> tuple[Indices, Indices]:
    """Offsets that a renderer has chosen itself, as lanes 0 and 1 have them, (K,) each.

    Parameters
    ----------
    radius : (K,); of the disk, which is not looked at
    """
    return u[0].astype(np.int64), u[1].astype(np.int64)


def clamped(at: Indices, size: int) -> Indices:
    """Places along an axis of an image, (K,) int; those outside are on its border."""
    return np.clip(at, 0, size - 1)


def mirrored(at: Indices, size: int) -> Indices:
    """Places along an axis of an image, (K,) int; those outside are reflected.

    As RTXDI does it, once: about the centre of the first pixel, and about the edge
    behind the last.
    """
    at = np.where(at < 0, -at, at)
    return np.where(at >= size, 2 * size - 1 - at, at)


def _keeper(frame: FrameContext[Settings]) -> Callable[[Indices], Indices] | None:
    side, width = frame.settings.lattice, frame.world.camera.width
    return partial(corner, width=width, side=side) if side > 1 else None
