"""ReSTIR GI: the frame loop of Figures 4 and 10."""

from collections.abc import Iterator
from dataclasses import replace

from reference.passes.boiling import boiling_filter
from reference.passes.gbuffer import visible_points
from reference.passes.halves import (
    reuses_neighbors,
    samples_and_temporal,
    spatial_and_shade,
)
from reference.passes.moment import Frame, Moment
from reference.passes.past import past_of
from reference.scene.animation import Animation, Changes, still
from reference.scene.camera import pixel_centers
from reference.scene.surface import VisiblePoints
from reference.schedule import Schedule, in_bands
from reference.settings import Settings
from reference.world import World, next_world

__all__ = ["Frame", "next_frame", "render_frames"]


def render_frames(
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[Frame]:
    """Frames of indirect light by ReSTIR GI, without end.

    Parameters
    ----------
    world : World
        The scene in frame 0.
    settings : Settings
        The algorithm.
    bounces : int
        Bounces of indirect light, 1 to 30.
    seed : int
        Runs of different seeds are independent.
    schedule : Schedule
        Bands and threads; no influence on the result.
    animation : Animation, optional
        Validated scenes of all frames, with cameras of one size; by default the scene
        stands still.

    Yields
    ------
    Frame
        Frame after frame, each resampling what the last one left.
    """
    animation = animation or still(world.scene)
    rows = world.camera.width * world.camera.height
    x, y = pixel_centers(world.camera.width, world.camera.height)

    def g_buffer(now: World) -> VisiblePoints:
        return in_bands(schedule, rows, lambda r: visible_points(now, x[r], y[r]))

    last: Frame | None = None
    while True:
        now = next_world(last.world, animation(last.number + 1)) if last else world
        visible = last.visible if last and now is last.world else g_buffer(now)
        changes = animation.changes
        last = next_frame(
            now, settings, bounces, seed, schedule, visible, last, changes
        )
        yield last


def next_frame(
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    visible: VisiblePoints,
    last: Frame | None,
    changes: Changes = "nothing",
) -> Frame:
    """One frame of ReSTIR GI.

    Parameters
    ----------
    world : World
        The scene.
    settings : Settings
        The algorithm.
    bounces : int
        Bounces of indirect light.
    seed : int
        Of the run.
    schedule : Schedule
        Bands and threads.
    visible : VisiblePoints
        G-buffer of this frame.
    last : Frame or None
        What the last frame left.
    changes : 'nothing', 'camera' or 'scene'
        What may differ between frames of the run.

    Returns
    -------
    Frame
        With the next number.

    Notes
    -----
    [Ouyang21, Fig. 4 and 10].
    """
    number = 0 if last is None else last.number + 1
    moment = Moment(number, world, visible, settings, bounces, seed, schedule, changes)
    past = past_of(moment, last)
    # Every pixel's temporal reservoir is complete before a neighbour reads it.
    fresh = in_bands(
        schedule, moment.pixels, lambda r: samples_and_temporal(moment, past, r)
    )
    if settings.boiling_filter:
        width, strength = world.camera.width, settings.boiling_filter
        calm = boiling_filter(fresh.kept.reservoirs, width, strength)
        fresh = replace(fresh, kept=replace(fresh.kept, reservoirs=calm))
    shaded = in_bands(
        schedule, moment.pixels, lambda r: spatial_and_shade(moment, past, fresh, r)
    )
    temporal = fresh.kept.reservoirs
    spatial = shaded.spatial if reuses_neighbors(moment) else temporal
    return Frame(number, world, visible, temporal, spatial, shaded.color, shaded.seen)
