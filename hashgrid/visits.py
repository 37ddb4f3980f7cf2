"""Which vertices of a cell a look-up takes: a walk with strides, from anywhere."""

import numpy as np

from hashgrid.grid import NOWHERE, Grid
from reference.arrays import Indices, Scalars
from reference.records import NONE


def visits(grid: Grid, cells: Indices, u: Scalars, most: int) -> list[Indices]:
    """Draw some of the vertices of cells, no one twice.

    Strides of n / most, rounded down, from a place that is drawn evenly: places differ
    as long as there are enough of them, and all have the same chance.

    Parameters
    ----------
    cells : (Q,) int64; rows of the grid, or ``NOWHERE``
    u : (Q,) float64; in [0, 1): where the walk begins

    Returns
    -------
    list of (Q,) int64
        Rows of the frame, or ``NONE`` where there is no more.  Each vertex of a cell is
        taken with the same probability, min(most / n, 1).
    """
    row = np.maximum(cells, 0)
    there = cells != NOWHERE
    count = np.where(there, grid.counts[row] if len(grid) else 0, 0)
    first = grid.start[row] if len(grid) else np.zeros_like(row)
    offset = np.minimum((u * count).astype(np.int64), np.maximum(count - 1, 0))
    found = []
    for k in range(most):
        place = (offset + k * count // most) % np.maximum(count, 1)
        # Of fewer than that, each once.
        few = count <= most
        place = np.where(few, k, place)
        taken = there & (k < count)
        at = np.where(taken, first + place, 0)
        vertex = grid.vertices[at] if len(grid.vertices) else np.full(len(row), NONE)
        found.append(np.where(taken, vertex, NONE))
    return found
