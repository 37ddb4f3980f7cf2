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
    base: Bounded, spread: Bounded, p: Bounded, p_onward: Bounded, rules: ShiftRules
) -> Bounded:
    """Jacobian of a path that is joined, (N,).

    Parameters
    ----------
    base : (N,) Bounded
        The base path's solid angle and those of its densities that count, multiplied.
    spread : (N,) Bounded; solid angle of the offset path's joint
    p, p_onward : (N,) Bounded; densities of the offset path
    """
    offset = spread * p if rules.left_density and rules.offset_left else spread
    if rules.onward_density and rules.offset_onward:
        offset = offset * p_onward
    if rules.jacobian_omitted:
        # Where there is no shift there is none, whatever its Jacobian.
        return bounded_somehow(offset / offset)
    return bounded_somehow(base / offset if rules.inverted else offset / base)


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
    base = spreads[0] * given["p_from"] if part.left_density else spreads[0]
    base = base * given["p_onward_from"] if part.onward_density else base
    p, p_onward = given["p_to"], given["p_onward_to"]
    found = jacobian_of(base, spreads[1], p=p, p_onward=p_onward, rules=part)
    return Judgement(
        (beside("jacobian", outputs["jacobian"], found),),
        {"spread from": spreads[0].value, "spread to": spreads[1].value},
    )
