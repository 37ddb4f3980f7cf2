"""What a replay calculates with: the contract, or a mistake in its place."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

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
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.sources import density, drawn_cosine


def as_it_is(M: Bounded) -> Bounded:
    """A confidence, unchanged, (N,)."""
    return M


@dataclass(frozen=True, slots=True)
class Rules:
    """What a replay calculates with: the contract, or a hypothesis about a mistake.

    Attributes
    ----------
    finalized, density, drawn_cosine, fresh_weight, shaded : callable
        Formulas, as the functions of this module.
    reuse_target, domain_target : callable
        Target of reused samples at the receiver, and of the kept sample at sources.
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
    backwards : bool; the stream is read from its end, with the same numbers
    canonical_merged : bool; the receiver's own reservoir takes part
    normalization : str; 'asked', or in place of that '1/M', '1/Z' or '1'
    refused_counts : bool; M of a reservoir whose shift has a Jacobian of 0
    rejected_counts, none_is_first : bool
        A neighbour of row −1 brings the M of row 0, or all that row 0 has.
    source_target : bool; the target of reused samples is that at the source
    target_of : 'kept' or 'first'; slot whose target W is divided by
    counted_as : 'own', 'last', 'one', 'merged' or 'rest'
        What Z adds for a reservoir: its M, that of the last one, 1, or for those of the
        receiver the sum of all.  'rest': 1/M leaves out the first in the stream.
    as_stored : bool; what moved is reused as if it had not
    divides_by_source_target : bool; W is divided by the target of who made the sample
    neighbor_trust : float; factor on M of neighbours in their weight
    shared_decision : '', 'neighbors' or 'all'
        One number decides on all neighbours, or on all reservoirs.
    ignored_words : tuple of int; words of the random key that are taken for 0
    cap_when : 'closed', 'never', 'first', 'late' or 'arrival'
        M is capped when the reservoir is closed, never, before W is calculated, after
        it with the sum of weights left as it was, or where the pixel's own reservoir
        arrives.
    depth_test : 'symmetric' or 'own'
        Relative to the larger depth, or to the pixel's own.
    turn : float; azimuth of the second number 1, in radians
    azimuth_number : int; which of the two numbers the azimuth takes
    inward : bool; directions are on the other side of the surface
    narrows : bool; the search radius is halved after a failure
    part : object
        What passes of another part of the contract calculate with; ``None`` for theirs.
    """

    target: Callable[[Value, ReceiverPoint, SamplePoint], Bounded] = target
    reuse_target: Callable[[Value, ReceiverPoint, SamplePoint], Bounded] = target
    reflected: Callable[[ReceiverPoint, SamplePoint], Bounded] = reflected
    jacobian: Callable[[ReceiverPoint, ReceiverPoint, SamplePoint], Bounded] = jacobian
    weight: Callable[[Bounded, Bounded, Bounded, Bounded], Bounded] = weight
    preference: Callable[[Bounded, Bounded, Bounded], Bounded] = preference
    fresh_confidence: Callable[[Bounded], Bounded] = fresh_confidence
    capped: Callable[[Bounded, float], Bounded] = capped
    finalized: Callable[[Bounded, Bounded, Bounded], Bounded] = finalized
    density: Callable[[Value, Bounded], Bounded] = density
    domain_target: Callable[[Value, ReceiverPoint, SamplePoint], Bounded] = target
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
    source_target: bool = False
    target_of: str = "kept"
    visibility_in_weight: bool = True
    visibility_in_z: bool = True
    canonical_in_z: bool = True
    maker_in_z: bool = True
    receivers_domain: bool = False
    backwards: bool = False
    canonical_merged: bool = True
    counted_as: str = "own"
    as_stored: bool = False
    normalization: str = "asked"
    divides_by_source_target: bool = False
    neighbor_trust: float = 1.0
    shared_decision: str = ""
    ignored_words: tuple[int, ...] = ()
    cap_when: str = "closed"
    depth_test: str = "symmetric"
    turn: float = 2 * pi
    azimuth_number: int = 1
    inward: bool = False
    narrows: bool = True
    part: Any = None


CONTRACT_RULES = Rules()
