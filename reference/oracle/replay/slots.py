"""Competitors in a stream, as a replay sees them."""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import choose


@dataclass(frozen=True, slots=True, eq=False)
class Domain:
    """Where a slot's sample was made, and what else could be made there.

    Attributes
    ----------
    x : ReceiverPoint; visible points of the sources
    sees : (S, N) bool; whether they see the sample of each slot
    """

    x: ReceiverPoint
    sees: Masks


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """One competitor in each row's stream.

    Attributes
    ----------
    p_hat, w, M : Bounded; (N,): target at the receiver, weight and confidence
    u : Bounded; (N,), decides on it
    domain : Domain or None; ``None`` for what stands at the receiver itself
    """

    y: SamplePoint
    p_hat: Bounded
    w: Bounded
    M: Bounded
    u: Bounded
    domain: Domain | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Closing:
    """How a stream ends.

    Attributes
    ----------
    mis : '1/M' or '1/Z'; what the sum of weights is divided by
    cap : float; limit of M
    canonical : int; slot of the receiver's own sample
    """

    kind: str
    mis: str
    cap: float
    canonical: int
    receiver: ReceiverPoint


def nothing(like: Bounded) -> Bounded:
    """Zeros, without error.

    Parameters
    ----------
    like : Bounded; gives shape and rounding
    """
    none = np.zeros_like(like.value)
    return Bounded(none, none, like.rounding)


def backwards(slots: list[Slot], closing: Closing) -> tuple[list[Slot], Closing]:
    """The stream from its end; each place keeps its random number.

    Whoever is asked about the samples is asked in the new order.

    Parameters
    ----------
    slots : list of Slot; in the order of the contract
    """
    found = [replace(b, u=a.u) for a, b in zip(slots, slots[::-1], strict=True)]
    turned = [
        replace(slot, domain=replace(slot.domain, sees=slot.domain.sees[::-1]))
        if slot.domain
        else slot
        for slot in found
    ]
    return turned, replace(closing, canonical=len(slots) - 1 - closing.canonical)


def with_hidden(slot: Slot, seen: Masks, rules: Rules) -> Slot:
    """A slot whose sample the receiver may not see.

    Parameters
    ----------
    slot : Slot; as if it were seen
    seen : (N,) bool; whether it is

    Returns
    -------
    Slot; the weight is 0 where it is hidden; M counts
    """
    none = nothing(slot.w)
    w = choose(seen, slot.w, none) if rules.visibility_in_weight else slot.w
    counts = {
        "all": np.ones_like(seen),
        "nulls": seen | (slot.w.value <= 0),
        "none": seen,
    }
    M = choose(counts[rules.hidden_counts], slot.M, none)
    return replace(slot, w=w, M=M)


def counted_nulls(slot: Slot, rules: Rules) -> Slot:
    """A slot whose null may not count."""
    if rules.nulls_count:
        return slot
    found: Scalars = slot.w.value > 0
    return replace(slot, M=choose(found, slot.M, nothing(slot.M)))
