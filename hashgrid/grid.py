"""A hash grid of cells, each with the list of the vertices in it, for a whole frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hashgrid.hashes import UInts
from hashgrid.keys import Keys
from reference.arrays import Indices, Masks
from reference.records import take

BUCKET = 16
"""Places of a bucket."""

BUCKETS = 0x40000

NOWHERE = -1
"""In place of a cell: nobody was there, or its bucket is full."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """C cells in the order of their places, and the vertices in each.

    Attributes
    ----------
    cells : Keys; C rows, no two alike
    place : (C,) int32; bucket · 16 + place in the bucket
    checksum : (C,) uint32; of the cell; two cells may share one, and are not mixed up
    start : (C + 1,) int64
        Exclusive prefix sum of the counts: vertices of cell c are those from start[c]
        to start[c + 1].
    vertices : (start[C],) int64
        Rows of the frame, cell by cell, in rising order within each.
    lost : int; vertices whose bucket was full
    marks : (C,) uint64; both hashes of the cells, in rising order
    marked : (C,) int32; cells in that order
    """

    buckets: int
    cells: Keys
    place: Indices
    checksum: UInts
    start: Indices
    vertices: Indices
    lost: int
    marks: NDArray[np.uint64]
    marked: Indices

    def __len__(self) -> int:
        """Number of cells."""
        return len(self.place)

    @property
    def counts(self) -> Indices:
        """(C,): vertices of each cell."""
        return np.diff(self.start)


def build_grid(keys: Keys, active: Masks, buckets: int = BUCKETS) -> Grid:
    """Sort vertices into cells, as if they came one after the other.

    [Boisse21, Alg. 2], of which the sum that gives each cell its first place in the
    list leaves the cell itself out.  On a GPU the order of atomic additions decides;
    here the number of the vertex does.

    Parameters
    ----------
    active : (N,) bool; which are inserted
    buckets : int; how many of 16 places each, at most 2²⁷

    Returns
    -------
    Grid
        A cell takes the first free place of its bucket; where there is none, its
        vertices are lost, and counted.
    """
    rows = np.flatnonzero(active)
    order, first = _grouped(take(keys, rows))
    rows, head = rows[order], np.flatnonzero(first)
    cells = take(keys, rows[head])
    count = np.diff(np.append(head, len(rows)))
    place = _places(cells.place % np.uint32(buckets), rows[head])
    kept = np.flatnonzero(place != NOWHERE)
    kept = kept[np.argsort(place[kept], kind="stable")]
    start = np.concatenate([[0], np.cumsum(count[kept])])
    within = np.arange(start[-1]) - np.repeat(start[:-1], count[kept])
    vertices = rows[np.repeat(head[kept], count[kept]) + within]
    cells = take(cells, kept)
    mark = _mark(cells)
    marked = np.argsort(mark, kind="stable")
    return Grid(
        buckets=buckets,
        cells=cells,
        place=place[kept].astype(np.int32),
        checksum=cells.checksum,
        start=start,
        vertices=vertices,
        lost=len(rows) - len(vertices),
        marks=mark[marked],
        marked=marked.astype(np.int32),
    )


def _grouped(keys: Keys) -> tuple[Indices, Masks]:
    """Order in which rows of one cell follow each other, and where a cell begins."""
    mark = _mark(keys)
    order = np.argsort(mark, kind="stable")
    first = _differs(take(keys, order))
    # Other cells of one mark: so seldom that only their rows are sorted again.
    same = mark[order][1:] == mark[order][:-1]
    if np.any(same & first[1:]):
        fields = (keys.facing, keys.z, keys.y, keys.x, keys.level, mark)
        order = np.lexsort((np.arange(len(keys)), *fields))
        first = _differs(take(keys, order))
    return order, first


def _mark(keys: Keys) -> NDArray[np.uint64]:
    """Both hashes in one word."""
    high = keys.place.astype(np.uint64) << np.uint64(32)
    return high | keys.checksum.astype(np.uint64)


def _differs(keys: Keys) -> Masks:
    """Whether a row is of another cell than the one before it."""
    first = np.ones(len(keys), bool)
    first[1:] = ~_same(take(keys, np.arange(1, len(keys))), _without_last(keys))
    return first


def _without_last(keys: Keys) -> Keys:
    return take(keys, np.arange(max(len(keys) - 1, 0)))


def _same(a: Keys, b: Keys) -> Masks:
    fields = ("level", "x", "y", "z", "facing")
    equal: Masks = np.all([getattr(a, f) == getattr(b, f) for f in fields], axis=0)
    return equal


def _places(bucket: UInts, came: Indices) -> Indices:
    """Place of each cell, by when its first vertex came."""
    order = np.lexsort((came, bucket))
    sorted_buckets = bucket[order]
    fresh = np.ones(len(order), bool)
    fresh[1:] = sorted_buckets[1:] != sorted_buckets[:-1]
    heads = np.flatnonzero(fresh)
    sizes = np.diff(np.append(heads, len(order)))
    rank = np.arange(len(order)) - np.repeat(heads, sizes)
    there = sorted_buckets.astype(np.int64) * BUCKET + rank
    place = np.empty(len(order), np.int64)
    place[order] = np.where(rank < BUCKET, there, NOWHERE)
    return place


def find_cells(grid: Grid, keys: Keys) -> Indices:
    """Cells that points lie in, (Q,) int64; row of the cell, or ``NOWHERE``.

    Parameters
    ----------
    grid : Grid; built before
    keys : Keys; of Q points, by the grid's own lattice
    """
    found = np.full(len(keys), NOWHERE)
    if len(grid) == 0:
        return found
    marks, wanted = grid.marks, _mark(keys)
    at = np.searchsorted(marks, wanted)
    # Those of one mark stand side by side: as a rule there is one.
    open_rows = np.flatnonzero(at < len(marks))
    while len(open_rows):
        here = grid.marked[at[open_rows]]
        alike = marks[at[open_rows]] == wanted[open_rows]
        same = alike & _same(take(grid.cells, here), take(keys, open_rows))
        found[open_rows[same]] = here[same]
        open_rows = open_rows[alike & ~same]
        at[open_rows] += 1
        open_rows = open_rows[at[open_rows] < len(marks)]
    return found
