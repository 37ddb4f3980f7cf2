"""Area ReSTIR: reservoirs of whole paths over the area of each pixel."""

from collections.abc import Callable, Iterator

import numpy as np

from extensions.area_donor import AreaDonor, AreaShift
from extensions.area_paths import draw_area_paths, target
from extensions.area_settings import AreaSettings
from extensions.frame_loop import Moment, PathFrame, path_frames
from extensions.windows import resample_past, windows
from reference.passes.neighbors import find_neighbors
from reference.records import cut
from reference.resampling.generalized import resample
from reference.resampling.reservoir import Reservoirs, finalize
from reference.rng import Stream
from reference.scene.animation import Animation
from reference.schedule import Schedule, in_bands
from reference.world import World


def render_area_frames(
    world: World,
    settings: AreaSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[PathFrame]:
    """Frames of indirect light by ReSTIR over the area of each pixel, without end.

    [Zhang24].  Which pixels lend, and how far they are trusted, is decided by what
    their centres see: never by a sample.

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result

    Returns
    -------
    iterator of PathFrame; means over the areas of the pixels; samples are `AreaPaths`
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(moment: Moment, last: PathFrame | None, schedule: Schedule) -> PathFrame:
    kept = area_reused(moment, last, lambda r: area_drawn(moment, r), schedule)
    color = kept.y.paths.value * kept.W[:, None]
    return PathFrame(moment.number, moment.world, moment.visible, kept, color)


def area_reused(
    moment: Moment,
    last: PathFrame | None,
    drawn: Callable[[slice], Reservoirs],
    schedule: Schedule,
) -> Reservoirs:
    """Temporal and spatial reuse over areas, as the settings say.

    Parameters
    ----------
    last : PathFrame or None; the one before, if there is one
    drawn : callable; from some pixels to the paths that they draw anew
    """
    rows, settings = moment.pixels, moment.settings
    if last is None or not settings.temporal:
        fresh = in_bands(schedule, rows, drawn)
    else:
        fresh = in_bands(schedule, rows, lambda r: _temporal(moment, last, drawn(r), r))
    if not settings.spatial:
        return fresh
    # Every pixel's reservoir is complete before a neighbour reads it.
    return in_bands(schedule, rows, lambda r: _spatial(moment, fresh, r))


def area_drawn(moment: Moment, rows: slice) -> Reservoirs:
    """Paths that the areas of pixels draw anew, of `AreaPaths`, K rows; M = 1."""
    number = moment.numbers(rows)
    tree = draw_area_paths(
        moment.world,
        np.arange(rows.start, rows.stop),
        moment.uniforms(rows, Stream.PIXEL).draw(0),
        moment.bounces,
        moment.shift.criterion,
        number,
        moment.shift.uniforms(number),
    )
    return finalize(tree, tree.M)


def _temporal(
    moment: Moment, last: PathFrame, new: Reservoirs, rows: slice
) -> Reservoirs:
    s, here = moment.settings, np.arange(rows.start, rows.stop)
    assert isinstance(s, AreaSettings)
    shift = AreaShift(moment.shift, s.primary, last.world, moment.world)
    stands = last.world is moment.world
    past = windows(last, moment, here)
    before = [
        AreaDonor(shift, here, last.reservoirs, part.rows, part.dx, part.dy, stands)
        for part in past
    ]
    shares = [part.share for part in past]
    u = moment.uniforms(rows, Stream.TEMPORAL)
    decisions = [*u.draw(0)[: len(before)], u.draw(1)[0]]
    own = _own(moment, new, rows)
    return resample_past(own, before, shares, decisions, s, target)


def _spatial(moment: Moment, fresh: Reservoirs, rows: slice) -> Reservoirs:
    s, width = moment.settings, moment.world.camera.width
    here = np.arange(rows.start, rows.stop)
    uniforms = moment.uniforms(rows, Stream.SPATIAL)
    draws = [uniforms.draw(k) for k in range(s.neighbors)]
    donors = [_own(moment, cut(fresh, rows), rows)]
    for row in find_neighbors(here, moment.visible, width, s, draws):
        dx, dy = here % width - row % width, here // width - row // width
        way = _within(moment), here, fresh, row, dx.astype(float), dy.astype(float)
        donors.append(AreaDonor(*way))
    decisions = [np.zeros(len(here)), *(draw[2] for draw in draws)]
    return resample(donors, decisions, s.mis, s.spatial_cap, target)


def _within(moment: Moment) -> AreaShift:
    """Between pixels of this frame: x_1 moves with its place."""
    return AreaShift(moment.shift, "move", moment.world, moment.world)


def _own(moment: Moment, reservoirs: Reservoirs, rows: slice) -> AreaDonor:
    here, none = np.arange(rows.start, rows.stop), np.zeros(len(reservoirs.M))
    at = np.arange(len(here))
    return AreaDonor(
        _within(moment), here, reservoirs, at, none, none, same_domain=True
    )
