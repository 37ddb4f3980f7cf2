"""Mistakes in hash grids, light reservoirs and paths in cells.

In the manner of :mod:`tests.mutants.catalogue`.  Of section 6 some cannot be planted:
caches are records of the frame before, written once and whole (HG-17, RG-09); nothing
is quantised (HG-13); no emission is stored, and no short ray passed over (HG-23).
"""

from tests.mutants.catalogue import Mutant

GRID, KEYS, VISITS = "hashgrid.grid", "hashgrid.keys", "hashgrid.visits"
CACHE, LIGHTS, CANDIDATES = (
    "hashgrid.cache",
    "hashgrid.lights",
    "hashgrid.light_candidates",
)
DONOR, VERTEX = "hashgrid.light_donor", "hashgrid.light_vertex"
BOUNCE, CELL, REGIR = "hashgrid.bounce", "hashgrid.cell_donor", "hashgrid.regir_gi"
TAILS = "hashgrid.tails"

FOUND = "same = alike & _same(take(grid.cells, here), take(keys, open_rows))"

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
        VISITS,
        "first = grid.start[row] if len(grid) else np.zeros_like(row)",
        "first = np.minimum(grid.start[row + 1], grid.start[-1] - 1)"
        " if len(grid) else np.zeros_like(row)",
    ),
    Mutant(
        "the order within a cell is another",
        ("HG-05",),
        GRID,
        'order = np.argsort(mark, kind="stable")\n    first = _differs',
        "order = np.lexsort((-np.arange(len(mark)), mark))\n    first = _differs",
    ),
    Mutant(
        "cells of this frame's camera are looked up in the last frame's grid",
        ("HG-07",),
        VERTEX,
        "find(cache, walk.points, uniforms, s.cells, s.reuse)",
        "find(replace(cache, lattice=lattice_of(self.world.camera)),"
        " walk.points, uniforms, s.cells, s.reuse)",
        also=(
            (
                VERTEX,
                "from dataclasses import dataclass\n",
                "from dataclasses import dataclass, replace\n"
                "from hashgrid.keys import lattice_of\n",
            ),
        ),
    ),
    Mutant(
        "positions are cut towards zero",
        ("HG-09",),
        KEYS,
        "np.floor(position / edges(level)[:, None])",
        "np.trunc(position / edges(level)[:, None])",
    ),
    Mutant(
        "the jitter lies in the plane of two axes",
        ("HG-11",),
        KEYS,
        "across, along = normal_frames(normal)",
        "across, along = normal_frames(np.broadcast_to([0.0, 1.0, 0.0], normal.shape))",
    ),
    Mutant(
        "the jitter goes along one direction alone",
        ("HG-11",),
        KEYS,
        "a, b = ((2.0 * lane - 1.0) * reach for lane in u[:2])",
        "a, b = (2.0 * u[0] - 1.0) * reach, 0.0 * reach",
    ),
    Mutant(
        "a look-up takes a vertex twice",
        ("HG-15",),
        VISITS,
        "place = np.where(few, k, place)",
        "place = np.where(few, place, place)",
    ),
    Mutant(
        "a full bucket spills into the next one",
        ("HG-19",),
        GRID,
        "np.where(rank < BUCKET, there, NOWHERE)",
        "there",
    ),
    Mutant(
        "half of the vertices are put in",
        ("HG-25",),
        GRID,
        "rows = np.flatnonzero(active)\n",
        "rows = np.flatnonzero(active)\n    rows = rows[: len(rows) // 2]\n",
    ),
    Mutant(
        "who faces elsewhere lends, too",
        (),
        CACHE,
        "(dot(normal, points.normal) >= ALIKE)",
        "(dot(normal, points.normal) >= -2.0)",
    ),
    Mutant(
        "lights of the last frame keep their numbers",
        ("HG-21",),
        DONOR,
        "replace(renumbered(r.y, rows), cell",
        "replace(r.y, cell",
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
        CANDIDATES,
        "luminance(value), density",
        "luminance(value), density * 0 + 1 / len(world.emitters.probability)",
    ),
    Mutant(
        "one candidate too many is counted",
        ("RG-05",),
        CANDIDATES,
        "finalize(kept, kept.M)",
        "finalize(kept, kept.M + 1)",
    ),
    Mutant(
        "dim lights are no target, and shine",
        ("RG-03",),
        CANDIDATES,
        "replace(lights, value=value), luminance(value), density",
        "replace(lights, value=value),"
        " luminance(value) * (luminance(value) > 0.2 * luminance(value).mean()),"
        " density",
    ),
    Mutant(
        "shadows are left out",
        (),
        VERTEX,
        "np.where(seen, kept.W, 0.0)",
        "np.where(seen | shines, kept.W, 0.0)",
    ),
    Mutant(
        "an emitter hit counts whole beside light sampling",
        (),
        VERTEX,
        "np.where(counts, bsdf.weight[rows] * radiance, 0.0)",
        "np.where(counts | True, bsdf.weight[rows] * radiance, 0.0)",
    ),
]

PATH_MUTANTS = [
    Mutant(
        "paths that found nothing are not counted",
        ("RG-01",),
        BOUNCE,
        "own = finalize(replace(found, M=ones), ones)",
        "own = finalize(replace(found, M=(found.w > 0) * ones), ones)",
    ),
    Mutant(
        "only useful paths are put into cells",
        ("RG-07",),
        REGIR,
        'if settings.nulls == "dropped":',
        "if True:",
    ),
    Mutant(
        "dim paths are no target, and shine",
        ("RG-03",),
        BOUNCE,
        "p_hat = luminance(y.value)",
        "p_hat = luminance(y.value) * (luminance(y.value) > 0.3)",
    ),
    Mutant(
        "the density of the joint is that of another direction",
        ("RG-11",),
        BOUNCE,
        "density[rows] = pdf(table, x, -seen.wo)",
        "density[rows] = 0.5 * pdf(table, x, -seen.wo)",
    ),
    Mutant(
        "the way on from a cell is that of the path's own ray",
        (),
        BOUNCE,
        "wi[rows], delta[rows] = -seen.wo, False",
        "delta[rows] = False",
    ),
    Mutant(
        "what leads to a cell is replayed from the lender's numbers",
        (),
        BOUNCE,
        "return replace(kept, y=replace(kept.y, number=self.number))",
        "return kept",
    ),
    Mutant(
        "the weight of the way to a tail is left out",
        (),
        TAILS,
        "value=step.weight * tail.value",
        "value=1.0 * tail.value",
    ),
    Mutant(
        "the weight W of a tail is left out",
        (),
        BOUNCE,
        "p_hat * rest.kept.W",
        "p_hat * (rest.kept.W > 0)",
    ),
    Mutant(
        "a tail is joined where its own joint is",
        (),
        TAILS,
        "joins = there & step.joinable & ~onset.delta",
        "joins = there & step.joinable & ~onset.delta & (tail.joint == 0)",
    ),
    Mutant(
        "paths from cells may be too long",
        (),
        CELL,
        "fits = self.reservoirs.y.end[self.rows[at]] <= self.reach",
        "fits = self.reservoirs.y.end[self.rows[at]] <= 99",
    ),
    Mutant(
        "a path that cannot be joined is in a cell",
        (),
        BOUNCE,
        "W = np.where(kept.y.joint == 2, kept.W, 0.0)",
        "W = np.where(kept.y.joint >= 0, kept.W, 0.0)",
    ),
    Mutant(
        "the pixel's own way on is not among the candidates",
        (),
        BOUNCE,
        "canonical = PointDonor(m.shift, *now, *now, own, here, same_domain=True)",
        "canonical = PointDonor(m.shift, *now, *now,"
        " replace(own, W=own.W * (own.y.joint == 2)), here, same_domain=True)",
    ),
]
