"""Replay of resampling where each merge is closed before the next one."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.judgement import Decisions, Judgement
from restir_gi.reference.oracle.replay.mis import source_density
from restir_gi.reference.oracle.replay.points import SamplePoint
from restir_gi.reference.oracle.replay.resampling import (
    closed_confidence,
    compared_with,
    held_by,
    if_in_domain,
    of_kept,
    that_fits,
    weights_beside,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import Closing, Slot, nothing
from restir_gi.reference.oracle.replay.stream import (
    by_chance,
    left_open,
    sums_of,
)
from restir_gi.reference.oracle.replay.verbs import choose


@dataclass(frozen=True, slots=True, eq=False)
class Merge:
    """A reservoir of the receiver that has taken in some slots, N rows.

    Attributes
    ----------
    kept : (N,) int; slot that it holds
    held : Bounded; (N,), p̂ W
    M : Bounded; (N,)
    count : int; slots that were merged
    """

    kept: Indices
    held: Bounded
    M: Bounded
    count: int


def first_of_chain(slots: list[Slot]) -> Merge:
    """A chain of merges that holds its first slot."""
    slot = slots[0]
    return Merge(np.zeros(len(slot.w.value), int), slot.w / slot.M, slot.M, 1)


def merge_weights(
    before: Merge, slots: list[Slot], closing: Closing, rules: Rules
) -> tuple[Bounded, Bounded]:
    """Weights of what is held and of the next slot, (N,) each."""
    if rules.normalization == "chained-1/Z":
        return before.held * before.M, slots[before.count].w
    k = before.count
    slot = slots[k]
    y, p_hat = of_kept(slots, before.kept)
    p_r, p_n = _pair(before, slots, before.kept, y, p_hat, closing, rules)
    held = before.held * (before.M * p_r / (before.M * p_r + slot.M * p_n))
    here = np.full(len(before.kept), k)
    p_r, p_n = _pair(before, slots, here, slot.y, slot.p_hat, closing, rules)
    return held, slot.w * (p_n / (before.M * p_r + slot.M * p_n))


def _pair(
    before: Merge,
    slots: list[Slot],
    of: Indices,
    y: SamplePoint,
    p_hat: Bounded,
    closing: Closing,
    rules: Rules,
) -> tuple[Bounded, Bounded]:
    """Densities of a sample in a reservoir of the receiver, and in the next slot's."""

    def density(slot: Slot) -> Bounded:
        rows = np.arange(len(of))
        seen = slot.domain.sees[of, rows] if slot.domain else rows >= 0
        return source_density(slot, y, p_hat, seen, closing, rules)

    held = density(slots[0]) if before.count == 1 else p_hat
    return held, density(slots[before.count])


def merged_with(
    before: Merge,
    weights: tuple[Bounded, Bounded],
    accepted: Masks,
    slots: list[Slot],
    closing: Closing,
    rules: Rules,
) -> Merge:
    """The chain after its next slot.

    Parameters
    ----------
    weights : pair of Bounded; as of `merge_weights`
    accepted : (N,) bool; the next slot is kept
    """
    k = before.count
    kept = np.where(accepted, k, before.kept)
    held = rules.merged_weight(*weights)
    M = rules.merged_confidence(before.M, slots[k].M)
    if rules.normalization == "chained-1/Z":
        y, p_hat = of_kept(slots, kept)
        p_r, p_n = _pair(before, slots, kept, y, p_hat, closing, rules)
        everybody = np.ones(len(kept), bool)
        held = held / (
            if_in_domain(p_r, everybody, before.M)
            + if_in_domain(p_n, everybody, slots[k].M)
        )
    return Merge(kept, held, M, k + 1)


def judge_chain(
    outputs: Buffers, slots: list[Slot], closing: Closing, rules: Rules, counted: bool
) -> Judgement:
    """Judge reservoirs of which each slot was merged by itself, and closed.

    Where a decision of which the outputs tell nothing is within rounding, W is not
    looked at.
    """
    surely = _walked(slots, closing, rules, None).chain.kept
    rows = np.arange(len(surely))
    held = held_by(outputs, slots, rules)
    claimed = np.where(held[surely, rows], surely, held.argmax(axis=0))

    def fits(claimed: Indices) -> Masks:
        walk = _walked(slots, closing, rules, claimed)
        W = _weight_after(walk, slots, rules)
        found: Masks = weights_beside(outputs, W, rules).excess <= 1
        return found & walk.may_be

    claimed = that_fits(claimed, held, fits)
    walk = _walked(slots, closing, rules, claimed)
    chain, empty = walk.chain, walk.total == 0
    illegal = ~(walk.may_be & held.any(axis=0)) & ~empty
    W = _weight_after(walk, slots, rules)
    M = closed_confidence(chain.M, closing, rules)
    drawn = by_chance(slots)
    differing = int(((claimed != surely) & ~illegal & ~empty & drawn).sum())
    decisions = Decisions(illegal, differing, left_open(slots, sums_of(slots, rules)))
    terms = {f"w of slot {k}": slot.w.value for k, slot in enumerate(slots)}
    terms |= {"kept slot": claimed, "slot in exact arithmetic": surely}
    compared = compared_with(outputs, slots, surely, illegal, W, M, rules)
    return Judgement(compared, terms, decisions, counted)


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """A chain of merges, N rows.

    Attributes
    ----------
    legal : (N,) bool; all its decisions are allowed
    unsure : (N,) bool; one of which the kept slot tells nothing is open
    total : (N,); sum of weights in the end
    """

    chain: Merge
    legal: Masks
    unsure: Masks
    total: Scalars

    @property
    def may_be(self) -> Masks:
        """Whether rounding allows all that was kept, (N,) bool.

        What follows an open decision hangs on how it was taken, which nobody knows.
        """
        return self.legal | self.unsure


def _weight_after(walk: Walk, slots: list[Slot], rules: Rules) -> Bounded:
    """W that a chain leaves, of which nothing is known where a decision is open."""
    _, p_hat = of_kept(slots, walk.chain.kept)
    W = rules.closed(walk.chain.held, p_hat, constant(1.0, p_hat))
    W = Bounded(W.value, np.where(walk.unsure, np.inf, W.error), W.rounding)
    return choose(walk.total == 0, nothing(W), W)


def _walked(
    slots: list[Slot], closing: Closing, rules: Rules, claimed: Indices | None
) -> Walk:
    """A chain of merges, in exact arithmetic or as the kept slots tell."""
    chain = first_of_chain(slots)
    everybody = np.ones(len(chain.kept), bool)
    legal, unsure, total = everybody, ~everybody, slots[0].w.value
    for k in range(1, len(slots)):
        weights = merge_weights(chain, slots, closing, rules)
        prefers = rules.preference(slots[k].u, *weights)
        alone = (weights[0].value == 0) & (weights[1].value > 0)
        accepted = (prefers.value > 0) | alone
        may = ~prefers.surely_not_positive & (weights[1].value > 0)
        must = prefers.surely_positive | alone & weights[1].surely_positive
        if claimed is not None:
            unsure = unsure | ((claimed > k) & (may & ~must))
            accepted = np.where(claimed > k, accepted, claimed == k)
            legal = legal & np.where(claimed == k, may | alone, True)
            legal = legal & ((claimed >= k) | ~must)
        chain = merged_with(chain, weights, accepted, slots, closing, rules)
        total = (weights[0] + weights[1]).value
    return Walk(chain, legal, unsure, total)
