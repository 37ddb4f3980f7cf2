"""What temporal and spatial resampling share: a reservoir of q_n is offered to q.

Written once, on whatever numbers the arrays hold: the renderer runs it on float64, and
`tests/exact` enumerates the same functions in fractions.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.numerics.records import pick
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    Samples,
    merge,
    one_over_m,
    one_over_z,
    reused_candidates,
)

PaperMis = Literal["1/M", "1/Z"]
"""Weights of the paper: biased and unbiased."""


class Receiver(Protocol):
    """Pixels q that resample, K rows."""

    def target(self, y: Samples) -> Scalars:
        """Target p̂_q(y), without visibility."""

    def sees(self, y: Samples, asked: Masks) -> Masks:
        """Whether x_v at q sees y: a ray each; false where not asked."""


class Neighbor(Protocol):
    """Pixels q_n, one for each q: nearby, or of the last frame."""

    @property
    def reservoirs(self) -> Reservoirs:
        """R_n, K rows; M = 0 where there is no such pixel."""

    def jacobian(self) -> Scalars:
        """|∂ω_q / ∂ω_n| of their samples, Equation 11; 0 where they are not shifted."""

    def could_make(self, y: Samples, asked: Masks) -> Masks:
        """Whether y, at q, lies in the domain of q_n; false where not asked."""


@dataclass(frozen=True, eq=False)
class CandidateStream:
    """Candidates merged so far, K rows: Algorithm 1.

    Attributes
    ----------
    merged : Candidates; the reservoir; ``y`` is the slot of the candidate that is kept
    candidates : tuple of Candidates; in the order in which they came
    """

    merged: Candidates
    candidates: tuple[Candidates, ...]

    def then(self, c: Candidates, u: Scalars) -> "CandidateStream":
        """Merge one more candidate; u, (K,) in [0, 1), decides whether it is kept."""
        slot = np.full(len(c.M), len(self.candidates), np.int8)
        merged = merge(self.merged, replace(c, y=slot), u)
        return CandidateStream(merged, (*self.candidates, c))

    @property
    def slot(self) -> Indices:
        """(K,) int: which candidate is kept."""
        slot: Indices = self.merged.y
        return slot

    @property
    def M(self) -> list[Scalars]:
        """Confidence of each candidate, (K,) each."""
        return [c.M for c in self.candidates]

    @cached_property
    def kept(self) -> Candidates:
        """The reservoir with its sample: one gather, however many came."""
        y = pick(self.slot, [c.y for c in self.candidates])
        return replace(self.merged, y=y)


def begin(c: Candidates) -> CandidateStream:
    """A stream of one candidate."""
    return CandidateStream(replace(c, y=np.zeros(len(c.M), np.int8)), (c,))


def reused(q: Receiver, source: Reservoirs | Neighbor) -> Candidates:
    """Offer reservoirs to q.

    Parameters
    ----------
    source : Reservoirs or Neighbor
        Their own reservoirs, K rows, whose samples need no shift; or a neighbour's.

    Returns
    -------
    Candidates; w = p̂_q(y) W M, times the Jacobian where the sample is shifted
    """
    if isinstance(source, Reservoirs):
        return reused_candidates(source, q.target(source.y))
    return shifted(q, source)


def shifted(q: Receiver, q_n: Neighbor) -> Candidates:
    """Offer the reservoirs of a neighbour to q [Ouyang21, Alg. 4, lines 9 to 13].

    Returns
    -------
    Candidates; w = p̂_q(y) W M J, and 0 where q does not see y; M counts all the same
    """
    R_n = q_n.reservoirs  # line 9
    J = q_n.jacobian()  # line 10, Eq. 11
    # Line 11 prints a division by |J|.  It belongs to a density: a weight, which is its
    # inverse, is multiplied.
    c = reused_candidates(R_n, q.target(R_n.y), J)
    seen = q.sees(R_n.y, c.w > 0)  # lines 12 and 13
    return replace(c, w=np.where(seen, c.w, c.w * 0))


def normalization(
    mis: PaperMis, R: CandidateStream, Q: Sequence[Candidates | Reservoirs | Neighbor]
) -> Scalars:
    """What the sum of weights is divided by: M, or Z.

    [Ouyang21, Alg. 4, lines 16 to 19].  Line 18 asks for p̂_n > 0; visibility belongs to
    the question, or Z counts pixels that do not see the sample.

    Parameters
    ----------
    mis : '1/M' or '1/Z'; biased, as Algorithm 3 has it, or unbiased
    Q : sequence of Candidates, Reservoirs or Neighbor
        Where each candidate came from.  All but neighbours' come from q's own domain,
        which holds every sample that q keeps.

    Returns
    -------
    (K,)
        Σ M over those of Q that could have made the kept sample, or over all.
        Meaningless where nothing was kept.
    """
    if mis == "1/M":
        return one_over_m(R.M)
    return one_over_z(R.M, could_have_made(R, Q))  # lines 16 and 19


def could_have_made(
    R: CandidateStream, Q: Sequence[Candidates | Reservoirs | Neighbor]
) -> list[Masks]:
    """Whether each of Q could have made the kept sample, (K,) bool each.

    [Ouyang21, Alg. 4, lines 17 and 18]; where nothing was kept, nobody but q is asked.
    """
    full = R.kept.w > 0
    could = [np.ones(len(full), bool)] * len(Q)
    for slot, q_n in enumerate(Q):  # line 17
        if not isinstance(q_n, Candidates | Reservoirs):
            made = R.slot == slot  # whoever made the sample could: no ray
            could[slot] = made | q_n.could_make(R.kept.y, full & ~made)  # line 18
    return could
