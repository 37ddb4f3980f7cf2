"""Replay of shifts of whole paths, from the tables of their walks."""

from dataclasses import dataclass

import numpy as np

from restir_gi.extensions.oracle.shifts.criterion import Ends, came, joined, way
from restir_gi.extensions.oracle.shifts.formulas import (
    all_of,
    certainly,
    negated,
    told,
    where_positive,
)
from restir_gi.extensions.oracle.shifts.rules import ShiftRules, shifting
from restir_gi.extensions.oracle.shifts.shifted_path import (
    ShiftedPath,
    shifted_by_joining,
    shifted_by_replay,
)
from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    rounding_of,
)
from restir_gi.reference.oracle.replay.further.numbers import Choice, bounded_somehow
from restir_gi.reference.oracle.replay.judgement import Judgement, beside
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import choose, inner


@dataclass(frozen=True, slots=True, eq=False)
class Kinds:
    """Which rows are shifted how.

    Attributes
    ----------
    joins, chosen : (N,) bool
        Joined, else replayed whole; the light was sampled, else an emitter hit.
    last : (N,) int; m, index of the last point of the offset walk that takes part
    """

    joins: Masks
    chosen: Masks
    last: Indices


def kinds_of(case: Case, rules: ShiftRules) -> Kinds:
    """Which rows are shifted how."""
    joint, end = case.inputs["joint"], case.inputs["end"]
    more = joint - 1 + rules.replayed_once_more
    slots = case.inputs["hit"].shape[1]
    last = np.clip(np.where(joint > 0, more, end), 1, slots)
    return Kinds(joint > 0, case.inputs["technique"] == 1, last)


def judge_shift(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``shift``.

    Where rounding leaves open whether there is a path, the backend says.
    """
    rounding, part = rounding_of(precision), shifting(rules)
    kinds = kinds_of(case, part)
    shifted = _shifted(case, kinds, rounding, part)
    there = all_of(_domain(case, kinds, rounding, part), _not_nothing(shifted.value))
    says = (outputs["value"] != 0).any(axis=1) | (outputs["jacobian"] != 0)
    exists = there.settled(says)
    nothing = constant(0.0, shifted.value)
    base = told(case.inputs["base_value"], rounding)
    value = base if part.bases_value else shifted.value
    value = choose(exists, value, nothing)
    jacobian = choose(exists, shifted.jacobian, nothing[:, 0])
    return Judgement(
        (
            beside("value", outputs["value"], value),
            beside("jacobian", outputs["jacobian"], jacobian),
        ),
        {"exists": there.own, "value if it does": shifted.value.value},
        there.decisions(says),
        case.random,
    )


def _shifted(
    case: Case, kinds: Kinds, rounding: Rounding, rules: ShiftRules
) -> ShiftedPath:
    """Of every row in its own way, whether or not the path exists."""
    with np.errstate(invalid="ignore", over="ignore"):
        yes = shifted_by_joining(case, kinds.last, rounding, rules)
        no = shifted_by_replay(case, kinds.last, rounding, rules)
    value = choose(kinds.joins, yes.value, no.value)
    jacobian = choose(kinds.joins, yes.jacobian, no.jacobian)
    return ShiftedPath(bounded_somehow(value), bounded_somehow(jacobian))


def _not_nothing(value: Bounded) -> Choice:
    """Yes where any channel is above 0; open where it may have become 0."""
    nothing = (value.value == 0) & (value.error == 0)
    yes = value.surely_positive.any(axis=1)
    own: Masks = np.any(value.value > 0, axis=1)
    return Choice(own, yes | nothing.all(axis=1))


def _domain(case: Case, kinds: Kinds, rounding: Rounding, rules: ShiftRules) -> Choice:
    """Whether the path exists at the offset pixel, as the base path does."""
    given = case.inputs
    tests = [
        certainly(given["end"] > 0),
        _walk(case, kinds, rounding, rules),
    ]
    if rules.replays_asked:
        replays = int(case.settings["replays"]) == 1
        tests.append(certainly((given["joint"] == 2) | replays))
    at_joint = all_of(*_joint(case, kinds, rounding, rules))
    tests.append(
        Choice(~kinds.joins | at_joint.own, ~kinds.joins | at_joint.certain),
    )
    return all_of(*tests)


def _walk(case: Case, kinds: Kinds, rounding: Rounding, rules: ShiftRules) -> Choice:
    """Whether the offset walk goes as far, and cannot be joined before."""
    tests = []
    delta = case.inputs["delta"] == 1
    hit = case.inputs["hit"] == 1
    for v, able in enumerate(came(case, rounding, rules), start=1):
        here, inside = kinds.last == v, kinds.last > v
        if rules.hits_asked:
            tests.append(certainly(hit[:, v - 1] | ~(here | inside)))
        elif v == 1:
            tests.append(certainly(hit[:, 0]))
        single = delta[:, v - 1] & rules.delta_left_asked
        asked = (inside & ~single) if rules.earlier_asked else np.zeros_like(here)
        if rules.before_asked:
            asked = asked | (here & kinds.joins)
        if rules.end_asked:
            asked = asked | (here & ~kinds.joins & (kinds.chosen | ~single))
        refused = all_of(able, certainly(asked))
        tests.append(negated(refused))
    return all_of(*tests)


def _joint(
    case: Case, kinds: Kinds, rounding: Rounding, rules: ShiftRules
) -> list[Choice]:
    """Whether x_(c-1) and x_c may be joined, and see each other's front."""
    given, rows = case.inputs, np.arange(case.rows)
    at = kinds.last - 1
    x = told(given["position"], rounding)[rows, at]
    joint, normal = (
        told(given[name], rounding) for name in ("joint_position", "joint_normal")
    )
    tests = []
    if rules.joint_asked:
        alpha = told(given["alpha"], rounding)[rows, at]
        pair = Ends(
            (alpha, told(given["joint_alpha"], rounding)),
            (given["single"][rows, at] == 1, given["joint_single"] == 1),
            way(x, joint),
        )
        tests.append(joined(pair, case.settings, rules))
    if rules.horizon_asked:
        tests.append(where_positive(inner(normal, x - joint)))
    if rules.visibility_asked:
        tests.append(certainly(given["seen"] == 1))
    return tests or [certainly(np.ones(case.rows, bool))]
