"""Algorithm 4: pixels resample what their neighbours keep."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices, Masks, Scalars
from reference.passes.history import History
from reference.passes.neighbors import NONE, find_neighbors
from reference.passes.normalization import (
    HISTORY,
    OWN,
    Stream,
    drop_hidden,
    normalization,
    sees,
)
from reference.records import concatenate, cut, keep, take, where
from reference.resampling.reservoir import (
    Reservoirs,
    Samples,
    cap_confidence,
    finalize,
    merge,
    reused_candidates,
)
from reference.resampling.shift import reconnection_jacobian
from reference.resampling.target import target
from reference.rng import Uniforms
from reference.scene.surface import (
    SurfacePoints,
    VisiblePoints,
)
from reference.settings import Settings
from reference.world import World


def spatial_pass(
    world: World,
    rows: slice,
    visible: VisiblePoints,
    temporal: Reservoirs,
    history: History | None,
    settings: Settings,
    uniforms: Uniforms,
) -> Reservoirs:
    """Resample the temporal reservoirs of similar pixels nearby.

    Parameters
    ----------
    world : World
        The scene.
    rows : slice
        K consecutive pixels, to be resampled.
    visible : VisiblePoints
        Of the whole frame, at which ``temporal`` stands.
    temporal : Reservoirs
        Of the whole frame.
    history : History or None
        Spatial reservoirs of the whole last frame, at the same visible points;
        ``None`` after a reset.
    settings : Settings
        Weights, visibility, caps and search.
    uniforms : Uniforms
        K rows.  Dimension s, lanes 0 and 1: neighbour s; lane 2: whether it is kept.
        Dimension 63, lane 0: the same for the pixel's own temporal reservoir.

    Returns
    -------
    Reservoirs
        K rows; M at most ``settings.spatial_cap``.

    Notes
    -----
    [Ouyang21, Alg. 4 and section 5]: pixels whose M is below half of its limit try
    more neighbours.
    """
    pixels = _Pixels(
        np.arange(rows.start, rows.stop),
        cut(visible.surface, rows),
        cut(temporal, rows),
        cut(history.reservoirs, rows) if history else None,
    )
    few: Masks = np.zeros(len(pixels.rows), bool)
    if pixels.past is not None:
        few = settings.spatial_cap / 2.0 <= pixels.past.M

    def resample(mask: Masks, tries: int) -> Reservoirs:
        some = uniforms if mask.all() else uniforms.rows(np.flatnonzero(mask))
        chosen = keep(pixels, mask)
        return _resample(world, chosen, visible, temporal, settings, some, tries)

    if not few.any():
        return resample(~few, settings.iterations_many)
    if few.all():
        return resample(few, settings.iterations_few)
    parts = [
        resample(~few, settings.iterations_many),
        resample(few, settings.iterations_few),
    ]
    return take(concatenate(parts), np.argsort(np.argsort(few, kind="stable")))


@dataclass(frozen=True, slots=True)
class _Pixels:
    """Pixels to be resampled, with what is their own."""

    rows: Indices
    points: SurfacePoints
    own: Reservoirs
    past: Reservoirs | None


def _resample(
    world: World,
    pixels: _Pixels,
    visible: VisiblePoints,
    temporal: Reservoirs,
    settings: Settings,
    uniforms: Uniforms,
    tries: int,
) -> Reservoirs:
    draws = [uniforms.draw(s) for s in range(tries)]
    width = world.camera.width
    neighbors = find_neighbors(pixels.rows, visible, width, settings, draws)
    # Lines 2 to 15: stream the candidates.
    stream = _stream_own(world, pixels, settings, uniforms.draw(63)[0])
    for neighbor, u in zip(neighbors, draws, strict=True):
        stream = _stream_neighbor(
            world, pixels.points, visible, temporal, settings, stream, neighbor, u[2]
        )
    y = _sample_of(stream, temporal, pixels.past)
    # Lines 16 to 20: divide by the confidences of those that could have made it.
    total = normalization(world, pixels.points, visible, settings, stream, y)
    kept = finalize(replace(stream.chosen, y=y), total)
    if settings.visibility == "chosen":
        kept = drop_hidden(world, pixels.points, kept)
    return cap_confidence(kept, settings.spatial_cap)


def _stream_own(
    world: World, pixels: _Pixels, settings: Settings, u: Scalars
) -> Stream:
    # The pixel's own temporal reservoir always takes part: without it the supports of
    # the others need not cover the pixel's domain.
    rows, points, own, past = pixels.rows, pixels.points, pixels.own, pixels.past
    x = points.viewpoints
    slot = np.full(len(rows), OWN, np.int8)
    p_hat = target(settings.target, world.materials, points, own.y)
    new = reused_candidates(Reservoirs(slot, own.W, own.M), p_hat)
    if past is None:
        nobody, nothing = np.full(len(rows), NONE), np.zeros(len(rows))
        return Stream([nobody, rows], [x, x], [nothing, own.M], new)
    slot = np.full(len(rows), HISTORY, np.int8)
    p_hat = target(settings.target, world.materials, points, past.y)
    old = reused_candidates(Reservoirs(slot, past.W, past.M), p_hat)
    return Stream([rows, rows], [x, x], [past.M, own.M], merge(old, new, u))


def _stream_neighbor(
    world: World,
    points: SurfacePoints,
    visible: VisiblePoints,
    temporal: Reservoirs,
    settings: Settings,
    stream: Stream,
    neighbor: Indices,
    u: Scalars,
) -> Stream:
    there = neighbor != NONE
    donor = np.where(there, neighbor, 0)
    r = take(temporal, donor)
    # Lines 10 and 11: the sample seen from here, in the measure of here.
    x = take(visible.surface.viewpoints, donor)
    jacobian = reconnection_jacobian(
        x.position, points.position, r.y.position, r.y.normal
    )
    p_hat = target(settings.target, world.materials, points, r.y)
    slot = np.full(len(donor), len(stream.donors), np.int8)
    M = np.where(there, r.M, 0.0)
    candidate = reused_candidates(Reservoirs(slot, r.W, M), p_hat, jacobian)
    # Lines 12 and 13: nothing comes from a sample that is hidden; M counts it.
    if settings.visibility == "all":
        seen = sees(world, points, r.y, candidate.w > 0)
        candidate = replace(candidate, w=np.where(seen, candidate.w, 0.0))
    # Line 14.
    chosen = merge(stream.chosen, candidate, u)
    return Stream([*stream.donors, neighbor], [*stream.x, x], [*stream.M, M], chosen)


def _sample_of(
    stream: Stream, temporal: Reservoirs, past: Reservoirs | None
) -> Samples:
    slot = stream.chosen.y
    donor = np.stack(stream.donors)[slot, np.arange(len(slot))]
    y: Samples = take(temporal.y, donor)
    return y if past is None else where(slot == HISTORY, past.y, y)
