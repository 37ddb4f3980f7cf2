"""ReSTIR GI: the frame loop of Figure 4."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reference.arrays import Vec3s
from reference.passes.gbuffer import visible_points
from reference.passes.history import History
from reference.passes.initial import initial_samples
from reference.passes.shade import shade
from reference.passes.spatial import spatial_pass
from reference.passes.temporal import temporal_pass
from reference.records import cut
from reference.resampling.reservoir import Reservoirs
from reference.rng import KeyedUniforms, Stream
from reference.scene.camera import pixel_centers
from reference.scene.surface import VisiblePoints
from reference.schedule import Schedule, in_bands
from reference.settings import Settings
from reference.world import World


@dataclass(frozen=True, slots=True)
class Frame:
    """All that one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int
        From 0.
    visible : VisiblePoints
        G-buffer.
    temporal, spatial : Reservoirs
        Reservoirs at the visible points.
    color : (N, 3) float64, W/(m² sr)
        Indirect light.
    """

    number: int
    visible: VisiblePoints
    temporal: Reservoirs
    spatial: Reservoirs
    color: Vec3s


@dataclass(frozen=True, slots=True)
class _Fresh:
    temporal: Reservoirs
    unshared: Vec3s


@dataclass(frozen=True, slots=True)
class _Shaded:
    spatial: Reservoirs
    color: Vec3s


def render_frames(
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
) -> Iterator[Frame]:
    """Frames of indirect light by ReSTIR GI, without end.

    Parameters
    ----------
    world : World
        The scene.
    settings : Settings
        The algorithm.
    bounces : int
        Bounces of indirect light, 1 to 30.
    seed : int
        Runs of different seeds are independent.
    schedule : Schedule
        Bands and threads; no influence on the result.

    Yields
    ------
    Frame
        Frame after frame, each resampling what the last one left.
    """
    rows = world.camera.width * world.camera.height
    x, y = pixel_centers(world.camera.width, world.camera.height)
    visible = in_bands(schedule, rows, lambda r: visible_points(world, x[r], y[r]))
    last: Frame | None = None
    while True:
        last = next_frame(world, settings, bounces, seed, schedule, visible, last)
        yield last


def next_frame(
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    visible: VisiblePoints,
    last: Frame | None,
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
        What the last frame left at the same visible points.

    Returns
    -------
    Frame
        With the next number.

    Notes
    -----
    [Ouyang21, Fig. 4].
    """
    rows = len(visible.depth)
    number = 0 if last is None else last.number + 1
    temporal_history = spatial_history = None
    if last and settings.temporal:
        temporal_history = History(last.visible.surface, last.temporal)
        spatial_history = History(last.visible.surface, last.spatial)

    def uniforms(stream: Stream, r: slice) -> KeyedUniforms:
        pixel = np.arange(r.start, r.stop, dtype=np.uint32)
        return KeyedUniforms(pixel, number, seed, stream)

    def initial_and_temporal(r: slice) -> _Fresh:
        points = cut(visible.surface, r)
        initial = initial_samples(
            world,
            points,
            settings.source,
            settings.glossy_samples,
            bounces,
            uniforms(Stream.INITIAL, r),
            uniforms(Stream.PATH, r),
            uniforms(Stream.SPECULAR, r),
        )
        temporal = temporal_pass(
            world,
            points,
            initial,
            cut(temporal_history, r),
            settings.target,
            settings.temporal_cap,
            uniforms(Stream.TEMPORAL, r),
        )
        return _Fresh(temporal, initial.unshared)

    # Every pixel's temporal reservoir is complete before a neighbour reads it.
    fresh = in_bands(schedule, rows, initial_and_temporal)

    def spatial_and_shade(r: slice) -> _Shaded:
        points = cut(visible.surface, r)
        spatial = cut(fresh.temporal, r)
        if settings.spatial:
            spatial = spatial_pass(
                world,
                r,
                visible,
                fresh.temporal,
                spatial_history,
                settings,
                uniforms(Stream.SPATIAL, r),
            )
        color = shade(world, points, spatial) + fresh.unshared[r]
        return _Shaded(spatial, color)

    shaded = in_bands(schedule, rows, spatial_and_shade)
    return Frame(number, visible, fresh.temporal, shaded.spatial, shaded.color)
