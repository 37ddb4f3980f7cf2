"""Generalized resampling: any samples, of any domains, that shifts map to each other.

[Lin22] resamples candidates that come from other domains than the receiver's.  A
candidate k brings a sample x_k with its W_k and confidence M_k, and a shift T_k into
the receiver's domain.  It competes with the resampling weight

    w_k = m_k(y) p̂(y) W_k |∂T_k / ∂x_k|,    y = T_k(x_k),

and the one that is kept gets W = Σ w_k / p̂(y).  The MIS weights m_k sum to 1 over those
whose domain holds y; that alone makes the estimate unbiased [Lin22, Eqs. 9 and 10].

Nothing here knows what a sample is: every method brings a class of neighbours, which
evaluates the value f / p and the Jacobian of its shift and of the inverse.  Runs on any
number type, so that `tests/exact` enumerates it in fractions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, divide_or_zero
from restir_gi.reference.numerics.records import (
    NONE,
    concatenate,
    pick,
    scatter,
    take,
)
from restir_gi.reference.resampling.pairwise import (
    pairwise_canonical,
    pairwise_neighbor,
)
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    balance_heuristic,
    cap_confidence,
    finalize,
    merge,
    one_over_m,
    one_over_z,
    reused_candidates,
)
from restir_gi.reference.resampling.target import luminance

Mis = Literal["1/M", "1/Z", "balance", "pairwise", "defensive"]

# p̂ of values; their luminance, as a rule.
Target = Callable[[Any], Scalars]

# Value of a shifted sample, and Jacobian of the shift; 0 where there is none.
Shifted = tuple[Any, Scalars]


class SourceReservoirs(Protocol):
    """Reservoirs of other domains, of which K receivers are offered one each."""

    @property
    def reservoirs(self) -> Reservoirs:
        """N rows; samples have a ``value`` f / p and a method ``moved``."""

    @property
    def rows(self) -> Indices:
        """(K,) int: row that is offered to each receiver, or ``NONE``."""

    @property
    def same_domain(self) -> bool:
        """Whether the receivers' domain is the reservoirs' own: nothing is shifted."""

    def unshifted(self, at: Indices) -> Any:
        """Value of the samples offered to the receivers ``at``, where they come from.

        Asked of few rows: a target that is costly is evaluated here.
        """

    def shifted(self, at: Indices) -> Shifted:
        """Value and Jacobian of the samples offered to the receivers ``at``."""

    def inverse(self, samples: Any, at: Indices) -> Shifted:
        """The same of the receivers' samples ``at``, back in the other domains."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One slot of the stream of K receivers.

    Attributes
    ----------
    weighted : Candidates; K rows, of which y is the slot
    value : record or (K, 3); of the samples at the receivers
    jacobian : (K,); of their shifts
    """

    neighbor: SourceReservoirs
    slot: int
    weighted: Candidates
    value: Any
    jacobian: Scalars


def resample(
    neighbors: Sequence[SourceReservoirs],
    u: list[Scalars],
    mis: Mis,
    cap: float,
    target: Target = luminance,
) -> Reservoirs:
    """Resample what the neighbours of each receiver offer.

    [Lin22, Eqs. 22 and 36 to 38].  Any dtype.

    Parameters
    ----------
    neighbors : list of SourceReservoirs
        In the order of the stream.  The last one of the receivers' own domain is the
        canonical one; without one the domain is not covered.
    u : list of (K,)
        One uniform number in [0, 1) for each; that of the first decides nothing.
    mis : '1/M', '1/Z', 'balance', 'pairwise' or 'defensive'
        MIS weights.  1/M is biased: it counts those who could not have made the sample.
    cap : float; limit of M

    Returns
    -------
    Reservoirs; K rows; samples as they are at the receivers
    """
    stream = [candidate(q_n, slot, target) for slot, q_n in enumerate(neighbors)]
    if mis in ("pairwise", "defensive"):
        stream = weighted_in_pairs(stream, mis == "defensive", target)
    kept = stream[0].weighted
    for c, u_n in zip(stream[1:], u[1:], strict=True):
        kept = merge(kept, c.weighted, u_n)
    y = samples_in(stream, kept.y)
    total = normalization(stream, kept, y, mis, target)
    return cap_confidence(finalize(replace(kept, y=y), total), cap)


def candidate(neighbor: SourceReservoirs, slot: int, target: Target) -> Candidate:
    """Shift what a neighbour offers: w = p̂(T(x)) W M |∂T/∂x|, still without m.

    Where nothing could be shifted w is 0, and M counts all the same.
    """
    r, row = neighbor.reservoirs, np.maximum(neighbor.rows, 0)
    none, size = neighbor.rows == NONE, len(row)
    W, M = (np.where(none, a * 0, a) for a in (r.W[row], r.M[row]))
    if neighbor.same_domain:
        value, jacobian = take(r.y.value, row), np.ones_like(W)
    else:
        at = np.flatnonzero(W > 0)
        some, factor = neighbor.shifted(at)
        value, jacobian = scatter(at, some, size), scatter(at, factor, size)
    here = Reservoirs(np.full(size, slot, np.int8), W, M)
    weighted = reused_candidates(here, target(value), jacobian)
    return Candidate(neighbor, slot, weighted, value, jacobian)


def normalization(
    stream: list[Candidate], kept: Candidates, y: Any, mis: Mis, target: Target
) -> Scalars:
    """What the sum of weights is divided by, so that the MIS weights sum to 1.

    Parameters
    ----------
    kept : Candidates; K rows, of which y is the slot that was kept
    mis : '1/M', '1/Z', 'balance', 'pairwise' or 'defensive'
        MIS weights; those in pairs were divided before: 1.

    Returns
    -------
    (K,); meaningless where nothing was kept
    """
    M_k = [c.weighted.M for c in stream]
    if mis == "1/M":
        return one_over_m(M_k)
    if mis in ("pairwise", "defensive"):
        return np.ones_like(kept.w)
    full = kept.w > 0
    p_k, in_domain, p_made = [], [], kept.p_hat
    for c in stream:
        made = full & (kept.y == c.slot)  # whoever made the sample knows it
        p = target_at(c, y, kept.p_hat, full & ~made, target)
        if mis == "balance":
            own = target_where_made(c, made, target)
            p, p_made = np.where(made, own, p), np.where(made, own, p_made)
        p_k.append(p)
        in_domain.append(made | (p > 0))
    if mis == "1/Z":
        return one_over_z(M_k, in_domain)
    return balance_heuristic(M_k, p_k, p_made)


def weighted_in_pairs(
    stream: list[Candidate], defensive: bool, target: Target
) -> list[Candidate]:
    """Candidates weighted with the pairwise MIS weight m in place of M.

    [Lin22, Eqs. 37 and 38].  For a neighbour's sample two targets are asked, both of
    which are known; for the canonical sample those of all: one inverse shift each.

    Parameters
    ----------
    stream : list of Candidate
        Weighted with M; the last of the receivers' own domain is the canonical one.
    defensive : bool; the canonical sample has a share of its own

    Returns
    -------
    list of Candidate; in the same order; the sum of their w needs no division

    Raises
    ------
    ValueError
        There is no canonical candidate: nobody covers the domain.
    """
    own = [c for c in stream if c.neighbor.same_domain]
    if not own:
        raise ValueError("pairwise weights need a candidate of the receiver's domain")
    canonical = own[-1]
    c = canonical.weighted
    others = [k for k in stream if k is not canonical]
    M_k = [k.weighted.M for k in others]
    y = samples_in(stream, np.full(len(c.M), canonical.slot))
    p_k = [target_at(k, y, c.p_hat, c.w > 0, target) for k in others]
    m = pairwise_canonical(M_k, p_k, c.M, c.p_hat, defensive)
    weighted = [_with_weight(canonical, m)]
    if others:
        S = one_over_m(M_k)
        for k, M in zip(others, M_k, strict=True):
            made = target_where_made(k, k.weighted.w > 0, target)
            m = pairwise_neighbor(M, made, c.M, k.weighted.p_hat, S, defensive)
            weighted.append(_with_weight(k, m))
    return sorted(weighted, key=lambda k: k.slot)


def _with_weight(candidate: Candidate, m: Scalars) -> Candidate:
    c = candidate.weighted
    return replace(candidate, weighted=replace(c, w=divide_or_zero(c.w, c.M) * m))


def target_where_made(candidate: Candidate, asked: Masks, target: Target) -> Scalars:
    """Target of a neighbour's own samples in its domain, in the receivers' measure.

    Parameters
    ----------
    asked : (K,) bool; which; 0 elsewhere

    Returns
    -------
    (K,); p̂(x) / |∂T/∂x|; 0 where there is no shift to the receiver
    """
    at = np.flatnonzero(asked & (candidate.jacobian > 0))
    made = candidate.neighbor.unshifted(at)
    return scatter(at, target(made) / candidate.jacobian[at], len(asked))


def target_at(
    candidate: Candidate, y: Any, p_hat: Scalars, asked: Masks, target: Target
) -> Scalars:
    """Target of the receivers' samples in a neighbour's domain, in their own measure.

    Parameters
    ----------
    y : record; K samples at the receivers
    p_hat : (K,); their target there
    asked : (K,) bool; which; 0 elsewhere

    Returns
    -------
    (K,); p̂(T⁻¹(y)) |∂T⁻¹/∂y|; 0 outside of the neighbour's domain
    """
    if candidate.neighbor.same_domain:
        return np.where(asked, p_hat, p_hat * 0)
    at = np.flatnonzero(asked & (candidate.weighted.M > 0))
    value, jacobian = candidate.neighbor.inverse(y, at)
    return scatter(at, target(value) * jacobian, len(p_hat))


def samples_in(stream: list[Candidate], slot: Indices) -> Any:
    """Samples in given slots, as they are at the receivers.

    Parameters
    ----------
    slot : (K,) int; whose sample is wanted
    """
    value = pick(slot, [c.value for c in stream])
    jacobian = pick(slot, [c.jacobian for c in stream])
    return _as_stored(stream, slot).moved(value, jacobian)


def _as_stored(stream: list[Candidate], slot: Indices) -> Any:
    """Samples in given slots: one gather for each frame, however many point into it."""
    stored = [c.neighbor.reservoirs for c in stream]
    frames = {id(reservoirs): reservoirs.y for reservoirs in stored}
    row = pick(slot, [np.maximum(c.neighbor.rows, 0) for c in stream])
    frame = np.array([[*frames].index(id(reservoirs)) for reservoirs in stored])[slot]
    at = [np.flatnonzero(frame == k) for k in range(len(frames))]
    parts = [take(y, row[k]) for y, k in zip(frames.values(), at, strict=True)]
    return take(concatenate(parts), np.argsort(np.concatenate(at)))
