"""Competitors in a stream, as a replay sees them."""

from collections.abc import Iterator, Mapping
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
    mis : str; weights that are asked for, a value of the setting
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


@dataclass(frozen=True, slots=True)
class StreamOrder:
    """Who comes when in a stream, and whose random number decides on it.

    Attributes
    ----------
    first : tuple of str; 'past', 'own' and 'neighbors', as they come
    turned : bool; neighbours come in reverse
    in_place : bool
        A number belongs to a place in the stream, not to a reservoir.  The past has
        none of its own: it takes that of the first, which needs none.
    """

    first: tuple[str, str, str]
    turned: bool = False
    in_place: bool = False

    def of(self, count: int, own: int) -> tuple[list[int], list[int]]:
        """Slots in this order, and for each the slot whose number decides on it.

        Where the receiver's own comes first there is no past.
        """
        neighbors = list(range(own + 1, count))
        places = {
            "past": [0] if own else [],
            "own": [own],
            "neighbors": neighbors[::-1] if self.turned else neighbors,
        }
        order = [k for name in self.first for k in places[name]]
        if self.in_place:
            return order, list(range(count))
        return order, [k or order[0] for k in order]


BLOCKS: Mapping[str, tuple[str, str, str]] = {
    "": ("past", "own", "neighbors"),
    "own-first": ("own", "past", "neighbors"),
    "past-last": ("own", "neighbors", "past"),
    "own-last": ("past", "neighbors", "own"),
    "neighbors-first": ("neighbors", "past", "own"),
    "neighbors-own-past": ("neighbors", "own", "past"),
}


def _orders() -> Iterator[tuple[str, StreamOrder]]:
    """Orders by their names, that of the contract left out."""
    for name, blocks in BLOCKS.items():
        for turned in (False, True):
            word = "-".join(filter(None, [name or "neighbors", "turned" * turned]))
            yield word, StreamOrder(blocks, turned)
            yield f"{word}-in-place", StreamOrder(blocks, turned, True)


# Numbers of places and of reservoirs are the same where no neighbour moves.
SAME = ("neighbors", "neighbors-in-place", "own-first-in-place")

ORDERS: Mapping[str, StreamOrder] = {
    "reversed": StreamOrder(BLOCKS["neighbors-own-past"], True, True),
    **{
        name: order
        for name, order in _orders()
        if name not in (*SAME, "neighbors-own-past-turned-in-place")
    },
}
"""Orders of a stream other than the contract's."""


def in_order(
    slots: list[Slot], closing: Closing, order: str
) -> tuple[list[Slot], Closing]:
    """The stream in another order.

    Whoever is asked about the samples is asked in the new order.

    Parameters
    ----------
    slots : list of Slot; in the order of the contract
    order : str; 'contract', or a name of `ORDERS`
    """
    if order == "contract":
        return slots, closing
    chosen, numbers = ORDERS[order].of(len(slots), closing.canonical)
    found = [
        replace(slots[k], u=slots[n].u) for k, n in zip(chosen, numbers, strict=True)
    ]
    turned = [
        replace(slot, domain=replace(slot.domain, sees=slot.domain.sees[chosen]))
        if slot.domain
        else slot
        for slot in found
    ]
    return turned, replace(closing, canonical=chosen.index(closing.canonical))


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
