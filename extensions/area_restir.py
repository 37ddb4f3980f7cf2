"""Area ReSTIR: reservoirs of whole paths over the area of each pixel."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from extensions.area_donor import AreaDonor, Primary
from extensions.area_paths import draw_area_paths, target
from extensions.area_settings import AreaSettings
from extensions.frame_loop import Moment, PathFrame, path_frames
from extensions.reuse import resample
from reference.arrays import Indices, Scalars
from reference.passes.neighbors import NONE, find_neighbors
from reference.passes.reproject import alike_before, places_before, row_at
from reference.resampling.reservoir import Reservoirs, cap_confidence, finalize
from reference.rng import Stream
from reference.scene.animation import Animation
from reference.scene.camera import pixel_centers
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


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """A pixel of the last image that each pixel's past overlaps.

    Attributes
    ----------
    rows : (N,) int
        Of the last frame, or ``NONE``.
    dx, dy : (N,) float64, pixels
        How far places have moved since.
    share : (N,) float64
        Of the pixel's area, 0 without a past; of all windows together at most 1.
    """

    rows: Indices
    dx: Scalars
    dy: Scalars
    share: Scalars


def windows(last: PathFrame, moment: Moment) -> list[Window]:
    """Fractional motion vectors: where a pixel's area was a frame ago.

    Parameters
    ----------
    last : PathFrame
        The frame before.
    moment : Moment
        This one.

    Returns
    -------
    list of Window
        The four pixels around, whose parts of the area are disjoint; the pixel itself
        where nothing has moved.
    """
    camera = moment.world.camera
    x_now, y_now = pixel_centers(camera.width, camera.height)
    if last.world is moment.world:
        none = np.zeros(moment.pixels)
        return [Window(np.arange(moment.pixels), none, none, none + 1.0)]
    x, y = places_before(last.world, moment.world, moment.visible, None)
    left, top = np.floor(x - 0.5), np.floor(y - 0.5)
    found = []
    for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
        column, line = left + i, top + j
        rows = row_at(column + 0.5, line + 0.5, last.world)
        seen = last.world, last.visible, moment.world, moment.visible
        usable = alike_before(*seen, None, rows, moment.settings)
        overlap = (1.0 - np.abs(column + 0.5 - x)) * (1.0 - np.abs(line + 0.5 - y))
        rows = np.where(usable & (overlap > 0), rows, NONE)
        share = np.where(rows != NONE, overlap, 0.0)
        found.append(Window(rows, x_now - x, y_now - y, share))
    return found


def _frame(moment: Moment, last: PathFrame | None, schedule: Schedule) -> PathFrame:
    rows, settings = moment.pixels, moment.settings
    if last is None or not settings.temporal:
        fresh = in_bands(schedule, rows, lambda r: _drawn(moment, r))
    else:
        past = windows(last, moment)
        fresh = in_bands(schedule, rows, lambda r: _temporal(moment, last, past, r))
    kept = fresh
    if settings.spatial:
        # Every pixel's reservoir is complete before a neighbour reads it.
        kept = in_bands(schedule, rows, lambda r: _spatial(moment, fresh, r))
    color = kept.y.paths.value * kept.W[:, None]
    return PathFrame(moment.number, moment.world, moment.visible, kept, color)


def _drawn(moment: Moment, rows: slice) -> Reservoirs:
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
    moment: Moment, last: PathFrame, past: list[Window], rows: slice
) -> Reservoirs:
    new, s = _drawn(moment, rows), moment.settings
    assert isinstance(s, AreaSettings)
    everyone = np.arange(len(new.M))
    own = _donor(moment, s.primary, rows, new, everyone, stands=True)
    before, trust = [], new.M
    for window in past:
        row = window.rows[rows]
        donor = _donor(moment, s.primary, rows, last.reservoirs, row)
        before.append(
            replace(
                donor,
                world_from=last.world,
                dx=window.dx[rows],
                dy=window.dy[rows],
                stands=last.world is moment.world,
            )
        )
        M = last.reservoirs.M[np.maximum(row, 0)]
        trust = trust + M * window.share[rows]
    u = moment.uniforms(rows, Stream.TEMPORAL)
    decisions = [*u.draw(0)[: len(before)], u.draw(1)[0]]
    kept = resample([*before, own], decisions, s.mis, np.inf, target)
    # The windows are parts of one pixel: what they know of it are means, not sums.
    return cap_confidence(replace(kept, M=trust), s.temporal_cap)


def _spatial(moment: Moment, fresh: Reservoirs, rows: slice) -> Reservoirs:
    s, width = moment.settings, moment.world.camera.width
    here = np.arange(rows.start, rows.stop)
    uniforms = moment.uniforms(rows, Stream.SPATIAL)
    draws = [uniforms.draw(k) for k in range(s.neighbors)]
    around = find_neighbors(here, moment.visible, width, s, draws)
    donors = [_donor(moment, "move", rows, fresh, here, stands=True)]
    for row in around:
        donor = _donor(moment, "move", rows, fresh, row)
        dx, dy = here % width - row % width, here // width - row // width
        donors.append(replace(donor, dx=dx.astype(float), dy=dy.astype(float)))
    decisions = [np.zeros(len(here)), *(draw[2] for draw in draws)]
    return resample(donors, decisions, s.mis, s.spatial_cap, target)


def _donor(
    moment: Moment,
    primary: Primary,
    rows: slice,
    reservoirs: Reservoirs,
    row: Indices,
    stands: bool = False,
) -> AreaDonor:
    none = np.zeros(len(row))
    here = np.arange(rows.start, rows.stop)
    world = moment.world
    return AreaDonor(
        moment.shift, primary, world, here, world, reservoirs, row, none, none, stands
    )
