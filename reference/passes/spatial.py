"""Algorithm 4: pixels resample what their neighbours keep."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.passes.neighbors import NONE, find_neighbors
from reference.passes.normalization import (
    HISTORY,
    OWN,
    Stream,
    drop_hidden,
    normalization,
    sees,
)
from reference.records import concatenate, take, where
from reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    Samples,
    cap_confidence,
    finalize,
    merge,
    reused_candidates,
)
from reference.resampling.shift import reconnection_jacobian
from reference.resampling.target import target
from reference.rng import Draw, Uniforms
from reference.scene.surface import (
    SurfacePoints,
    VisiblePoints,
)
from reference.settings import Settings
from reference.world import World


def spatial_pass(
    world: World,
    rows: Indices,
    visible: VisiblePoints,
    temporal: Reservoirs,
    history: Reservoirs | None,
    settings: Settings,
    uniforms: Uniforms,
) -> Reservoirs:
    """Resample the temporal reservoirs of similar pixels nearby.

    Parameters
    ----------
    world : World
        The scene.
    rows : (K,) int
        Pixels to be resampled.
    visible : VisiblePoints
        Of the whole frame, at which ``temporal`` stands.
    temporal : Reservoirs
        Of the whole frame.
    history : Reservoirs or None
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
    many = np.ones(len(rows), bool)
    if history is not None:
        many = history.M[rows] < settings.spatial_cap / 2.0
    order = [np.flatnonzero(many), np.flatnonzero(~many)]
    tries = [settings.iterations_many, settings.iterations_few]
    parts = [
        _resample(
            world, rows[some], visible, temporal, history, settings,
            uniforms.rows(some), count,
        )
        for some, count in zip(order, tries, strict=True)
        if len(some)
    ]  # fmt: skip
    if len(parts) == 1:
        return parts[0]
    back = np.argsort(np.concatenate(order))
    return take(concatenate(parts), back)


def _resample(
    world: World,
    rows: Indices,
    visible: VisiblePoints,
    temporal: Reservoirs,
    history: Reservoirs | None,
    settings: Settings,
    uniforms: Uniforms,
    tries: int,
) -> Reservoirs:
    points = take(visible.surface, rows)
    draws = [uniforms.draw(s) for s in range(tries)]
    neighbors = find_neighbors(rows, visible, world.camera.width, settings, draws)
    # Lines 2 to 15: stream the candidates.
    own_u = uniforms.draw(63)[0]
    stream = _stream_own(world, rows, points, temporal, history, settings, own_u)
    for neighbor, u in zip(neighbors, draws, strict=True):
        stream = _stream_neighbor(
            world, points, visible, temporal, settings, stream, neighbor, u
        )
    y = _sample_of(stream, temporal, history, rows)
    c = stream.chosen
    chosen = Candidates(y=y, p_hat=c.p_hat, w=c.w, M=c.M)
    # Lines 16 to 20: divide by the confidences of those that could have made it.
    total = normalization(world, points, visible, settings, stream, y)
    kept = finalize(chosen, total)
    if settings.visibility == "chosen":
        kept = drop_hidden(world, points, kept)
    return cap_confidence(kept, settings.spatial_cap)


def _stream_own(
    world: World,
    rows: Indices,
    points: SurfacePoints,
    temporal: Reservoirs,
    history: Reservoirs | None,
    settings: Settings,
    u: Scalars,
) -> Stream:
    # The pixel's own temporal reservoir always takes part: without it the supports of
    # the others need not cover the pixel's domain.
    own = take(temporal, rows)
    slot = np.full(len(rows), OWN, np.int8)
    p_hat = target(settings.target, world.materials, points, own.y)
    chosen = reused_candidates(Reservoirs(slot, own.W, own.M), p_hat)
    if history is None:
        nobody, nothing = np.full(len(rows), NONE), np.zeros(len(rows))
        return Stream([nobody, rows], [nothing, own.M], chosen)
    past = take(history, rows)
    p_hat = target(settings.target, world.materials, points, past.y)
    before = Reservoirs(np.full(len(rows), HISTORY, np.int8), past.W, past.M)
    both = merge(reused_candidates(before, p_hat), chosen, u)
    return Stream([rows, rows], [past.M, own.M], both)


def _stream_neighbor(
    world: World,
    points: SurfacePoints,
    visible: VisiblePoints,
    temporal: Reservoirs,
    settings: Settings,
    stream: Stream,
    neighbor: Indices,
    u: Draw,
) -> Stream:
    there = neighbor != NONE
    donor = np.where(there, neighbor, 0)
    r = take(temporal, donor)
    M = np.where(there, r.M, 0.0)
    # Lines 10 and 11: the sample seen from here, in the measure of here.
    x_from = np.take(visible.surface.position, donor, axis=0)
    jacobian = reconnection_jacobian(x_from, points.position, r.y.position, r.y.normal)
    p_hat = target(settings.target, world.materials, points, r.y)
    slot = np.full(len(donor), len(stream.donors), np.int8)
    candidate = reused_candidates(Reservoirs(slot, r.W, M), p_hat, jacobian)
    # Lines 12 and 13: nothing comes from a sample that is hidden; M counts it.
    if settings.visibility == "all":
        rows = np.flatnonzero(candidate.w > 0)
        seen = np.zeros(len(donor), bool)
        seen[rows] = sees(world, take(points, rows), take(r.y, rows))
        candidate = Candidates(
            slot, candidate.p_hat, np.where(seen, candidate.w, 0.0), M
        )
    # Line 14.
    chosen = merge(stream.chosen, candidate, u[2])
    return Stream([*stream.donors, neighbor], [*stream.M, M], chosen)


def _sample_of(
    stream: Stream, temporal: Reservoirs, history: Reservoirs | None, rows: Indices
) -> Samples:
    slot = stream.chosen.y
    donor = np.stack(stream.donors)[slot, np.arange(len(rows))]
    y: Samples = take(temporal.y, donor)
    if history is None:
        return y
    return where(slot == HISTORY, take(history.y, rows), y)
