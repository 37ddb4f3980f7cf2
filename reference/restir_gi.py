"""ReSTIR GI: the frame loop of Figures 4 and 10."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isfinite
from typing import Generic, Literal, TypeVar

import numpy as np

from restir_gi.reference.frame import FrameContext, frames
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.numerics.records import concatenate, cut, indices, select, take
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.options.boiling import boiling_filter
from restir_gi.reference.options.fused import fused_resampling
from restir_gi.reference.options.history import moved_history
from restir_gi.reference.options.jacobian import with_jacobian
from restir_gi.reference.options.masks import who_draws, who_keeps
from restir_gi.reference.options.neighborhood import special_neighbors
from restir_gi.reference.options.roulette import tail_weights
from restir_gi.reference.options.storage import stored
from restir_gi.reference.options.visibility import (
    finally_seen,
    trusting,
    without_hidden,
)
from restir_gi.reference.options.weights import resample_weighted
from restir_gi.reference.passes.initial import InitialSamples, initial_samples
from restir_gi.reference.passes.neighbors import neighbors_of
from restir_gi.reference.passes.pixels import (
    FrameReservoirs,
    History,
    NeighborPixels,
    Pixels,
)
from restir_gi.reference.passes.shade import shade
from restir_gi.reference.passes.spatial import spatial_resampling
from restir_gi.reference.passes.temporal import temporal_resampling
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.not_reused import reuses_all
from restir_gi.reference.transport.world import World

OWN = 63
"""Dimension that decides on the pixel's own reservoir; the others are neighbours'."""


@dataclass(frozen=True, slots=True)
class Frame:
    """All that one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int; from 0
    world : World; the scene as it was
    temporal, spatial : Reservoirs
        Reservoirs at the visible points; the same where all reuse is one pass.
    color : (N, 3) float64, W/(m² sr); indirect light
    seen : (N,) bool or None
        Whether the visible point sees the sample that is shown; ``None`` where that is
        part of W.
    """

    number: int
    world: World
    visible: VisiblePoints
    temporal: Reservoirs
    spatial: Reservoirs
    color: Vec3s
    seen: Masks | None


def render_frames(
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[Frame]:
    """Frames of indirect light by ReSTIR GI, without end.

    Arguments as of `restir_gi.reference.frame.frames`; each frame resamples what the
    last one left.
    """
    return frames(next_frame, world, settings, bounces, seed, schedule, animation)


def next_frame(frame: FrameContext[Settings], last: Frame | None) -> Frame:
    """One frame of ReSTIR GI [Ouyang21, Fig. 4 and 10].

    Its picture, and its reservoirs for the next.

    Parameters
    ----------
    last : Frame or None; what the last one left
    """
    s, pixels = frame.settings, frame.pixels
    history = history_of(frame, last)
    first = in_bands(
        frame.schedule, pixels, lambda r: initial_and_temporal(frame, history, r)
    )
    if s.boiling_filter:
        first = replace(first, temporal=_calm(frame, first.temporal))
    # Every pixel's temporal reservoir is complete before a neighbour reads it.
    second = in_bands(
        frame.schedule, pixels, lambda r: spatial_and_shade(frame, history, first, r)
    )
    return Frame(
        number=frame.number,
        world=frame.world,
        visible=frame.visible,
        temporal=first.temporal,
        spatial=second.spatial if reuses_neighbors(s) else first.temporal,
        color=second.color,
        seen=second.seen,
    )


def history_of(frame: FrameContext[Settings], last: Frame | None) -> History | None:
    """What the last frame hands on; ``None`` where nothing is reused over time."""
    s = frame.settings
    if last is None or not s.temporal:
        return None
    temporal = FrameReservoirs(last.world, last.visible, last.temporal)
    spatial = temporal
    if last.spatial is not last.temporal:
        spatial = FrameReservoirs(last.world, last.visible, last.spatial)
    history = History(temporal, spatial, seen=last.seen)
    if frame.changes == "nothing" and not s.permutation and not isfinite(s.max_age):
        return history
    return moved_history(frame, history)


# ---------------------------------------------------------------- the first half


@dataclass(frozen=True, slots=True, eq=False)
class FirstHalf:
    """What is complete before pixels read their neighbours, K rows.

    Attributes
    ----------
    temporal : Reservoirs; as they are stored
    not_reused : (K, 3) float64, W/(m² sr); light that no reservoir holds
    """

    temporal: Reservoirs
    not_reused: Vec3s


def initial_and_temporal(
    frame: FrameContext[Settings], history: History | None, r: slice
) -> FirstHalf:
    """Algorithms 2 and 3 for K pixels."""
    given = temporal_input(frame, history, r)
    kept = resampled(given, frame.settings, frame.settings.temporal_cap)
    return FirstHalf(_stored(frame, kept, r), given.own.not_reused)


def temporal_input(
    frame: FrameContext[Settings], history: History | None, r: slice
) -> "PassInput[InitialSamples]":
    """New samples of K pixels, and what the last frame left them."""
    s, q = frame.settings, pixels_of(frame, r)
    new = _draw(frame, history, q, r)
    past = _past(history, "temporal", q, r, new.y)
    if s.reuse != "fused":
        u = frame.uniforms(Stream.TEMPORAL, r).draw(0)[0]
        return PassInput(q, past, new, u, [])
    uniforms = frame.uniforms(Stream.SPATIAL, r)
    tries = s.iterations_few if s.spatial else 0
    around = special_neighbors(frame, history, None, q, r, uniforms, tries)
    return PassInput(q, past, new, uniforms.draw(OWN)[0], around)


def _draw(
    frame: FrameContext[Settings], history: History | None, q: Pixels, r: slice
) -> InitialSamples:
    s, numbers = frame.settings, frame.numbers(r)
    tail = tail_weights(frame) if s.roulette < 1 else None
    ages = isfinite(s.max_age)
    masked = s.lattice > 1 or s.checkerboard or s.validate_every > 0
    drawn = who_draws(frame, history, r) if masked else None
    # Light that is not reused is wanted of every pixel in every frame.
    idle = reuses_all(frame.world, s.source, s.glossy_samples)
    new = initial_samples(
        frame.world,
        q.points,
        s.source,
        s.glossy_samples,
        frame.bounces,
        directions=frame.uniforms(Stream.INITIAL, r),
        paths=frame.uniforms(Stream.PATH, r),
        speculars=frame.uniforms(Stream.SPECULAR, r),
        numbers=numbers if frame.changes == "scene" or ages else None,
        tail=tail(numbers) if tail else None,
        active=drawn if idle else None,
    )
    return new if drawn is None else replace(new, M=drawn.astype(float))


# ---------------------------------------------------------------- the second half


@dataclass(frozen=True, slots=True, eq=False)
class SecondHalf:
    """What the frame ends with, K rows.

    Attributes
    ----------
    spatial : Reservoirs; as they are stored
    color : (K, 3) float64, W/(m² sr); indirect light
    seen : (K,) bool or None; final visibility, where it was asked for
    """

    spatial: Reservoirs
    color: Vec3s
    seen: Masks | None


def spatial_and_shade(
    frame: FrameContext[Settings], history: History | None, first: FirstHalf, r: slice
) -> SecondHalf:
    """Algorithm 4 for K pixels, and their light by Equation 8."""
    s, q = frame.settings, pixels_of(frame, r)
    kept = cut(first.temporal, r)
    if reuses_neighbors(s):
        kept = _joined(
            [
                (rows, resampled(given, s, s.spatial_cap))
                for rows, given in spatial_inputs(frame, history, first.temporal, r)
            ]
        )
    color, seen = shade(frame.world, q.points, kept), None
    if s.final_visibility != "in-weight":
        seen = finally_seen(frame, q, kept, history, r)
        color = np.where(seen[:, None], color, 0.0)
    spatial = _stored(frame, kept, r)
    keeps = who_keeps(frame, r) if s.lattice > 1 else None
    if keeps is not None:
        M, W = (np.where(keeps, a, 0.0) for a in (spatial.M, spatial.W))
        spatial = replace(spatial, M=M, W=W)
    return SecondHalf(spatial, color + first.not_reused[r], seen)


def reuses_neighbors(settings: Settings) -> bool:
    """Whether there is a spatial pass of its own."""
    return settings.spatial and settings.reuse != "fused"


def spatial_inputs(
    frame: FrameContext[Settings],
    history: History | None,
    temporal: Reservoirs,
    r: slice,
) -> Iterator[tuple[slice | Indices, "PassInput[Reservoirs]"]]:
    """What spatial resampling of pixels (K,) is given.

    Pixels whose spatial M is below half of its limit try more neighbours [Ouyang21,
    section 5]: they come apart from the others, each pixel once.
    """
    s = frame.settings
    few = np.zeros(r.stop - r.start, bool)
    if history is not None:
        few = s.spatial_cap / 2.0 <= history.confidence(history.spatial, r)
    for mask, tries in ((~few, s.iterations_many), (few, s.iterations_few)):
        if mask.any() or not len(mask):
            rows = r if mask.all() else r.start + np.flatnonzero(mask)
            yield rows, _spatial_input(frame, history, temporal, rows, tries)
        if not len(mask):
            break


def _spatial_input(
    frame: FrameContext[Settings],
    history: History | None,
    temporal: Reservoirs,
    rows: slice | Indices,
    tries: int,
) -> "PassInput[Reservoirs]":
    s, q, own = frame.settings, pixels_of(frame, rows), select(temporal, rows)
    past = _past(history, "spatial", q, rows, own.y)
    uniforms = frame.uniforms(Stream.SPATIAL, rows)
    here = FrameReservoirs(frame.world, frame.visible, temporal)
    if s.reuse != "separate" or s.boost_below > 0 or s.lattice > 1:
        source = here if s.reuse == "separate" else None
        around = special_neighbors(frame, history, source, q, rows, uniforms, tries)
    else:
        around = neighbors_of(q, here, indices(rows), uniforms, tries)
    return PassInput(q, past, own, uniforms.draw(OWN)[0], around)


def _joined(parts: list[tuple[slice | Indices, Reservoirs]]) -> Reservoirs:
    """Reservoirs of consecutive pixels, of which each part holds some."""
    if len(parts) == 1:
        return parts[0][1]
    order = np.argsort(np.concatenate([indices(rows) for rows, _ in parts]))
    return take(concatenate([kept for _, kept in parts]), order)


# ---------------------------------------------------------------- both halves

Own = TypeVar("Own", bound=InitialSamples | Reservoirs)


@dataclass(frozen=True, slots=True, eq=False)
class PassInput(Generic[Own]):
    """What the resampling of K pixels is given.

    Attributes
    ----------
    q : Pixels; K pixels
    past : Reservoirs or NeighborPixels; of the last frame
    own : InitialSamples or Reservoirs
        New samples; or, in the spatial pass, temporal reservoirs.
    u_own : (K,); the number that decides on them
    neighbors : list of (NeighborPixels, (K,)); with the numbers that decide
    """

    q: Pixels
    past: Reservoirs | NeighborPixels
    own: Own
    u_own: Scalars
    neighbors: list[tuple[NeighborPixels, Scalars]]


def resampled(
    given: PassInput[InitialSamples] | PassInput[Reservoirs],
    settings: Settings,
    cap: float,
) -> Reservoirs:
    """Reservoirs of K pixels by Algorithm 3 or 4, or as the settings have it."""
    q, past, own, mis = given.q, given.past, given.own, settings.mis
    u, around = given.u_own, given.neighbors
    if mis != "1/M" and mis != "1/Z":
        kept = resample_weighted(q, [(past, u), (own, u), *around], mis, cap)
    elif isinstance(own, Reservoirs):
        kept = spatial_resampling(q, past, own, around, u, cap=cap, mis=mis)
    elif settings.reuse == "fused":
        kept = fused_resampling(q, own, past, around, u, cap=cap, mis=mis)
    else:
        kept = temporal_resampling(q, own, past, u, cap=cap, mis=mis)
    shifts = bool(around) or isinstance(past, NeighborPixels)
    if settings.visibility == "chosen" and shifts:
        kept = without_hidden(q, kept)
    return kept


def pixels_of(frame: FrameContext[Settings], rows: slice | Indices) -> Pixels:
    """Pixels (K,), about to resample."""
    s = frame.settings
    q = Pixels(frame.world, select(frame.visible.surface, rows), s)
    if s.jacobian != "multiplied" or isfinite(s.jacobian_limit):
        q = with_jacobian(q)
    return q if s.visibility == "all" else trusting(q)


def _past(
    history: History | None,
    which: Literal["temporal", "spatial"],
    q: Pixels,
    rows: slice | Indices,
    y: Samples,
) -> Reservoirs | NeighborPixels:
    """What the last frame left K pixels; M = 0 after a reset."""
    if history is None:
        nothing = np.zeros(len(q.points))
        return Reservoirs(y, nothing, nothing)
    return history.of(getattr(history, which), q, rows)


def _stored(frame: FrameContext[Settings], kept: Reservoirs, r: slice) -> Reservoirs:
    storage, points = frame.settings.storage, cut(frame.visible.surface, r)
    return kept if storage == "float64" else stored(storage, points, kept, frame.pixels)


def _calm(frame: FrameContext[Settings], temporal: Reservoirs) -> Reservoirs:
    width, strength = frame.world.camera.width, frame.settings.boiling_filter
    return boiling_filter(temporal, width, strength)
