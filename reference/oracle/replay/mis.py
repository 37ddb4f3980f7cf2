"""MIS weights that renderers have in place of 1/M and 1/Z.  [Lin22, Eqs. 36 to 38].

All sum to 1 over those that could have made a sample, so that each is unbiased.  They
are applied either to the weights of the stream, or once to the sum of weights, for the
sample that was kept.
"""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.contract.weights import BALANCE, DEFENSIVE
from restir_gi.reference.oracle.contract.weights import PAIRWISE as PAIRWISE_MIS
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.cached import jacobian_by, target_by
from restir_gi.reference.oracle.replay.limits import within
from restir_gi.reference.oracle.replay.points import SamplePoint
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import Closing, Slot, nothing
from restir_gi.reference.oracle.replay.verbs import choose, where_positive

PAIRWISE = ("pairwise", "defensive", "pairwise-of-k", "defensive-of-k")
LACKING = ("defensive-without-share", "pairwise-own-whole", "defensive-own-whole")
"""Pairs with a mistake in what the canonical sample has; they do not sum to 1."""

IN_WEIGHTS = ("balance-in-weights", *PAIRWISE, *LACKING)
BALANCED = ("balance", "balance-of-ones", "balance-of-full")
"""Balance heuristics of the kept sample: of M; of 1 each, and of 1 where M > 0, which
do not sum to 1."""

CHAINED = ("chained-balance", "chained-1/Z")
UNBIASED = ("1/Z", "balance", "balance-in-weights", *PAIRWISE, *CHAINED)
"""Weights that leave the mean alone, by their names in `Rules.normalization`."""

OWN = "own"
"""Weights of which a backend says no more than that they sum to 1."""


def weights_asked(closing: Closing, rules: Rules) -> str:
    """Weights that a case asks for, or that the rules have in place of these."""
    if rules.normalization != "asked":
        return rules.normalization
    heard = {
        BALANCE: rules.balance_as,
        PAIRWISE_MIS: rules.pairwise_as,
        DEFENSIVE: rules.defensive_as,
    }
    return heard.get(closing.mis, closing.mis)


def source_density(
    slot: Slot,
    y: SamplePoint,
    p_hat: Bounded,
    seen: Masks,
    closing: Closing,
    rules: Rules,
) -> Bounded:
    """Target at the source of a slot, in the receiver's measure; 0 out of its domain.

    Parameters
    ----------
    y : SamplePoint; N samples
    p_hat : Bounded; (N,), their target at the receiver
    seen : (N,) bool; whether the source sees them

    Returns
    -------
    Bounded; (N,)
    """
    if slot.domain is None:
        return p_hat
    held = seen | (not rules.visibility_in_z)
    x = closing.receiver if rules.receivers_domain else slot.domain.x
    p = target_by(rules.target_at_source, closing.kind, x, y)
    p = in_domain(choose(held, p, nothing(p)), slot, y, closing, rules)
    if not rules.mis_jacobian:
        return p
    return p / jacobian_by(rules.jacobian, slot.domain.x, closing.receiver, y)


def in_domain(
    p: Bounded, slot: Slot, y: SamplePoint, closing: Closing, rules: Rules
) -> Bounded:
    """A number, but 0 where the shift from a source would be refused, (N,)."""
    if not rules.refused_both_ways or slot.domain is None:
        return p
    J = jacobian_by(rules.jacobian, slot.domain.x, closing.receiver, y)
    return where_positive(within(J, *rules.refused), p)


def with_mis_weights(slots: list[Slot], closing: Closing, rules: Rules) -> list[Slot]:
    """Slots whose weights have their MIS weight in place of M."""
    name = weights_asked(closing, rules)
    if name not in IN_WEIGHTS:
        return slots
    share = _balanced if name == "balance-in-weights" else _pairwise
    return [
        replace(slot, w=slot.w * share(k, slots, closing, rules))
        for k, slot in enumerate(slots)
    ]


def _density(
    at: int, of: int, slots: list[Slot], closing: Closing, rules: Rules
) -> Bounded:
    """Density with which the source of one slot makes the sample of another."""
    slot, y, p_hat = slots[at], slots[of].y, slots[of].p_hat
    seen = slot.domain.sees[of] if slot.domain else np.ones_like(p_hat.value, bool)
    return source_density(slot, y, p_hat, seen, closing, rules)


def _balanced(k: int, slots: list[Slot], closing: Closing, rules: Rules) -> Bounded:
    """M / M of the balance heuristic."""
    whole = nothing(slots[k].M)
    for j, slot in enumerate(slots):
        whole = whole + slot.M * _density(j, k, slots, closing, rules)
    return _density(k, k, slots, closing, rules) / whole


def _pairwise(k: int, slots: list[Slot], closing: Closing, rules: Rules) -> Bounded:
    """M / M of weights of pairs: the canonical sample with each of the others."""
    own, name = closing.canonical, weights_asked(closing, rules)
    others = [j for j in range(len(slots)) if j != own]
    M_own = slots[own].M
    by_count = name.endswith("of-k")
    S = nothing(M_own)
    for j in others:
        S = S + (_is_there(slots[j].M) if by_count else slots[j].M)
    one = constant(1.0, S)
    if k == own and name.endswith("own-whole"):
        return one / M_own
    defends = one if by_count else M_own
    T = S + defends if name.startswith("defensive") else S

    def pair(j: int, of: int) -> tuple[Bounded, Bounded]:
        """Densities of a pair, times what they weigh: another, and the canonical."""
        weighs = slots[j].M * S if by_count else S
        p_j = weighs * _density(j, of, slots, closing, rules)
        return p_j, M_own * _density(own, of, slots, closing, rules)

    if k != own:
        p_k, p_own = pair(k, k)
        share = p_k / (p_k + p_own) / T
        return share / slots[k].M if by_count else share
    has_share = name.startswith("defensive") and name != "defensive-without-share"
    found = one / T if has_share else nothing(T)
    if by_count:
        found = found / M_own
    for j in others:
        p_j, p_own = pair(j, own)
        part = _is_there(slots[j].M) if by_count else slots[j].M
        found = found + part / T * (p_own / (p_j + p_own)) / M_own
    alone = (S.value == 0) & (S.error == 0)
    return choose(alone, one / M_own, found)


def _weighs(M: Bounded, name: str) -> Bounded:
    """What stands for the confidence of a source in the balance."""
    if name == "balance":
        return M
    return constant(1.0, M) if name == "balance-of-ones" else _is_there(M)


def _is_there(M: Bounded) -> Bounded:
    return Bounded((M.value > 0).astype(float), np.zeros_like(M.value), M.rounding)


def balanced_divisor(
    slots: list[Slot],
    kept: Indices,
    y: SamplePoint,
    p_hat: Bounded,
    closing: Closing,
    rules: Rules,
) -> Bounded:
    """Σ M p(y) / p_kept(y): what the sum of weights M p̂ W J is divided by, (N,)."""
    rows, name = np.arange(len(kept)), weights_asked(closing, rules)
    whole, maker = nothing(p_hat), nothing(p_hat)
    for k, slot in enumerate(slots):
        seen = slot.domain.sees[kept, rows] if slot.domain else rows >= 0
        p = source_density(slot, y, p_hat, seen, closing, rules)
        whole = whole + _weighs(slot.M, name) * p
        maker = choose(kept == k, p, maker)
    return whole / maker
