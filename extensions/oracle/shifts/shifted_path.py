"""Value and Jacobian of a shifted path, if it exists."""

from dataclasses import dataclass

import numpy as np

from restir_gi.extensions.oracle.shifts.formulas import (
    share,
    spread,
    spread_between,
    told,
)
from restir_gi.extensions.oracle.shifts.jacobian import jacobian_of
from restir_gi.extensions.oracle.shifts.rules import ShiftRules
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant
from restir_gi.reference.oracle.replay.verbs import choose, times


@dataclass(frozen=True, slots=True, eq=False)
class ShiftedPath:
    """Of shifted paths.

    Attributes
    ----------
    value : (N, 3) Bounded; f / p
    jacobian : (N,) Bounded; of the shift
    """

    value: Bounded
    jacobian: Bounded


def shifted_by_replay(
    case: Case, last: Indices, rounding: Rounding, rules: ShiftRules
) -> ShiftedPath:
    """Value and Jacobian of paths that are replayed whole.

    Parameters
    ----------
    last : (N,) int; m, at which they end
    """
    light = told(case.inputs["light"], rounding)
    value = throughput(case, last, rounding, rules.end_throughput) * light
    one = constant(1.0, value[:, 0])
    density = told(case.inputs["density"], rounding)
    return ShiftedPath(value, one / density if rules.replayed_over_density else one)


def shifted_by_joining(
    case: Case, last: Indices, rounding: Rounding, rules: ShiftRules
) -> ShiftedPath:
    """Value and Jacobian of paths that are joined.

    Parameters
    ----------
    last : (N,) int; m, from which the joint is seen
    """
    given = case.inputs
    left, onward, incoming = (
        told(given[name], rounding) for name in ("left", "onward", "incoming")
    )
    p_left = told(given["pdf_left"], rounding)
    _, q = _onward(case, rounding, rules)
    before = throughput(case, last, rounding, rules.throughput)
    value = before * (left / p_left[:, None]) * (onward / q[:, None])
    value = times(value, share_of(case, rounding, rules)) * incoming
    return ShiftedPath(value, _jacobian(case, last, rounding, rules))


def throughput(case: Case, last: Indices, rounding: Rounding, whose: str) -> Bounded:
    """Product of the offset walk's weights of x_1 to x_(m-1), (N, 3).

    Parameters
    ----------
    last : (N,) int; m
    """
    if whose == "base":
        return told(case.inputs["base_throughput"], rounding)
    weight = told(case.inputs["weight"], rounding)
    one = product = constant(1.0, weight[:, 0])
    if whose == "none":
        return one
    for v in range(1, weight.value.shape[1]):
        before = one if whose == "last" else product
        product = choose(v < last, before * weight[:, v - 1], product)
    return product


def share_of(case: Case, rounding: Rounding, rules: ShiftRules) -> Bounded:
    """Share of the technique that found a light after x_c, else 1, (N,)."""
    given = case.inputs
    name = "base_pdf_onward" if rules.share == "base" else "pdf_onward"
    p_bsdf, p_light = (told(given[n], rounding) for n in (name, "pdf_light"))
    of_light, of_bsdf = share(p_light, p_bsdf), share(p_bsdf, p_light)
    technique = 2 if rules.share == "other" else 1
    choice = (given["technique"] == technique) | (rules.share == "choice")
    found = choose(choice, of_light, of_bsdf)
    alone = (given["joint"] != given["end"]) | (rules.share == "none")
    return choose(alone, constant(1.0, found), found)


def _jacobian(
    case: Case, last: Indices, rounding: Rounding, rules: ShiftRules
) -> Bounded:
    """The base path's density is that of the record: its spread stands in it."""
    given, rows = case.inputs, np.arange(case.rows)
    joint, normal, x_base = (
        told(given[name], rounding)
        for name in ("joint_position", "joint_normal", "base_position")
    )
    base, p_base, p = (
        told(given[name], rounding) for name in ("density", "base_pdf_left", "pdf_left")
    )
    steep, squared = spread_between(x_base, joint, normal)
    right, wrong = spread(abs(steep), squared), rules.spread(abs(steep), squared)
    if rules.spread is not spread:
        base = base * (wrong / right)
    x = told(given["position"], rounding)[rows, last - 1]
    steep, squared = spread_between(x, joint, normal)
    offset = (rules.spread_to or rules.spread)(abs(steep), squared)
    offset = right if rules.bases_distance else offset
    onward_base, onward = _onward(case, rounding, rules)
    base = base if rules.left_density else base / p_base
    base = base if rules.onward_density else base / onward_base
    return jacobian_of(base, offset, p=p, p_onward=onward, rules=rules)


def _onward(
    case: Case, rounding: Rounding, rules: ShiftRules
) -> tuple[Bounded, Bounded]:
    """Second density of base path and offset path, 1 where the light was chosen."""
    given = case.inputs
    base, offset = (
        told(given[name], rounding) for name in ("base_pdf_onward", "pdf_onward")
    )
    chosen = (given["technique"] == 1) & (given["joint"] == given["end"])
    one = constant(1.0, base)
    counted = offset if rules.chosen_density else choose(chosen, one, offset)
    return choose(chosen, one, base), counted
