"""What a frame leaves in the cells of a grid, and what the next one finds there."""

from dataclasses import dataclass

import numpy as np

from hashgrid.grid import NOWHERE, Grid, build_grid, find_cells
from hashgrid.keys import Lattice, jittered, keys_of
from hashgrid.visits import visits
from reference.arrays import Indices, Masks, dot
from reference.records import NONE, take
from reference.resampling.reservoir import Reservoirs
from reference.rng import Uniforms
from reference.scene.surface import SurfacePoints
from reference.world import World

ALIKE = 0.5**0.25
"""Least cosine between the normals of those who share: max(n · n', 0)⁴ ≥ 1/2."""

INSERTION = 0
LOOK_UP = 1
"""Dimension of the first look-up, of which others follow; before it the insertion's."""


@dataclass(frozen=True, slots=True, eq=False)
class Cache:
    """Reservoirs of V vertices in the cells of a grid.

    Attributes
    ----------
    world : World; in which they were made
    lattice : Lattice; by whose cells they are found
    grid : Grid; of V vertices
    """

    world: World
    lattice: Lattice
    grid: Grid
    points: SurfacePoints
    reservoirs: Reservoirs


def fill(
    world: World,
    lattice: Lattice,
    points: SurfacePoints,
    reservoirs: Reservoirs,
    active: Masks,
    uniforms: Uniforms,
) -> Cache:
    """Put vertices into cells.

    Parameters
    ----------
    active : (V,) bool
        Which are put in.  Who looks at their samples here biases what is found.
    """
    u = uniforms.draw(INSERTION)
    moved = jittered(lattice, points.position, points.normal, u)
    grid = build_grid(keys_of(lattice, moved, points.normal), active)
    return Cache(world, lattice, grid, points, reservoirs)


def find(
    cache: Cache, points: SurfacePoints, uniforms: Uniforms, cells: int, most: int
) -> list[Indices]:
    """Whose reservoirs surface points find.

    Parameters
    ----------
    cache : Cache; of the frame before
    cells : int
        How many cells each looks into: the jitter of each look-up is its own, and leads
        to neighbours as a rule.
    most : int; how many reservoirs each takes from a cell

    Returns
    -------
    list of (K,) int64
        Rows of the cache, or ``NONE``.  Nobody who faces elsewhere is taken.  No sample
        decides who is.  Nothing at all where the cache is empty.
    """
    found: list[Indices] = []
    if len(cache.points) == 0:
        return found
    for number in range(cells):
        u = uniforms.draw(LOOK_UP + number)
        moved = jittered(cache.lattice, points.position, points.normal, u)
        cell = find_cells(cache.grid, keys_of(cache.lattice, moved, points.normal))
        cell = np.where(points.hit, cell, NOWHERE)
        for rows in visits(cache.grid, cell, u[2], most):
            found.append(_facing_alike(cache, points, rows))
    return found


def _facing_alike(cache: Cache, points: SurfacePoints, rows: Indices) -> Indices:
    normal = take(cache.points.normal, np.maximum(rows, 0))
    alike = (rows != NONE) & (dot(normal, points.normal) >= ALIKE)
    return np.where(alike, rows, NONE)


def homes(grid: Grid, vertices: int) -> Indices:
    """Which place of the table each vertex is in.

    Returns (V,) int64; place in the table, plus 1; 0 for those who are in no cell.
    """
    home = np.zeros(vertices, np.int64)
    home[grid.vertices] = np.repeat(grid.place + 1, grid.counts)
    return home
