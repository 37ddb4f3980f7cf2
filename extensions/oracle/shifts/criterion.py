"""Replay of the criterion: which points of a path may be joined."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.extensions.oracle.shifts.formulas import (
    all_of,
    certainly,
    negated,
    told,
    where_positive,
)
from restir_gi.extensions.oracle.shifts.rules import ShiftRules, shifting
from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.further.numbers import (
    Choice,
    setting,
    where_not_negative,
)
from restir_gi.reference.oracle.replay.judgement import Judgement, exactly
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import inner, square_root


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """Two points of each row, as the criterion sees them.

    Attributes
    ----------
    alpha : tuple of two (N,) Bounded; GGX widths
    single : tuple of two (N,) bool; whether they scatter into single directions alone
    distance : (N,) Bounded; between them
    """

    alpha: tuple[Bounded, Bounded]
    single: tuple[Masks, Masks]
    distance: Bounded


def joined(ends: Ends, settings: Mapping[str, Value], rules: ShiftRules) -> Choice:
    """Whether two points may be joined, (N,)."""
    rounding = ends.distance.rounding
    roughness, least, extent = (
        setting(settings[name], rounding)
        for name in ("roughness", "least_distance", "extent")
    )
    tests = [where_positive(ends.distance)]
    if rules.distance_asked:
        away = least if rules.metres else least * extent
        tests.append(where_positive(ends.distance - away))
    rough = []
    for end in rules.ends:
        able = where_not_negative(rules.perceptual(ends.alpha[end]) - roughness)
        single = ends.single[end] & rules.single_asked
        rough.append(all_of(able, certainly(~single)))
    if rules.one_end_is_enough:
        rough = [negated(all_of(*map(negated, rough)))]
    return all_of(*tests, *rough)


def way(a: Bounded, b: Bounded) -> Bounded:
    """Distance from points to points, (N,).

    Parameters
    ----------
    a, b : Bounded; (N, 3)
    """
    return square_root(inner(b - a, b - a))


def came(case: Case, rounding: Rounding, rules: ShiftRules) -> list[Choice]:
    """Whether x_v may be joined, as far as it hangs on how the walk came there.

    Returns list of Choice; (N,) each, of x_1 to x_V; the first is a no.
    """
    given = case.inputs
    position, contact, alpha = (
        told(given[name], rounding) for name in ("position", "contact", "alpha")
    )
    single, delta = given["single"] == 1, given["delta"] == 1
    found = [certainly(np.zeros(case.rows, bool))]
    for v in range(1, single.shape[1]):
        pair = Ends(
            (alpha[:, v - 1], alpha[:, v]),
            (single[:, v - 1], single[:, v]),
            way(position[:, v - 1], contact[:, v]),
        )
        able = joined(pair, case.settings, rules)
        diffuse = ~delta[:, v - 1] | (not rules.delta_came_asked)
        early = v + 1 <= int(case.settings["last_joint"]) or not rules.last_asked
        found.append(all_of(able, certainly(diffuse & early)))
    return found


def judge_joinable(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``joinable``.

    Who is at a threshold, to rounding, may be on either side of it.
    """
    rounding, given = rounding_of(precision), case.inputs
    alpha_from, alpha_to, distance = (
        exact(given[name], rounding) for name in ("alpha_from", "alpha_to", "distance")
    )
    single = given["single_from"] == 1, given["single_to"] == 1
    pair = Ends((alpha_from, alpha_to), single, distance)
    able = joined(pair, case.settings, shifting(rules))
    found: Any = outputs["joinable"]
    settled = able.settled(found == 1).astype(np.uint32)
    return Judgement(
        (exactly("joinable", found, settled),),
        {"exact": able.own},
        able.decisions(found == 1),
        case.random,
    )
