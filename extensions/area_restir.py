"""Area ReSTIR: reservoirs of whole paths over the area of each pixel."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.area_shift import (
    AreaNeighbor,
    AreaShift,
    draw_area_paths,
    target,
)
from restir_gi.extensions.frame_loop import PathFrame, path_frames, path_shift
from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.options.reprojection import alike_before, places_before, row_at
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.resampling.generalized import (
    SourceReservoirs,
    Target,
    resample,
)
from restir_gi.reference.resampling.reservoir import (
    Reservoirs,
    cap_confidence,
    finalize,
)
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.transport.world import World

# ------------- fractional motion: the parts of the last image that an area now covers


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """A pixel of the last image that the past of each of K pixels overlaps.

    Attributes
    ----------
    rows : (K,) int; of the last frame, or ``NONE``
    dx, dy : (K,) float64, pixels; how far places have moved since
    share : (K,) float64
        Of the pixel's area, 0 without a past; of all windows together at most 1.
    """

    rows: Indices
    dx: Scalars
    dy: Scalars
    share: Scalars


def windows(
    frame: FrameContext[PathSettings], last: PathFrame, pixel: Indices
) -> list[Window]:
    """Where the areas of pixels were a frame ago.

    [Zhang24].  What the centres see decides, never a sample.

    Parameters
    ----------
    pixel : (K,) int; rows of the image

    Returns
    -------
    list of Window
        The four pixels around, whose parts of the area are disjoint; the pixel itself
        where nothing has moved.
    """
    if last.world is frame.world:
        none = np.zeros(len(pixel))
        return [Window(pixel, none, none, none + 1.0)]
    visible, width = take(frame.visible, pixel), frame.world.camera.width
    x_now, y_now = pixel % width + 0.5, pixel // width + 0.5
    x, y = places_before(last.world, frame.world, visible, None)
    left, top = np.floor(x - 0.5), np.floor(y - 0.5)
    found = []
    for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
        column, line = left + i, top + j
        rows = row_at(column + 0.5, line + 0.5, last.world)
        seen = last.world, last.visible, frame.world, visible
        usable = alike_before(*seen, None, rows, frame.settings)
        overlap = (1.0 - np.abs(column + 0.5 - x)) * (1.0 - np.abs(line + 0.5 - y))
        rows = np.where(usable & (overlap > 0), rows, NONE)
        share = np.where(rows != NONE, overlap, 0.0)
        found.append(Window(rows, x_now - x, y_now - y, share))
    return found


def resample_past(
    own: SourceReservoirs,
    before: Sequence[SourceReservoirs],
    shares: Sequence[Scalars],
    decisions: list[Scalars],
    settings: PathSettings,
    target: Target,
) -> Reservoirs:
    """Resample the windows of each area's history, and what is new.

    Parameters
    ----------
    own : SourceReservoirs; the new samples, in their own domain
    shares : list of (K,); of the area, one for each neighbour of the last frame
    decisions : list of (K,)
        One number in [0, 1) for each of them, and for the new samples at last.
    """
    M = own.reservoirs.M
    for q_n, share in zip(before, shares, strict=True):
        # Windows are parts of one area: what they know of it are means, not sums.
        M = M + q_n.reservoirs.M[np.maximum(q_n.rows, 0)] * share
    kept = resample([*before, own], decisions, settings.mis, np.inf, target)
    return cap_confidence(replace(kept, M=M), settings.temporal_cap)


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
