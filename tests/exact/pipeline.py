"""The passes on the toy domain: production kernels, strung together as Algorithms 2-4.

Geometry, targets and visibility are look-ups in tables of fractions; all arithmetic of
resampling is done by the kernels handed in as ``code``.  Mutants are made of this file
too (:mod:`tests.exact.mutants`), so that mistakes of *placement* are planted as well as
mistakes of formulas.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from reference.arrays import divide_or_zero
from tests.exact.domain import (
    CELL,
    EYE,
    HOLDS,
    MU,
    NORMAL,
    NOTHING,
    SEES,
    SOURCE,
    TARGET,
)
from tests.exact.explore import draw


@dataclass(frozen=True, slots=True)
class Kept:
    """A sample and the slot of the stream that put it in."""

    cell: Any
    slot: Any


def _with_nothing(table, nothing):
    return [np.array([*row, nothing], object) for row in table]


P_HAT = _with_nothing(TARGET, Fraction(0))
PDF = _with_nothing(np.array(SOURCE) / MU, Fraction(0))
SEEN = [row.astype(bool) for row in _with_nothing(SEES, False)]
HELD = [row.astype(bool) for row in _with_nothing(HOLDS, False)]


def jacobian(code, i_from, i_to, x):
    """|∂ω_to / ∂ω_from| of cells, by the production kernel, run once on each cell."""
    x_from, x_to = (np.broadcast_to(EYE[i], CELL.shape) for i in (i_from, i_to))
    ratio = code.shift.reconnection_jacobian(x_from, x_to, CELL, NORMAL)
    ratio[NOTHING] = Fraction(1)
    return ratio[x]


def initial(code, i, uniform):
    """Algorithm 2: one new candidate at pixel i."""
    x = draw(uniform(), SOURCE[i])
    return code.reservoir.initial_candidates(x, P_HAT[i][x], PDF[i][x])


def temporal(code, i, history, new, cap, uniform):
    """Algorithm 3: a new candidate meets the reservoir of the last frame."""
    k = code.reservoir
    if history is None:
        return k.cap_confidence(k.finalize(new, new.M), cap)
    old = k.reused_candidates(history, P_HAT[i][history.y])
    both = k.merge(old, new, uniform())
    total = code.mis.one_over_m([old.M, new.M])
    return k.cap_confidence(k.finalize(both, total), cap)


def spatial(
    code, i, donors, uniform, mis="1/Z", visibility="all", limit=float("inf"), cap=9999
):
    """Algorithm 4 at pixel i.

    Donors are pairs (pixel, Reservoirs), the pixel's own first.  A shift whose
    Jacobian is above the limit is rejected: that looks at the sample, so it is
    mirrored in the weights.
    """
    k = code.reservoir
    candidates, sources, M = [], [], []
    for slot, (j, r) in enumerate(donors):
        y = Kept(r.y, np.full(len(r.y), slot))
        p_hat = P_HAT[i][r.y]
        ratio = jacobian(code, j, i, r.y) if j != i else None
        c = k.reused_candidates(k.Reservoirs(y, r.W, r.M), p_hat, ratio)
        if j != i:
            usable = ratio <= limit
            if visibility == "all":
                usable = usable & SEEN[i][r.y]
            c = k.Candidates(y, c.p_hat, np.where(usable, c.w, Fraction(0)), r.M)
        candidates.append(c)
        sources, M = [*sources, j], [*M, r.M]
    if mis in ("pairwise", "defensive"):
        defensive = mis == "defensive"
        candidates = in_pairs(code, i, candidates, sources, M, defensive, limit)
    chosen = candidates[0]
    for c in candidates[1:]:
        chosen = k.merge(chosen, c, uniform())
    z = chosen.y.cell
    total = normalization(code, i, sources, M, z, chosen.y.slot, mis, limit)
    c = k.Candidates(z, chosen.p_hat, chosen.w, chosen.M)
    kept = k.finalize(c, total)
    if visibility == "chosen":
        kept = k.Reservoirs(z, np.where(SEEN[i][z], kept.W, Fraction(0)), kept.M)
    return k.cap_confidence(kept, cap)


def normalization(code, i, sources, M, z, slot, mis, limit):
    """Lines 16 to 20 of Algorithm 4: who else could have made z."""
    if mis == "1/M":
        return code.mis.one_over_m(M)
    if mis in ("pairwise", "defensive"):
        return np.full(len(z), Fraction(1))
    held, p = zip(*(target_from(code, i, j, z, limit) for j in sources), strict=True)
    if mis == "1/Z":
        return code.mis.one_over_z(M, list(held))
    made = np.stack(p)[slot, np.arange(len(z))]
    return code.mis.balance_heuristic(M, list(p), made)


def target_from(code, i, j, z, limit):
    """Whether j could have made z, and its target in the measure of i."""
    if j == i:
        return np.ones(len(z), bool), P_HAT[i][z]
    held = HELD[j][z] & (jacobian(code, j, i, z) <= limit)
    p = np.where(held, P_HAT[j][z] * jacobian(code, i, j, z), Fraction(0))
    return held, p


def in_pairs(code, i, candidates, sources, M, defensive, limit):
    """Candidates weighted with m in place of M; the first is the canonical one."""
    own, (M_c, *M_k) = candidates[0], M
    S = sum(M_k) + M_c * 0

    def p_from(j, z):
        return target_from(code, i, j, z, limit)[1]

    def weighted(c, M, m):
        return code.reservoir.Candidates(c.y, c.p_hat, divide_or_zero(c.w, M) * m, c.M)

    p_k = [p_from(j, own.y.cell) for j in sources[1:]]
    m = code.pairwise.pairwise_canonical(M_k, p_k, M_c, P_HAT[i][own.y.cell], defensive)
    found = [weighted(own, M_c, m)]
    for c, j, M_j in zip(candidates[1:], sources[1:], M_k, strict=True):
        y = c.y.cell
        mine = M_j, p_from(j, y), M_c, P_HAT[i][y]
        m = code.pairwise.pairwise_donor(*mine, S, defensive)
        found.append(weighted(c, M_j, m))
    return found


def trust(r, M):
    """The same reservoirs with another confidence, of which nothing is claimed."""
    return type(r)(r.y, r.W, np.full(len(r.y), Fraction(M)))
