"""ReGIR GI: whole paths in the cells of a grid, and ReSTIR PT on what they lead to."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from extensions.frame_loop import Moment, PathFrame, path_frames
from extensions.restir_pt import reused
from hashgrid.bounce import Bounces, Tail
from hashgrid.cache import fill
from hashgrid.keys import lattice_of
from hashgrid.path_cache import PathCache, Written, joins
from hashgrid.path_settings import CellSettings
from hashgrid.vertex_numbers import of_vertices
from reference.arrays import Indices
from reference.records import concatenate, cut
from reference.resampling.reservoir import Reservoirs
from reference.rng import Stream
from reference.scene.animation import Animation
from reference.schedule import Schedule, in_bands
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class CellFrame(PathFrame):
    """What one frame of ReGIR GI leaves for the next, and the picture.

    Attributes
    ----------
    caches : mapping of int to PathCache; by the number of the vertex that asks them
    """

    caches: Mapping[int, PathCache]


def render_cell_frames(
    world: World,
    settings: CellSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[CellFrame]:
    """Frames of indirect light by ReGIR GI, without end [ZyanideND].

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(moment: Moment, last: CellFrame | None, schedule: Schedule) -> CellFrame:
    caches = last.caches if last else {}

    def drawn(rows: slice) -> Tail:
        points = cut(moment.visible.surface, rows)
        return Bounces(moment, caches, moment.numbers(rows)).draw(points)

    tails = in_bands(schedule, moment.pixels, drawn)
    # Whatever a cell knew, it is one new path of the pixel.
    new = Reservoirs(tails.kept.y, tails.kept.W, np.ones(moment.pixels))
    kept = reused(moment, last, lambda rows: cut(new, rows), schedule)
    color = kept.y.value * kept.W[:, None]
    return CellFrame(
        moment.number,
        moment.world,
        moment.visible,
        kept,
        color,
        _filled(moment, tails.written),
    )


def _filled(moment: Moment, written: Written | None) -> dict[int, PathCache]:
    """Grids of what the paths have written, by the vertices that will ask them."""
    settings, levels = moment.settings, []
    assert isinstance(settings, CellSettings)
    for v in range(1, moment.bounces + 1):
        if settings.writes(v) and written is not None:
            levels.append((v, written))
            written = written.rest
    if settings.writers == "every-bounce" and levels:
        one = _cache(moment, levels)
        return {v: one for v, _ in levels if settings.asks(v)}
    return {v: _cache(moment, [(v, level)]) for v, level in levels}


def _cache(moment: Moment, levels: list[tuple[int, Written]]) -> PathCache:
    settings = moment.settings
    assert isinstance(settings, CellSettings)
    points = concatenate([level.points for _, level in levels])
    reservoirs = concatenate([level.reservoirs for _, level in levels])
    number = np.repeat([v for v, _ in levels], moment.pixels)
    active = joins(moment.world, points, moment.shift.criterion.roughness)
    if settings.nulls == "dropped":
        active = active & (reservoirs.W > 0)
    lattice = lattice_of(moment.world.camera, settings.facings)
    pixel = np.tile(np.arange(moment.pixels), len(levels))
    jitter = of_vertices(pixel, moment.number, number, moment.seed, Stream.CELLS)
    cache = fill(moment.world, lattice, points, reservoirs, active, jitter)
    reach: Indices = (moment.bounces + 2 - number).astype(np.int8)
    return PathCache(cache, reach)
