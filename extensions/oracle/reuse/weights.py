"""Weights of samples before they compete, and what their sum is divided by."""

import numpy as np

from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.extensions.oracle.reuse.tables import PAIRS, ReuseTables
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.replay.bounded import Bounded, exact
from restir_gi.reference.oracle.replay.formulas import capped
from restir_gi.reference.oracle.replay.verbs import choose


def total(terms: list[Bounded]) -> Bounded:
    """Sum of bounded numbers, (N,) Bounded; in the order given.

    Parameters
    ----------
    terms : list of (N,) Bounded; at least one
    """
    found = terms[0]
    for term in terms[1:]:
        found = found + term
    return found


def arriving(t: ReuseTables, rules: ReuseRules) -> list[Bounded]:
    """Weights w_k with which samples compete.

    Returns list of (N,) Bounded; in the order of the slots.
    """
    m = _in_pairs(t, rules) if t.mis in PAIRS else t.M
    if rules.capped == "weights":
        m = [capped(each, t.cap) for each in m]
    found = []
    for k, W in enumerate(t.W):
        w = m[k] * t.here[k] * W
        if rules.beside_confidence and t.mis in PAIRS:
            w = w * t.M[k]
        if k != t.canonical:
            J, there = t.jacobian[k], t.jacobian[k].value > 0
            none = exact(np.zeros_like(J.value), J.rounding)
            by = {
                "times": w * J,
                "none": choose(there, w, none),
                "over": w / J,
                "twice": w * J * J,
            }
            w = by[rules.jacobian]
        found.append(w)
    return found


def _in_pairs(t: ReuseTables, rules: ReuseRules) -> list[Bounded]:
    """Weights m_k that stand in place of M_k, each below 1."""
    c, sources = t.canonical, t.sources
    if not sources:
        return [t.one]
    S, defensive = total([t.M[k] for k in sources]), t.mis == "defensive"
    m = list(t.M)
    m[c] = _canonical(t, S, S + t.M[c] if defensive else S, defensive, rules)
    S = S + t.M[c] if rules.canonical_in_s else S
    T = S + t.M[c] if defensive and rules.defensive_total else S
    for k in sources:
        p, p_c = t.made[k], t.here[k]
        if rules.exchanged:
            p, p_c = p_c, p
        m[k] = t.M[k] / T * _share(S * p, t.M[c] * p_c)
    return m


def _canonical(
    t: ReuseTables, S: Bounded, T: Bounded, defensive: bool, rules: ReuseRules
) -> Bounded:
    c = t.canonical
    if rules.canonical_share == "whole":
        return t.one
    if rules.canonical_share == "none":
        return t.one - t.one
    p_c = t.M[c] * t.here[c]
    parts = [t.M[k] / T * _share(p_c, S * t.at_others[:, c, k]) for k in t.sources]
    if defensive:
        parts.append(t.M[c] / T)
        return total(parts)
    return choose(S.value > 0, total(parts), t.one)


def _share(a: Bounded, b: Bounded) -> Bounded:
    return a / (a + b)


def divisor(t: ReuseTables, kept: Indices, rules: ReuseRules) -> Bounded:
    """What the sum of weights is divided by, beside the target.

    Parameters
    ----------
    kept : (N,) int; slot of the sample that is kept

    Returns
    -------
    (N,) Bounded; 1 for weights in pairs
    """
    if t.mis in PAIRS:
        return total(t.M) if rules.divided_again else t.one
    asked = rules.normalization if t.mis in rules.replaced else t.mis
    if asked == "1/M":
        return total(t.M)
    p = [_at(t, k, kept) for k in range(len(t.W))]
    if asked == "1/Z":
        return total([_held(t, k, p[k], kept, rules) for k in range(len(p))])
    made = of_kept(p, kept) if rules.maker_divides else of_kept(t.here, kept)
    return total([M * p_k for M, p_k in zip(t.M, p, strict=True)]) / made


def _at(t: ReuseTables, k: int, kept: Indices) -> Bounded:
    """Target of what is kept at slot k, in the receiver's measure."""
    if k == t.canonical:
        return of_kept(t.here, kept)
    row = np.arange(len(kept))
    return choose(kept == k, t.made[k], t.at_others[row, kept, k])


def _held(
    t: ReuseTables, k: int, p: Bounded, kept: Indices, rules: ReuseRules
) -> Bounded:
    # Who made a sample could make it, whatever its target is by other rules.
    in_domain = (p.value > 0) | (kept == k) | rules.every_domain
    if not rules.maker_counts:
        in_domain &= kept != k
    none = exact(np.zeros_like(p.value), p.rounding)
    return choose(in_domain, t.M[k], none)


def of_kept(slots: list[Bounded], kept: Indices) -> Bounded:
    """A number of the slot that is kept, (N,) Bounded; row by row.

    Parameters
    ----------
    slots : list of (N,) Bounded
    kept : (N,) int
    """
    found = slots[0]
    for k, slot in enumerate(slots[1:], start=1):
        found = choose(kept == k, slot, found)
    return found
