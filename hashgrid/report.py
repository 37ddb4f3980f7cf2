"""Statistics of a grid: how full it is, and how many slots a look-up reads."""

from dataclasses import dataclass

import numpy as np

from restir_gi.hashgrid.grid import BUCKET, Grid


@dataclass(frozen=True, slots=True)
class Occupancy:
    """Counts of a grid.

    Attributes
    ----------
    cells : int; that have a vertex
    vertices : int; in these cells
    lost : int; vertices whose bucket was full
    buckets : tuple of int; how many buckets have 0, 1, ... 16 cells
    probes : float; slots that are read to find a cell, in the mean over the vertices
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
    counts, bucket = grid.counters, grid.slot // BUCKET
    _, full = np.unique(bucket, return_counts=True)
    histogram = np.bincount(full, minlength=BUCKET + 1)
    histogram[0] = grid.buckets - len(full)
    checksum = grid.cells.hashes.astype(np.uint32).astype(np.int64)
    distinct = np.unique(np.stack([bucket, checksum]), axis=1)
    alike = len(grid) - distinct.shape[1]
    probes = (grid.slot % BUCKET + 1) * counts
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
