"""Area ReSTIR: reservoirs of whole paths over the area of each pixel."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from restir_gi.extensions.area_paths import draw_area_paths, target
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.area_shift import AreaNeighbor, AreaShift
from restir_gi.extensions.frame_loop import PathFrame, path_frames, path_shift
from restir_gi.extensions.windows import resample_past, windows
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs, finalize
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.transport.world import World


def render_area_frames(
    world: World,
    settings: AreaSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[PathFrame]:
    """Frames of indirect light by ReSTIR over the area of each pixel, without end.

    [Zhang24].  Which pixels are reused, and with what confidence, is decided by
    what their centres see: never by a sample.
    """
    return path_frames(
        next_frame,
        world,
        settings=settings,
        bounces=bounces,
        seed=seed,
        schedule=schedule,
        animation=animation,
    )


def next_frame(frame: FrameContext[AreaSettings], last: PathFrame | None) -> PathFrame:
    """One frame: new paths, temporal and spatial reuse, and the picture."""
    kept = area_reused(frame, last, partial(area_drawn, frame))
    color = kept.y.paths.value * kept.W[:, None]
    return PathFrame(
        frame.number,
        frame.world,
        visible=frame.visible,
        reservoirs=kept,
        color=color,
    )


def area_reused(
    frame: FrameContext[AreaSettings],
    last: PathFrame | None,
    drawn: Callable[[slice], Reservoirs],
) -> Reservoirs:
    """Temporal and spatial reuse over areas of what pixels have ``drawn``."""
    new, rows = drawn, frame.pixels
    if last is not None and frame.settings.temporal:
        new = partial(_temporal, frame, last, drawn)
    fresh = in_bands(frame.schedule, rows, new)
    if not frame.settings.spatial:
        return fresh
    # Every pixel's reservoir is complete before a neighbour reads it.
    return in_bands(frame.schedule, rows, partial(_spatial, frame, fresh))


def area_drawn(frame: FrameContext[AreaSettings], rows: slice) -> Reservoirs:
    """Paths that the areas of K pixels draw in this frame; M = 1."""
    shift, number = path_shift(frame), frame.numbers(rows)
    tree = draw_area_paths(
        frame.world,
        np.arange(rows.start, rows.stop),
        place=frame.uniforms(Stream.PIXEL, rows).draw(0),
        bounces=frame.bounces,
        criterion=shift.criterion,
        number=number,
        uniforms=shift.uniforms(number),
    )
    return finalize(tree, tree.M)


def _temporal(
    frame: FrameContext[AreaSettings],
    last: PathFrame,
    drawn: Callable[[slice], Reservoirs],
    rows: slice,
) -> Reservoirs:
    """The history of each area, window by window, and what it draws."""
    s, new = frame.settings, drawn(rows)
    own = _canonical(frame, new, np.arange(len(new.M)), rows)
    past = windows(frame, last, own.pixel)
    shift = AreaShift(path_shift(frame), s.primary, last.world, frame.world)
    history = [
        AreaNeighbor(
            shift=shift,
            pixel=own.pixel,
            reservoirs=last.reservoirs,
            rows=window.rows,
            dx=window.dx,
            dy=window.dy,
            same_domain=last.world is frame.world,
        )
        for window in past
    ]
    shares = [window.share for window in past]
    u = frame.uniforms(Stream.TEMPORAL, rows)
    choices = [*u.draw(0)[: len(history)], u.draw(1)[0]]
    return resample_past(
        own, history, shares=shares, decisions=choices, settings=s, target=target
    )


def _spatial(
    frame: FrameContext[AreaSettings], fresh: Reservoirs, rows: slice
) -> Reservoirs:
    """The reservoir of each area, and those of its neighbours."""
    s, width = frame.settings, frame.world.camera.width
    here = np.arange(rows.start, rows.stop)
    uniforms = frame.uniforms(Stream.SPATIAL, rows)
    u = [uniforms.draw(k) for k in range(s.neighbors)]
    own = _canonical(frame, fresh, here, rows)
    neighbors = [
        replace(
            own,
            rows=row,
            dx=(here % width - row % width).astype(float),
            dy=(here // width - row // width).astype(float),
            same_domain=False,
        )
        for row in find_neighbors(here, frame.visible, width=width, settings=s, draws=u)
    ]
    choices = [np.zeros(len(here)), *(u_n[2] for u_n in u)]
    return resample([own, *neighbors], choices, s.mis, s.spatial_cap, target)


def _canonical(
    frame: FrameContext[AreaSettings], r: Reservoirs, at: Indices, rows: slice
) -> AreaNeighbor:
    """The pixels' own reservoirs; within a frame x_1 moves with its place."""
    none = np.zeros(rows.stop - rows.start)
    return AreaNeighbor(
        shift=AreaShift(path_shift(frame), "move", frame.world, frame.world),
        pixel=np.arange(rows.start, rows.stop),
        reservoirs=r,
        rows=at,
        dx=none,
        dy=none,
        same_domain=True,
    )
