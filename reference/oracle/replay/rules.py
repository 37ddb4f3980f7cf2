"""What a replay calculates with: the contract, or a mistake in its place."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi
from typing import Any

import numpy as np

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.formulas import (
    capped,
    finalized,
    fresh_confidence,
    fresh_weight,
    jacobian,
    merged,
    preference,
    reflected,
    shaded,
    target,
    weight,
)
from restir_gi.reference.oracle.replay.limits import at_least, clamped, within
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.sources import density, drawn_cosine
from restir_gi.reference.oracle.replay.verbs import where_positive

TargetFormula = Callable[[Value, ReceiverPoint, SamplePoint], Bounded]
JacobianFormula = Callable[[ReceiverPoint, ReceiverPoint, SamplePoint], Bounded]


def as_it_is(M: Bounded) -> Bounded:
    """A confidence, unchanged, (N,)."""
    return M


@dataclass(frozen=True, slots=True)
class Rules:
    """What a replay calculates with: the contract, or other choices than its own.

    Each field is a choice by itself: several may differ at once.

    Attributes
    ----------
    target : callable; of new samples, and of all where the next two are ``None``
    finalized, density, drawn_cosine, fresh_weight, shaded : callable
        Formulas, as the functions of this module.
    reuse_target, domain_target : callable or None
        Target of reused samples at the receiver, and of samples at their sources.
    W_most, divisor_least : float; W is cut there; the target that divides is raised
    null_weight : '0' or '1/pdf'; W of a new sample whose target is 0
    storage : str; how reservoirs are stored between passes, by its name in `STORAGES`
    refused : float, float; w = 0 where J is not between these two
    refused_both_ways : bool; what is refused is not in the domain of the source, too
    clamped : float, float; J between them, after that
    merged_weight, merged_confidence : callable
        What a merge leaves of two weights, and of two confidences.
    reused_confidence : callable; M of a reservoir that arrives
    hidden_counts : 'all', 'nulls' or 'none'
        Which samples that the receiver does not see have their M counted: those with no
        light alone are nulls.
    nulls_count : bool; M of a reused reservoir whose sample arrives with no weight
    visibility_in_weight, visibility_in_z : bool; whether the bits are heeded
    canonical_in_z, maker_in_z : bool
        The receiver's own reservoir, and that of who made the kept sample.
    receivers_domain : bool
        The domain test is that of the receiver in place of the source.
    views : 'own', 'receiver' or 'source'
        Whose view a declared surface has: its own; or sources are asked with that of
        the receiver; or the receiver has that of the source of a reused sample.
    order : str; of the stream, by its name in `ORDERS`
    canonical_merged, past_merged : bool
        The receiver's own reservoir takes part, and that of its past.
    normalization : str
        'asked', or in place of that '1/M', '1/Z', '1', 'pairwise' or another of the
        weights in `mis`; 'own': others, of which nothing is known but their mean.
    balance_as, pairwise_as, defensive_as : str
        What is done where these are asked for, by its name in `mis`.
    refused_counts : bool; M of a reservoir whose shift has a Jacobian of 0
    rejected_counts, none_is_first : bool
        A neighbour of row −1 brings the M of row 0, or all that row 0 has.
    sources_now : bool
        Sources of the past frame are taken for the visible points of this one.
    source_target : bool; the target of reused samples is that at the source
    target_of : 'kept' or 'first'; slot whose target W is divided by
    counted_as : 'own', 'last', 'one', 'full', 'merged' or 'rest'
        What Z adds for a reservoir: its M, that of the last one, 1, 1 if M > 0, or for
        those of the receiver the sum of all.  'rest': 1/M leaves out the first in the
        stream.
    mis_jacobian : bool
        MIS weights compare densities in one measure, not each in its own.
    as_stored : bool; what moved is reused as if it had not
    divides_by_source_target : bool; W is divided by the target of who made the sample
    neighbor_trust : float; factor on M of neighbours in their weight
    shared_decision : '', 'neighbors' or 'all'
        One number decides on all neighbours, or on all reservoirs.
    ignored_words : tuple of int; words of the random key that are taken for 0
    cap_when : str
        'closed': M is capped when the reservoir is; 'never'; 'first': before W is
        calculated; 'late': after it, with the sum of weights left as it was.
    cap_arriving : '', 'past', 'own' or 'all'
        Which reservoirs have their M capped as they arrive: none, the pixel's past,
        both of its own, or those of neighbours too.
    whole_confidence : bool; M is cut to a whole number when the reservoir is closed
    most_confidence : float; that the type of M can hold
    max_age : tuple of two floats
        Frames that the sample of a past may have survived, where its age is told.  With
        as many as the second it is not reused; from the first on it may be reused or
        not, as where the limit is drawn at random, and M says which.
    depth_test : 'symmetric' or 'own'
        Relative to the larger depth, or to the pixel's own.
    turn : float; azimuth of the second number 1, in radians
    azimuth_number : int; which of the two numbers the azimuth takes
    inward : bool; directions are on the other side of the surface
    narrows : bool; the search radius is halved after a failure
    table : 'asked', 'exchanged', 'opposite' or 'upwards'
        How offsets of a table are read: columns and rows exchanged, or with other
        signs, both or that of rows.
    border : 'asked', or a name of `BORDERS` in the replay of the search
        What becomes of places outside where they are not refused.
    shading_sees : 'asked', 'never' or 'turned'
        Whether shading heeds the bit that says what the visible point sees, where it is
        given, or takes 0 for yes.
    part : object
        What passes of another part of the contract calculate with; ``None`` for theirs.
    """

    target: TargetFormula = target
    reuse_target: TargetFormula | None = None
    reflected: Callable[[ReceiverPoint, SamplePoint], Bounded] = reflected
    jacobian: JacobianFormula = jacobian
    weight: Callable[[Bounded, Bounded, Bounded, Bounded], Bounded] = weight
    preference: Callable[[Bounded, Bounded, Bounded], Bounded] = preference
    fresh_confidence: Callable[[Bounded], Bounded] = fresh_confidence
    capped: Callable[[Bounded, float], Bounded] = capped
    finalized: Callable[[Bounded, Bounded, Bounded], Bounded] = finalized
    density: Callable[[Value, Bounded], Bounded] = density
    domain_target: TargetFormula | None = None
    drawn_cosine: Callable[[Value, Bounded], Bounded] = drawn_cosine
    fresh_weight: Callable[[Bounded, Bounded], Bounded] = fresh_weight
    shaded: Callable[[Bounded, Bounded], Bounded] = shaded
    merged_weight: Callable[[Bounded, Bounded], Bounded] = merged
    merged_confidence: Callable[[Bounded, Bounded], Bounded] = merged
    reused_confidence: Callable[[Bounded], Bounded] = as_it_is
    hidden_counts: str = "all"
    nulls_count: bool = True
    refused_counts: bool = True
    rejected_counts: bool = False
    none_is_first: bool = False
    sources_now: bool = False
    source_target: bool = False
    target_of: str = "kept"
    visibility_in_weight: bool = True
    visibility_in_z: bool = True
    canonical_in_z: bool = True
    maker_in_z: bool = True
    receivers_domain: bool = False
    views: str = "own"
    order: str = "contract"
    canonical_merged: bool = True
    past_merged: bool = True
    counted_as: str = "own"
    as_stored: bool = False
    normalization: str = "asked"
    balance_as: str = "balance"
    pairwise_as: str = "pairwise"
    defensive_as: str = "defensive"
    mis_jacobian: bool = True
    divides_by_source_target: bool = False
    neighbor_trust: float = 1.0
    shared_decision: str = ""
    ignored_words: tuple[int, ...] = ()
    cap_when: str = "closed"
    cap_arriving: str = ""
    whole_confidence: bool = False
    most_confidence: float = inf
    W_most: float = inf
    divisor_least: float = 0.0
    null_weight: str = "0"
    storage: str = "exact"
    refused: tuple[float, float] = (0.0, inf)
    refused_both_ways: bool = False
    clamped: tuple[float, float] = (0.0, inf)
    max_age: tuple[float, float] = (inf, inf)
    depth_test: str = "symmetric"
    turn: float = 2 * pi
    azimuth_number: int = 1
    inward: bool = False
    narrows: bool = True
    table: str = "asked"
    border: str = "asked"
    shading_sees: str = "asked"
    part: Any = None

    @property
    def target_of_reused(self) -> TargetFormula:
        """Target of reused samples at the receiver."""
        return self.reuse_target or self.target

    @property
    def target_at_source(self) -> TargetFormula:
        """Target of samples at the points that could have made them."""
        return self.domain_target or self.target

    def shift_jacobian(
        self, x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
    ) -> Bounded:
        """J as it weighs: 0 where it is refused, and clamped after that, (N,)."""
        return self.limited(self.jacobian(x_from, x_to, y))

    def limited(self, J: Bounded) -> Bounded:
        """J, 0 where it is refused, and clamped where it is not, (N,)."""
        weighs = J
        if self.clamped != (0.0, inf):
            weighs = clamped(J, *self.clamped)
            # Where the shift has no inverse it may be refused ahead of the limit.
            error = np.where(J.value == 0, weighs.value, weighs.error)
            weighs = Bounded(weighs.value, error, J.rounding)
        if self.refused == (0.0, inf):
            return weighs
        return where_positive(within(J, *self.refused), weighs)

    def closed(self, w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
        """W = w / (Z p̂), with floor and cut, (N,)."""
        if self.divisor_least:
            p_hat = at_least(p_hat, self.divisor_least)
        W = self.finalized(w, p_hat, Z)
        return W if self.W_most == inf else clamped(W, 0.0, self.W_most)

    def stored_confidence(self, M: Bounded) -> Bounded:
        """M as its type holds it, (N,)."""
        if self.whole_confidence:
            M = Bounded(np.floor(M.value), M.error, M.rounding)
        most = self.most_confidence
        return M if most == inf else capped(M, most)


CONTRACT_RULES = Rules()
