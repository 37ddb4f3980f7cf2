"""Mistakes in hash grids, light reservoirs and paths in cells.

In the manner of :mod:`tests.mutants.catalogue`.  Of section 6 some cannot be planted:
caches are records of the frame before, written once and whole (HG-17, RG-09); nothing
is quantised (HG-13); no emission is stored, and no short ray passed over (HG-23).
"""

from tests.mutants.catalogue import Mutant

GRID, LIGHTS, WORLD = (
    "restir_gi.hashgrid.grid",
    "restir_gi.hashgrid.lights",
    "restir_gi.hashgrid.world_reservoirs",
)
REGIR, SETTINGS = "restir_gi.hashgrid.regir_gi", "restir_gi.hashgrid.path_settings"

FOUND = "same = alike & take(grid.cells, here).same(take(keys, open_rows))"
SORTED = 'order = np.argsort(hashes, kind="stable")'

GRID_MUTANTS = [
    Mutant(
        "a cell of the same hashes is taken for the right one",
        ("HG-01",),
        GRID,
        FOUND,
        "same = alike",
    ),
    Mutant(
        "a cell begins where the next one does",
        ("HG-03",),
        GRID,
        "grid.index_buffer[cell + 1] - first)",
        "grid.counters[cell])",
        also=(
            (
                GRID,
                "first = grid.index_buffer[cell]",
                "first = np.minimum(grid.index_buffer[cell + 1],"
                " grid.index_buffer[-1] - 1)",
            ),
            (
                GRID,
                "np.where(taken, first + place, 0)",
                "np.where(taken, first + place, 0) % len(grid.cell_storage)",
            ),
        ),
    ),
    Mutant(
        "the order within a cell is another",
        ("HG-05",),
        GRID,
        SORTED,
        "order = np.lexsort((-np.arange(len(hashes)), hashes))",
    ),
    Mutant(
        "cells of this frame's camera are looked up in the last frame's grid",
        ("HG-07",),
        WORLD,
        "look_up(history, vertices.points",
        "look_up(replace(history, lattice=lattice_of(frame.world.camera)),"
        " vertices.points",
    ),
    Mutant(
        "positions are cut towards zero",
        ("HG-09",),
        GRID,
        "np.floor(position / edge[:, None])",
        "np.trunc(position / edge[:, None])",
    ),
    Mutant(
        "the jitter lies in the plane of two axes",
        ("HG-11",),
        GRID,
        "across, along = normal_frames(normal)",
        "across, along = normal_frames(np.broadcast_to([0.0, 1.0, 0.0], normal.shape))",
    ),
    Mutant(
        "the jitter goes along one direction alone",
        ("HG-11",),
        GRID,
        "a, b = ((2.0 * lane - 1.0) * reach for lane in u[:2])",
        "a, b = (2.0 * u[0] - 1.0) * reach, 0.0 * reach",
    ),
    Mutant(
        "a look-up takes a vertex twice",
        ("HG-15",),
        GRID,
        "place = np.where(count <= most, k, place)",
        "place = np.where(count <= most, place, place)",
    ),
    Mutant(
        "a full bucket spills into the next one",
        ("HG-19",),
        GRID,
        "np.where(rank < BUCKET, bucket[turn] * BUCKET + rank, NOWHERE)",
        "bucket[turn] * BUCKET + rank",
    ),
    Mutant(
        "half of the vertices are put in",
        ("HG-25",),
        GRID,
        "v = np.flatnonzero(active)\n",
        "v = np.flatnonzero(active)\n    v = v[: len(v) // 2]\n",
    ),
    Mutant(
        "vertices that face elsewhere are neighbours, too",
        (),
        GRID,
        "alike: Masks = dot(a, b) >= ALIKE",
        "alike: Masks = dot(a, b) >= -2.0",
    ),
    Mutant(
        "lights of the last frame keep their numbers",
        ("HG-21",),
        WORLD,
        "lights = renumbered(r.y, cache.world.emitters, world.emitters)",
        "lights = r.y",
    ),
    Mutant(
        "lights are found by their place in the list",
        ("HG-21",),
        LIGHTS,
        "shapes: Indices = now.entry[before.primitive].astype(np.int64)",
        "shapes: Indices = np.arange(len(before.primitive))",
    ),
]

LIGHT_MUTANTS = [
    Mutant(
        "the density of a light is forgotten",
        (),
        WORLD,
        "luminance(f), p)",
        "luminance(f), p * 0 + 1 / len(world.emitters.probability))",
    ),
    Mutant(
        "one candidate too many is counted",
        ("RG-05",),
        WORLD,
        "finalize(r, r.M)",
        "finalize(r, r.M + 1)",
    ),
    Mutant(
        "dim lights are no target, and shine",
        ("RG-03",),
        WORLD,
        "luminance(f), p)",
        "luminance(f) * (luminance(f) > 0.2 * luminance(f).mean()), p)",
    ),
    Mutant(
        "shadows are left out",
        (),
        WORLD,
        "np.where(seen, r.W[shines], 0.0)",
        "np.where(seen | True, r.W[shines], 0.0)",
    ),
    Mutant(
        "an emitter hit counts whole beside light sampling",
        (),
        LIGHTS,
        "weight = bsdf.delta[rows].astype(float)",
        "weight = np.ones(len(rows))",
    ),
]

PATH_MUTANTS = [
    Mutant(
        "paths that found nothing are not counted",
        ("RG-01",),
        REGIR,
        "return finalize(replace(found, M=ones), ones)",
        "return finalize(replace(found, M=(found.w > 0) * ones), ones)",
    ),
    Mutant(
        "only useful paths are put into cells",
        ("RG-07",),
        SETTINGS,
        '(W > 0) | (self.nulls == "counted")',
        "W > 0",
    ),
    Mutant(
        "dim paths are no target, and shine",
        ("RG-03",),
        REGIR,
        "p_hat = luminance(y.value)",
        "p_hat = luminance(y.value) * (luminance(y.value) > 0.3)",
    ),
    Mutant(
        "the density of the joint is that of another direction",
        ("RG-11",),
        REGIR,
        "density[rows] = pdf(world.materials, x, -seen.wo)",
        "density[rows] = 0.5 * pdf(world.materials, x, -seen.wo)",
    ),
    Mutant(
        "the way on from a cell is that of the path's own ray",
        (),
        REGIR,
        "wi[rows], delta[rows] = -seen.wo, False",
        "delta[rows] = False",
    ),
    Mutant(
        "the prefix is replayed from the neighbour's numbers",
        (),
        REGIR,
        "return replace(kept, y=replace(kept.y, number=number))",
        "return kept",
    ),
    Mutant(
        "the weight of the prefix is left out",
        (),
        REGIR,
        "value=step.weight * suffix.value",
        "value=1.0 * suffix.value",
    ),
    Mutant(
        "the weight W of a suffix is left out",
        (),
        REGIR,
        "p_hat * W, 0 * p_hat",
        "p_hat * (W > 0), 0 * p_hat",
    ),
    Mutant(
        "a suffix is joined where its own joint is",
        (),
        REGIR,
        "joins = there & step.joinable & ~first.delta",
        "joins = there & step.joinable & ~first.delta & (suffix.joint == 0)",
    ),
    Mutant(
        "paths from cells may be too long",
        (),
        REGIR,
        "fits = self.reservoirs.y.end[self.rows[at]] <= self.reach",
        "fits = self.reservoirs.y.end[self.rows[at]] <= 99",
    ),
    Mutant(
        "a path that cannot be joined is in a cell",
        (),
        REGIR,
        "return np.where(joint == 2, W, 0.0)",
        "return np.where(joint >= 0, W, 0.0)",
    ),
    Mutant(
        "the pixel's own way on is not among the candidates",
        (),
        REGIR,
        "reservoirs=own,",
        "reservoirs=replace(own, W=own.W * (own.y.joint == 2)),",
    ),
]
