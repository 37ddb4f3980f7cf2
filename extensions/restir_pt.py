"""ReSTIR PT: the frame loop of ReSTIR GI, on whole paths."""

from collections.abc import Callable, Iterator

import numpy as np

from extensions.candidates import draw_paths
from extensions.donors import PointDonor
from extensions.frame_loop import Moment, PathFrame, path_frames
from extensions.pt_settings import PathSettings
from reference.arrays import Indices
from reference.passes.neighbors import find_neighbors
from reference.passes.reproject import reproject
from reference.records import cut
from reference.resampling.generalized import resample
from reference.resampling.reservoir import Reservoirs, finalize
from reference.rng import Stream
from reference.scene.animation import Animation
from reference.schedule import Schedule, in_bands
from reference.world import World


def render_path_frames(
    world: World,
    settings: PathSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[PathFrame]:
    """Frames of indirect light by ReSTIR PT, without end [Lin22, section 6].

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result

    Returns
    -------
    iterator of PathFrame; each pixel's path begins at what its centre sees
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(moment: Moment, last: PathFrame | None, schedule: Schedule) -> PathFrame:
    kept = reused(moment, last, lambda rows: _drawn(moment, rows), schedule)
    color = kept.y.value * kept.W[:, None]
    return PathFrame(moment.number, moment.world, moment.visible, kept, color)


def reused(
    moment: Moment,
    last: PathFrame | None,
    drawn: Callable[[slice], Reservoirs],
    schedule: Schedule,
) -> Reservoirs:
    """Temporal and spatial reuse of whole paths, as the settings say.

    Parameters
    ----------
    last : PathFrame or None; the one before, if there is one
    drawn : callable; from some pixels to the paths that they draw anew
    """
    rows = moment.pixels
    past = _rows_before(moment, last)
    fresh = in_bands(
        schedule, rows, lambda r: _temporal(moment, last, past, r, drawn(r))
    )
    if not moment.settings.spatial:
        return fresh
    # Every pixel's reservoir is complete before a neighbour reads it.
    return in_bands(schedule, rows, lambda r: _spatial(moment, fresh, r))


def _drawn(moment: Moment, rows: slice) -> Reservoirs:
    shift, number = moment.shift, moment.numbers(rows)
    tree = draw_paths(
        moment.world,
        cut(moment.visible.surface, rows),
        moment.bounces,
        shift.criterion,
        number,
        shift.uniforms(number),
    )
    return finalize(tree, tree.M)


def _rows_before(moment: Moment, last: PathFrame | None) -> Indices | None:
    """Where each pixel finds its past; ``None`` where all are at their own place."""
    if last is None or last.world is moment.world:
        return None
    return reproject(
        last.world, last.visible, moment.world, moment.visible, None, moment.settings
    )


def _temporal(
    moment: Moment,
    last: PathFrame | None,
    past: Indices | None,
    rows: slice,
    new: Reservoirs,
) -> Reservoirs:
    if last is None or not moment.settings.temporal:
        return new
    points = cut(moment.visible.surface, rows)
    here = np.arange(len(points))
    now = moment.shift, moment.world, points
    own = PointDonor(*now, moment.world, points, new, here, same_domain=True)
    rows_before = np.arange(rows.start, rows.stop) if past is None else past[rows]
    before = PointDonor(
        *now,
        last.world,
        last.visible.surface,
        last.reservoirs,
        rows_before,
        same_domain=past is None,
    )
    u = moment.uniforms(rows, Stream.TEMPORAL).draw(0)[0]
    s = moment.settings
    return resample([before, own], [u, u], s.mis, s.temporal_cap)


def _spatial(moment: Moment, fresh: Reservoirs, rows: slice) -> Reservoirs:
    s, surface = moment.settings, moment.visible.surface
    here = np.arange(rows.start, rows.stop)
    uniforms = moment.uniforms(rows, Stream.SPATIAL)
    draws = [uniforms.draw(k) for k in range(s.neighbors)]
    width = moment.world.camera.width
    around = find_neighbors(here, moment.visible, width, s, draws)
    now = moment.shift, moment.world, cut(surface, rows)

    def lent(row: Indices, same_domain: bool) -> PointDonor:
        return PointDonor(*now, moment.world, surface, fresh, row, same_domain)

    donors = [
        lent(here, same_domain=True),
        *(lent(row, same_domain=False) for row in around),
    ]
    decisions = [np.zeros(len(here)), *(draw[2] for draw in draws)]
    return resample(donors, decisions, s.mis, s.spatial_cap)
