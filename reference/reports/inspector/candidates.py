"""What a pass considered: every candidate of every pixel, and what was made of it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, divide_or_zero
from restir_gi.reference.numerics.records import NONE, indices, scatter
from restir_gi.reference.options.weights import Source, itself, weighed
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.passes.pixels import NeighborPixels, Pixels
from restir_gi.reference.reports.inspector.outcomes import Outcome, jacobians, outcomes
from restir_gi.reference.reports.inspector.provenance import Origin, Provenance
from restir_gi.reference.resampling import generalized, reuse
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    initial_candidates,
    merge,
)
from restir_gi.reference.restir_gi import PassInput, resampled
from restir_gi.reference.settings import Settings

NOT_ASKED = 2
"""Besides no, 0, and yes, 1."""


@dataclass(frozen=True, slots=True, eq=False)
class PassRecord:
    """Candidates of a pass, in C slots of the streams of N pixels.

    Attributes
    ----------
    roles : tuple of str; who stands in each slot
    frames : tuple of int; of which frame each of them is
    source : (N, C) int; pixel of that frame that the candidate comes from, or ``NONE``
    M, W, p_hat, jacobian, w : (N, C) float64
        Confidence; contribution weight where it comes from (sr); target at the
        pixel (radiance/sr); factor on W; weight in the stream.
    position : (N, C, 3) float64, m; sample point
    outcome : (N, C) int; of `Outcome`
    could : (N, C) int
        Whether it could have made the sample that was kept, or `NOT_ASKED`.
    kept : (N,) int; slot of the kept sample
    w_sum, total : (N,) float64
        Sum of w; what it was divided by: M, Z, or 1 where weights were divided before.
    number : (N,) int64; of the path that drew the kept sample
    """

    name: str
    roles: tuple[str, ...]
    frames: tuple[int, ...]
    source: Indices
    M: Scalars
    W: Scalars
    p_hat: Scalars
    jacobian: Scalars
    w: Scalars
    position: Scalars
    outcome: Indices
    could: Indices
    kept: Indices
    w_sum: Scalars
    total: Scalars
    number: Indices


Given = PassInput[InitialSamples] | PassInput[Reservoirs]


def recorded(
    name: str,
    parts: Iterable[tuple[slice | Indices, Given]],
    settings: Settings,
    provenance: Provenance,
) -> PassRecord:
    """What a pass considers, and what comes of it, N rows.

    Parameters
    ----------
    parts : iterable of (slice or (J,) int, PassInput)
        Each pixel of the frame in one of them.
    """
    each = [
        (indices(rows), *_of(indices(rows), given, settings, provenance))
        for rows, given in parts
    ]
    longest = max((origins for _, origins, _ in each), key=len)
    whole = {
        key: sum(
            scatter(rows, _padded(values[key], key, len(longest)), provenance.pixels)
            for rows, _, values in each
        )
        for key in each[0][2]
    }
    roles, frames = zip(*((o.role, o.frame) for o in longest), strict=True)
    return PassRecord(name, roles, frames, **whole)


def _padded(values: Any, key: str, slots: int) -> Any:
    if values.ndim == 1 or values.shape[1] == slots:
        return values
    missing = [(0, 0), (0, slots - values.shape[1]), *[(0, 0)] * (values.ndim - 2)]
    return np.pad(values, missing, constant_values=NONE if key == "source" else 0)


def _of(
    rows: Indices, given: Given, settings: Settings, provenance: Provenance
) -> tuple[list[Origin], dict[str, Any]]:
    sources: list[Source] = [given.own, *(q_n for q_n, _ in given.neighbors)]
    u = [given.u_own, *(u_n for _, u_n in given.neighbors)]
    origins = [provenance.own(rows)]
    origins += [provenance.neighbor(q_n) for q_n, _ in given.neighbors]
    if provenance.history is not None:
        sources.insert(0, given.past)
        u.insert(0, given.u_own)
        origins.insert(0, provenance.past(rows))
    merged = _merged(given.q, sources, u, settings)
    full = resampled(given, settings, 1.0).W > 0
    slots = [
        _slot(given.q, source, w) for source, w in zip(sources, merged.w, strict=True)
    ]
    whole = {key: np.stack([slot[key] for slot in slots], axis=1) for key in slots[0]}
    # With visibility asked of the kept sample alone, that is where it is lost.
    lost = (merged.w_sum > 0) & (merged.total > 0) & ~full
    whole["outcome"][lost, merged.kept[lost]] = Outcome.HIDDEN
    numbers = np.stack([origin.numbers for origin in origins], axis=1)
    made_by = numbers[np.arange(len(rows)), merged.kept]
    return origins, {
        **whole,
        "source": np.stack([origin.rows for origin in origins], axis=1),
        "could": merged.could,
        "kept": np.asarray(merged.kept, int),
        "w_sum": merged.w_sum,
        "total": merged.total,
        "number": np.where(full, made_by, NONE),
    }


def _slot(q: Pixels, source: Source, w: Scalars) -> dict[str, Any]:
    """Candidates of one slot, of which weights in pairs change w alone."""
    c = _candidates(q, source)
    factor, exact = jacobians(source, len(w))
    y = source.reservoirs.y if isinstance(source, NeighborPixels) else source.y
    if isinstance(source, InitialSamples):
        W = divide_or_zero(c.w, c.p_hat * c.M)
        empty: Masks = y.radiance.max(axis=1) <= 0
    else:
        W = source.reservoirs.W if isinstance(source, NeighborPixels) else source.W
        empty = W <= 0
    return {
        "M": c.M,
        "W": W,
        "p_hat": c.p_hat,
        "jacobian": np.where((factor <= 0) & (exact > 0), exact, factor),
        "w": w,
        "position": y.position,
        "outcome": outcomes(c, empty, factor, exact),
    }


def _candidates(q: Pixels, source: Source) -> Candidates:
    if isinstance(source, InitialSamples):
        p_hat = q.target(source.y)
        return initial_candidates(source.y, p_hat, source.pdf, source.M)
    return reuse.reused(q, source)


@dataclass(frozen=True, slots=True, eq=False)
class _Merged:
    """Weights in each slot, the slot that was kept, and what they were divided by."""

    w: list[Scalars]
    kept: Indices
    w_sum: Scalars
    total: Scalars
    could: Indices


def _merged(
    q: Pixels, sources: list[Source], u: list[Scalars], settings: Settings
) -> _Merged:
    """As the passes go about it, step by step."""
    mis = settings.mis
    shifts = any(isinstance(source, NeighborPixels) for source in sources)
    if shifts and mis != "1/M" and mis != "1/Z":
        return _merged_weighted(q, sources, u, mis)
    candidates = [_candidates(q, source) for source in sources]
    R = reuse.begin(candidates[0])
    for c, u_n in zip(candidates[1:], u[1:], strict=True):
        R = R.then(c, u_n)
    Q = [
        source if isinstance(source, NeighborPixels) else c
        for source, c in zip(sources, candidates, strict=True)
    ]
    total = reuse.normalization("1/Z" if mis == "1/Z" else "1/M", R, Q)
    could = np.full((len(total), len(Q)), NOT_ASKED)
    if shifts and mis == "1/Z":
        could = np.stack(reuse.could_have_made(R, Q), axis=1).astype(int)
    return _Merged([c.w for c in candidates], R.slot, R.kept.w, total, could)


def _merged_weighted(
    q: Pixels, sources: list[Source], u: list[Scalars], mis: generalized.Mis
) -> _Merged:
    stream = [
        generalized.candidate(weighed(q, source), slot, itself)
        for slot, source in enumerate(sources)
    ]
    if mis in ("pairwise", "defensive"):
        stream = generalized.weighted_in_pairs(stream, mis == "defensive", itself)
    kept = stream[0].weighted
    for c, u_n in zip(stream[1:], u[1:], strict=True):
        kept = merge(kept, c.weighted, u_n)
    y = generalized.samples_in(stream, kept.y)
    total = generalized.normalization(stream, kept, y, mis, itself)
    could = np.full((len(total), len(stream)), NOT_ASKED)
    if mis == "balance":
        full = kept.w > 0
        for c in stream:
            made = full & (kept.y == c.slot)
            p = generalized.target_at(c, y, kept.p_hat, full & ~made, itself)
            own = c.neighbor.same_domain
            could[:, c.slot] = made | (p > 0) | own
    w = [c.weighted.w for c in stream]
    return _Merged(w, kept.y, kept.w, total, could)
