"""Other neighbours: of the last frame, or with their spatial reservoirs as well."""

from collections.abc import Callable
from functools import partial

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.records import NONE, indices
from restir_gi.reference.numerics.rng import Uniforms
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


def _keeper(frame: FrameContext[Settings]) -> Callable[[Indices], Indices] | None:
    side, width = frame.settings.lattice, frame.world.camera.width
    return partial(corner, width=width, side=side) if side > 1 else None
