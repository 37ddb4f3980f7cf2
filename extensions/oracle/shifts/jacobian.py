"""Replay of the Jacobian of a shift that joins a path."""

from restir_gi.extensions.oracle.shifts.formulas import spread_between
from restir_gi.extensions.oracle.shifts.rules import ShiftRules, shifting
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.further.numbers import bounded_somehow
from restir_gi.reference.oracle.replay.judgement import Judgement, beside
from restir_gi.reference.oracle.replay.rules import Rules


def jacobian_of(
    base: Bounded,
    offset: Bounded,
    p: tuple[Bounded, Bounded],
    p_onward: tuple[Bounded, Bounded],
    rules: ShiftRules,
) -> Bounded:
    """Jacobian of a path that is joined, (N,).

    Parameters
    ----------
    base : (N,) Bounded
        Both densities of the base path and the solid angle of its joint, multiplied.
    offset : (N,) Bounded; solid angle of the offset path's joint alone
    p, p_onward : pairs of (N,) Bounded
        Densities of the base path and of the offset path.
    """
    whole = offset * p[1] if rules.offset_left else offset
    whole = whole * p_onward[1] if rules.offset_onward else whole
    if rules.jacobian_omitted:
        # Where there is no shift there is none, whatever its Jacobian.
        return bounded_somehow(whole / whole)
    if not rules.left_density:
        base, whole = base / p[0], offset * p_onward[1]
    if not rules.onward_density:
        base, whole = base / p_onward[0], offset * p[1]
    return bounded_somehow(base / whole if rules.inverted else whole / base)


def judge_jacobian(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``path_jacobian``."""
    rounding, part = rounding_of(precision), shifting(rules)
    given = {name: exact(array, rounding) for name, array in case.inputs.items()}
    ends, spreads = ("from", "to"), []
    for end in ends:
        steep, squared = spread_between(
            given[f"x_{end}"], given["joint_position"], given["joint_normal"]
        )
        spreads.append(part.spread(abs(steep), squared))
    left = given["p_from"], given["p_to"]
    onward = given["p_onward_from"], given["p_onward_to"]
    base = spreads[0] * left[0] * onward[0]
    found = jacobian_of(base, spreads[1], p=left, p_onward=onward, rules=part)
    return Judgement(
        (beside("jacobian", outputs["jacobian"], found),),
        {"spread from": spreads[0].value, "spread to": spreads[1].value},
    )
