"""Formulas of samples of pairs, on numbers with error bounds."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.gradient_domain.oracle.rules import PairRules
from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
)
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.verbs import choose, times


@dataclass(frozen=True, slots=True, eq=False)
class BoundedSample:
    """Samples (x, k), N rows.

    Attributes
    ----------
    second : (N,) bool; k = 1
    base, offset : (N, 3) Bounded
    inner : (N,) Bounded
    """

    second: Masks
    base: Bounded
    offset: Bounded
    inner: Bounded

    @property
    def alone(self) -> Masks:
        """Whether there is no offset path, (N,) bool."""
        found: Masks = self.inner.value == 0
        return found


def sample_in(
    inputs: Buffers, rounding: Rounding, at: tuple[object, ...] = (), suffix: str = ""
) -> BoundedSample:
    """Samples among the buffers of a case.

    Parameters
    ----------
    at : tuple; place in the columns
    """
    place: Any = (slice(None), *at)
    base, offset, inner = (
        exact(inputs[f"{name}{suffix}"][place], rounding)
        for name in ("base", "offset", "inner")
    )
    k = inputs.get(f"k{suffix}")
    second = k[place] == 1 if k is not None else np.zeros(len(base.value))
    return BoundedSample(np.asarray(second, bool), base, offset, inner)


def zero_like(x: Bounded) -> Bounded:
    """Exact zeros of the same shape."""
    return exact(np.zeros_like(x.value), x.rounding)


def differing(s: BoundedSample, rules: PairRules, share: Bounded | None) -> Bounded:
    """G, or ω G where a weight is given, (N, 3).

    Each path is weighted by itself: whoever weights the difference is no farther off.
    """
    factor = {
        "times": s.inner,
        "none": choose(s.alone, s.inner, constant(1.0, s.inner)),
        "over": constant(1.0, s.inner) / s.inner,
        "twice": s.inner * s.inner,
    }[rules.inner]
    base, offset = s.base, times(s.offset, factor)
    if share is not None:
        base, offset = times(base, share), times(offset, share)
    found = base - offset
    if rules.alone == "dropped":
        found = choose(s.alone, zero_like(found), found)
    turned = s.second if rules.turned else np.zeros_like(s.second)
    return choose(turned ^ rules.reversed, -found, found)


def share_of(p: Bounded, q: Bounded, J: Bounded, rules: PairRules) -> Bounded:
    """MIS weight ω of base paths, (N,).

    Parameters
    ----------
    p, q : (N,) Bounded; densities of base and offset paths, or their targets
    J : (N,) Bounded; inner Jacobian
    """
    one, alone = constant(1.0, J), J.value == 0
    by = {"without jacobian": q, "over jacobian": q / J}.get(rules.share, q * J)
    found = {"half": constant(0.5, J), "none": one, "other": by / (p + by)}.get(
        rules.share, p / (p + by)
    )
    lone = one if rules.share_alone == "whole" else constant(0.5, J)
    lone = choose(p.value > 0, lone, zero_like(one))
    return choose(alone, lone, found)


def integrand_of(s: BoundedSample, rules: PairRules) -> Bounded:
    """H = ω G, in primary sample space, (N, 3)."""
    one = constant(1.0, s.inner)
    return differing(s, rules, share_of(one, one, s.inner, rules))


def part_of(H: Bounded, sign: int) -> Bounded:
    """Positive or negative part of each number; all of it for 0.

    Parameters
    ----------
    sign : int; 1, −1 or 0
    """
    if sign == 0:
        return H
    x = H if sign > 0 else -H
    kept = np.maximum(x.value, 0.0)
    # A maximum moves by no more than its argument, and not where that is below 0.
    error = np.where(x.value <= -x.error, 0.0, x.error)
    return Bounded(sign * kept, error, H.rounding)


SIGNS = {"both": 0, "plus": 1, "minus": -1}


def added_by(s: BoundedSample, sign: int, rules: PairRules) -> Bounded:
    """What samples add for a sign, before W, (N, 3)."""
    H = integrand_of(s, rules)
    if rules.shown == "unweighted":
        has = part_of(H, sign).value != 0
        G = differing(s, rules, None)
        return Bounded(
            np.where(has, G.value, 0.0),
            np.where(has | (H.error == 0), G.error, np.abs(G.value) + G.error),
            G.rounding,
        )
    if rules.part == "of the luminance" and sign:
        light = luminance(H).value * sign
        return choose(light > 0, H, zero_like(H))
    found = {"own": part_of(H, sign), "other": part_of(H, -sign)}.get(rules.part, H)
    if sign < 0 and rules.minus == "added":
        found = abs(found)
    return found


def target_of(s: BoundedSample, sign: int, rules: PairRules) -> Bounded:
    """Target p̂, (N,)."""
    sign = sign if rules.signed_target else 0
    if not rules.target_weighted:
        shown = part_of(differing(s, rules, None), sign)
    else:
        shown = added_by(s, sign, rules)
    if rules.light == "of magnitudes":
        return luminance(abs(shown))
    Y = luminance(integrand_of(s, rules))
    return abs(Y if rules.light == "of the sum" else part_of(Y, sign))
