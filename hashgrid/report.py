"""What became of a grid: how full it is, and how far one has to look."""

from dataclasses import dataclass

import numpy as np

from hashgrid.grid import BUCKET, Grid


@dataclass(frozen=True, slots=True)
class Occupancy:
    """Counts of a grid.

    Attributes
    ----------
    cells : int; that have a vertex
    lost : int; vertices whose bucket was full
    buckets : tuple of int; how many buckets have 0, 1, ... 16 cells
    probes : float
        Places that are looked at to find a cell, in the mean over the vertices.
    longest : int; the most vertices of a cell
    shared : int
        Cells of a bucket whose checksum an earlier cell of it has too: whoever tells
        cells by checksums would mix them up.
    """

    cells: int
    vertices: int
    lost: int
    buckets: tuple[int, ...]
    probes: float
    longest: int
    shared: int


def occupancy(grid: Grid) -> Occupancy:
    """Count."""
    counts, bucket = grid.counts, grid.place // BUCKET
    _, full = np.unique(bucket, return_counts=True)
    histogram = np.bincount(full, minlength=BUCKET + 1)
    histogram[0] = grid.buckets - len(full)
    marks = np.stack([bucket, grid.checksum.astype(np.int64)])
    alike = len(grid) - np.unique(marks, axis=1).shape[1]
    probes = (grid.place % BUCKET + 1) * counts
    vertices = int(counts.sum())
    return Occupancy(
        cells=len(grid),
        vertices=vertices,
        lost=grid.lost,
        buckets=tuple(int(n) for n in histogram),
        probes=float(probes.sum() / max(vertices, 1)),
        longest=int(counts.max(initial=0)),
        shared=alike,
    )
