"""ReSTIR PT: the frame loop of ReSTIR GI, on whole paths."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from extensions.candidates import draw_paths
from extensions.connection import CRITERIA
from extensions.donors import PointDonor
from extensions.pt_settings import PathSettings
from extensions.reuse import resample
from extensions.shifting import Shift
from reference.arrays import Indices, Vec3s
from reference.passes.gbuffer import visible_points
from reference.passes.neighbors import find_neighbors
from reference.passes.reproject import reproject
from reference.records import cut
from reference.resampling.reservoir import Reservoirs, finalize
from reference.rng import KeyedUniforms, Stream, Uniforms
from reference.scene.animation import Animation, still
from reference.scene.camera import pixel_centers
from reference.scene.surface import VisiblePoints
from reference.schedule import Schedule, in_bands
from reference.world import World, next_world


@dataclass(frozen=True, slots=True, eq=False)
class PathFrame:
    """What one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int
        From 0.
    world : World
        The scene as it was.
    visible : VisiblePoints
        G-buffer.
    reservoirs : Reservoirs
        Of `Paths`, at the visible points.
    color : (N, 3) float64, W/(m² sr)
        Indirect light.
    """

    number: int
    world: World
    visible: VisiblePoints
    reservoirs: Reservoirs
    color: Vec3s


@dataclass(frozen=True, slots=True, eq=False)
class _Moment:
    """What the passes of one frame share."""

    number: int
    world: World
    visible: VisiblePoints
    settings: PathSettings
    bounces: int
    seed: int

    @property
    def pixels(self) -> int:
        return len(self.visible.depth)

    @property
    def shift(self) -> Shift:
        return Shift(CRITERIA[self.settings.shift], self._of_paths)

    def _of_paths(self, number: Indices) -> Uniforms:
        pixel = (number % self.pixels).astype(np.uint32)
        return KeyedUniforms(pixel, number // self.pixels, self.seed, Stream.PATH)

    def uniforms(self, rows: slice, stream: Stream) -> Uniforms:
        pixel = np.arange(rows.start, rows.stop, dtype=np.uint32)
        return KeyedUniforms(pixel, self.number, self.seed, stream)


def render_path_frames(
    world: World,
    settings: PathSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[PathFrame]:
    """Frames of indirect light by ReSTIR PT, without end.

    Parameters
    ----------
    world : World
        The scene in frame 0.
    settings : PathSettings
        The algorithm.
    bounces : int
        Bounces of indirect light, 1 to 30.
    seed : int
        Runs of different seeds are independent.
    schedule : Schedule
        Bands and threads; no influence on the result.
    animation : Animation, optional
        Validated scenes of all frames; by default the scene stands still.  Where
        shapes or lights move, every frame begins anew: their paths are of another
        scene.

    Yields
    ------
    PathFrame
        Frame after frame, each resampling what the last one left.

    Notes
    -----
    [Lin22, section 6].
    """
    animation = animation or still(world.scene)
    x, y = pixel_centers(world.camera.width, world.camera.height)

    def g_buffer(now: World) -> VisiblePoints:
        return in_bands(schedule, len(x), lambda r: visible_points(now, x[r], y[r]))

    last: PathFrame | None = None
    while True:
        now = next_world(last.world, animation(last.number + 1)) if last else world
        visible = last.visible if last and now is last.world else g_buffer(now)
        number = last.number + 1 if last else 0
        moment = _Moment(number, now, visible, settings, bounces, seed)
        before = None if animation.changes == "scene" else last
        last = _frame(moment, before, schedule)
        yield last


def _frame(moment: _Moment, last: PathFrame | None, schedule: Schedule) -> PathFrame:
    rows = moment.pixels
    past = _rows_before(moment, last)
    fresh = in_bands(
        schedule, rows, lambda r: _drawn_and_temporal(moment, last, past, r)
    )
    kept = fresh
    if moment.settings.spatial:
        # Every pixel's reservoir is complete before a neighbour reads it.
        kept = in_bands(schedule, rows, lambda r: _spatial(moment, fresh, r))
    color = kept.y.value * kept.W[:, None]
    return PathFrame(moment.number, moment.world, moment.visible, kept, color)


def _rows_before(moment: _Moment, last: PathFrame | None) -> Indices | None:
    """Where each pixel finds its past; ``None`` where all are at their own place."""
    if last is None or last.world is moment.world:
        return None
    return reproject(
        last.world, last.visible, moment.world, moment.visible, None, moment.settings
    )


def _drawn_and_temporal(
    moment: _Moment, last: PathFrame | None, past: Indices | None, rows: slice
) -> Reservoirs:
    points = cut(moment.visible.surface, rows)
    shift = moment.shift
    number = np.arange(rows.start, rows.stop) + moment.number * moment.pixels
    tree = draw_paths(
        moment.world,
        points,
        moment.bounces,
        shift.criterion,
        number,
        shift.uniforms(number),
    )
    new = finalize(tree, tree.M)
    if last is None or not moment.settings.temporal:
        return new
    here = np.arange(len(points))
    now = shift, moment.world, points
    own = PointDonor(*now, moment.world, points, new, here, stands=True)
    rows_before = np.arange(rows.start, rows.stop) if past is None else past[rows]
    before = PointDonor(
        *now,
        last.world,
        last.visible.surface,
        last.reservoirs,
        rows_before,
        stands=past is None,
    )
    u = moment.uniforms(rows, Stream.TEMPORAL).draw(0)[0]
    s = moment.settings
    return resample([before, own], [u, u], s.mis, s.temporal_cap)


def _spatial(moment: _Moment, fresh: Reservoirs, rows: slice) -> Reservoirs:
    s, surface = moment.settings, moment.visible.surface
    here = np.arange(rows.start, rows.stop)
    uniforms = moment.uniforms(rows, Stream.SPATIAL)
    draws = [uniforms.draw(k) for k in range(s.neighbors)]
    width = moment.world.camera.width
    around = find_neighbors(here, moment.visible, width, s, draws)
    now = moment.shift, moment.world, cut(surface, rows)

    def lent(row: Indices, stands: bool) -> PointDonor:
        return PointDonor(*now, moment.world, surface, fresh, row, stands)

    donors = [lent(here, stands=True), *(lent(row, stands=False) for row in around)]
    decisions = [np.zeros(len(here)), *(draw[2] for draw in draws)]
    return resample(donors, decisions, s.mis, s.spatial_cap)
