"""Area ReSTIR: reservoirs of whole paths over the area of each pixel."""

from collections.abc import Callable, Iterator

import numpy as np

from extensions.area_donor import AreaDonor, AreaShift
from extensions.area_paths import draw_area_paths, target
from extensions.area_settings import AreaSettings
from extensions.frame_loop import PathFrame, path_frames, path_shift
from extensions.windows import resample_past, windows
from reference.frame import FrameContext
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

    Parameters
    ----------
    world : World
        The scene in frame 0.
    settings : AreaSettings
        The algorithm.
    bounces : int
        Bounces of indirect light, 1 to 30.
    seed : int
        Runs of different seeds are independent.
    schedule : Schedule
        Bands and threads; no influence on the result.
    animation : Animation, optional
        As of `path_frames`.

    Returns
    -------
    iterator of PathFrame
        Means over the areas of the pixels; samples are `AreaPaths`.

    Notes
    -----
    [Zhang24].  Which pixels lend, and how far they are trusted, is decided by what
    their centres see: never by a sample.
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(frame: FrameContext[AreaSettings], last: PathFrame | None) -> PathFrame:
    kept = area_reused(frame, last, lambda r: area_drawn(frame, r))
    color = kept.y.paths.value * kept.W[:, None]
    return PathFrame(frame.number, frame.world, frame.visible, kept, color)


def area_reused(
    frame: FrameContext[AreaSettings],
    last: PathFrame | None,
    drawn: Callable[[slice], Reservoirs],
) -> Reservoirs:
    """Temporal and spatial reuse over areas, as the settings say.

    Parameters
    ----------
    frame : FrameContext
        This frame.
    last : PathFrame or None
        The one before, if there is one.
    drawn : callable
        From some pixels to the paths that they draw anew.

    Returns
    -------
    Reservoirs
        Of `AreaPaths`, a pixel each.
    """
    rows, settings = frame.pixels, frame.settings
    if last is None or not settings.temporal:
        fresh = in_bands(frame.schedule, rows, drawn)
    else:
        fresh = in_bands(
            frame.schedule, rows, lambda r: _temporal(frame, last, drawn(r), r)
        )
    if not settings.spatial:
        return fresh
    # Every pixel's reservoir is complete before a neighbour reads it.
    return in_bands(frame.schedule, rows, lambda r: _spatial(frame, fresh, r))


def area_drawn(frame: FrameContext[AreaSettings], rows: slice) -> Reservoirs:
    """Paths that the areas of pixels draw anew.

    Parameters
    ----------
    frame : FrameContext
        This frame.
    rows : slice
        K pixels.

    Returns
    -------
    Reservoirs
        Of `AreaPaths`, K rows; M = 1.
    """
    shift, number = path_shift(frame), frame.numbers(rows)
    tree = draw_area_paths(
        frame.world,
        np.arange(rows.start, rows.stop),
        frame.uniforms(Stream.PIXEL, rows).draw(0),
        frame.bounces,
        shift.criterion,
        number,
        shift.uniforms(number),
    )
    return finalize(tree, tree.M)


def _temporal(
    frame: FrameContext[AreaSettings],
    last: PathFrame,
    new: Reservoirs,
    rows: slice,
) -> Reservoirs:
    s, here = frame.settings, np.arange(rows.start, rows.stop)
    shift = AreaShift(path_shift(frame), s.primary, last.world, frame.world)
    stands = last.world is frame.world
    past = windows(frame, last, here)
    before = [
        AreaDonor(shift, here, last.reservoirs, part.rows, part.dx, part.dy, stands)
        for part in past
    ]
    shares = [part.share for part in past]
    u = frame.uniforms(Stream.TEMPORAL, rows)
    decisions = [*u.draw(0)[: len(before)], u.draw(1)[0]]
    own = _own(frame, new, rows)
    return resample_past(own, before, shares, decisions, s, target)


def _spatial(
    frame: FrameContext[AreaSettings], fresh: Reservoirs, rows: slice
) -> Reservoirs:
    s, width = frame.settings, frame.world.camera.width
    here = np.arange(rows.start, rows.stop)
    uniforms = frame.uniforms(Stream.SPATIAL, rows)
    draws = [uniforms.draw(k) for k in range(s.neighbors)]
    donors = [_own(frame, cut(fresh, rows), rows)]
    for row in find_neighbors(here, frame.visible, width, s, draws):
        dx, dy = here % width - row % width, here // width - row // width
        way = _within(frame), here, fresh, row, dx.astype(float), dy.astype(float)
        donors.append(AreaDonor(*way))
    decisions = [np.zeros(len(here)), *(draw[2] for draw in draws)]
    return resample(donors, decisions, s.mis, s.spatial_cap, target)


def _within(frame: FrameContext[AreaSettings]) -> AreaShift:
    """Between pixels of this frame: x_1 moves with its place."""
    return AreaShift(path_shift(frame), "move", frame.world, frame.world)


def _own(
    frame: FrameContext[AreaSettings], reservoirs: Reservoirs, rows: slice
) -> AreaDonor:
    here, none = np.arange(rows.start, rows.stop), np.zeros(len(reservoirs.M))
    at = np.arange(len(here))
    return AreaDonor(_within(frame), here, reservoirs, at, none, none, same_domain=True)
