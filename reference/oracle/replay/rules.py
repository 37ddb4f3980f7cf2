"""What a replay calculates with: the contract, or a mistake in its place."""

from collections.abc import Callable
from dataclasses import dataclass

from reference.oracle.contract.fields import Value
from reference.oracle.replay.bounded import Bounded
from reference.oracle.replay.formulas import (
    capped,
    density,
    finalized,
    fresh_confidence,
    jacobian,
    preference,
    reflected,
    target,
    weight,
)
from reference.oracle.replay.points import Point, Receiver


@dataclass(frozen=True, slots=True)
class Rules:
    """What a replay calculates with: the contract, or a hypothesis about a mistake.

    Attributes
    ----------
    target, reflected, jacobian, weight, preference, fresh_confidence, capped, \
finalized, density : callable
        Formulas, as the functions of this module.
    reuse_target : callable
        Target of reused samples at the receiver.
    hidden_counts : bool
        M of a sample that the receiver does not see.
    nulls_count : bool
        M of a reused reservoir whose sample arrives with no weight.
    visibility_in_weight, visibility_in_z : bool
        Whether the bits are heeded.
    canonical_in_z : bool
        The receiver's own reservoir.
    normalization : 'asked', '1/M', '1/Z' or '1'
        In place of what was asked for.
    divides_by_donor : bool
        W is divided by the target of who made the sample.
    neighbor_trust : float
        Factor on M of neighbours in their weight.
    shared_decision : bool
        One number decides on all neighbours.
    cap_when : 'closed', 'never' or 'first'
        M is capped when the reservoir is closed, never, or before W is calculated.
    depth_test : 'symmetric' or 'own'
        Relative to the larger depth, or to the pixel's own.
    narrows : bool
        The search radius is halved after a failure.
    """

    target: Callable[[Value, Receiver, Point], Bounded] = target
    reuse_target: Callable[[Value, Receiver, Point], Bounded] = target
    reflected: Callable[[Receiver, Point], Bounded] = reflected
    jacobian: Callable[[Receiver, Receiver, Point], Bounded] = jacobian
    weight: Callable[[Bounded, Bounded, Bounded, Bounded], Bounded] = weight
    preference: Callable[[Bounded, Bounded, Bounded], Bounded] = preference
    fresh_confidence: Callable[[Bounded], Bounded] = fresh_confidence
    capped: Callable[[Bounded, float], Bounded] = capped
    finalized: Callable[[Bounded, Bounded, Bounded], Bounded] = finalized
    density: Callable[[Value, Bounded], Bounded] = density
    hidden_counts: bool = True
    nulls_count: bool = True
    visibility_in_weight: bool = True
    visibility_in_z: bool = True
    canonical_in_z: bool = True
    normalization: str = "asked"
    divides_by_donor: bool = False
    neighbor_trust: float = 1.0
    shared_decision: bool = False
    cap_when: str = "closed"
    depth_test: str = "symmetric"
    narrows: bool = True


CONTRACT_RULES = Rules()
