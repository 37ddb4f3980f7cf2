"""Known mistakes with the Jacobian of shifts of paths."""

from restir_gi.extensions.oracle.shifts.formulas import spread
from restir_gi.extensions.oracle.shifts.rules import ShiftRules
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.verbs import square_root

SHIFT = ("shift",)
DENSITIES = ("path_jacobian", *SHIFT)

J_RIGHT = "J = (p_to s_to p_onward_to) / (p_from s_from p_onward_from), s = |cos| / d²"


def _without_cosine(steep: Bounded, squared: Bounded) -> Bounded:
    """Still 0 where there is no way: what is divided by 0 is 0."""
    return constant(1.0, squared) / squared


def _once(steep: Bounded, squared: Bounded) -> Bounded:
    return spread(steep, squared) * square_root(squared)


def _cosine_alone(steep: Bounded, squared: Bounded) -> Bounded:
    return spread(steep, squared) * squared


JACOBIANS = (
    mistake(
        "path-jacobian-inverted",
        "base path and offset path change places",
        "J = (p_from s_from p_onward_from) / (p_to s_to p_onward_to)",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(inverted=True),
    ),
    mistake(
        "path-jacobian-omitted",
        "the Jacobian of a joined path is left out",
        "J = 1",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(jacobian_omitted=True),
    ),
    mistake(
        "path-jacobian-without-cosine",
        "the cosines at the joint are left out",
        "s = 1 / d²",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(spread=_without_cosine),
    ),
    mistake(
        "path-jacobian-distance-once",
        "the distances are not squared",
        "s = |cos| / d",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(spread=_once),
    ),
    mistake(
        "path-jacobian-without-distance",
        "the distances are left out",
        "s = |cos|",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(spread=_cosine_alone),
    ),
    mistake(
        "offset-without-cosine",
        "the offset path's cosine at the joint is left out, the base path's is not",
        "s_to = 1 / d²",
        J_RIGHT,
        SHIFT,
        part=ShiftRules(spread_to=_without_cosine),
    ),
    mistake(
        "offset-distance-once",
        "the offset path's distance is not squared, the base path's is",
        "s_to = |cos| / d",
        J_RIGHT,
        SHIFT,
        part=ShiftRules(spread_to=_once),
    ),
    mistake(
        "offset-without-distance",
        "the offset path's distance is left out, the base path's is not",
        "s_to = |cos|",
        J_RIGHT,
        SHIFT,
        part=ShiftRules(spread_to=_cosine_alone),
    ),
    mistake(
        "path-jacobian-without-left-density",
        "the densities with which x_(c−1) is left are left out",
        "J = (s_to p_onward_to) / (s_from p_onward_from)",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(left_density=False),
    ),
    mistake(
        "path-jacobian-without-onward-density",
        "the densities with which x_c is left are left out",
        "J = (p_to s_to) / (p_from s_from)",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(onward_density=False),
    ),
    mistake(
        "path-jacobian-densities-omitted",
        "both densities are left out: the Jacobian of solid angles, not of numbers",
        "J = s_to / s_from",
        J_RIGHT,
        DENSITIES,
        part=ShiftRules(left_density=False, onward_density=False),
    ),
    mistake(
        "offset-without-left-density",
        "the offset path's density at x_(c−1) is left out, the base path's is not",
        "J = (s_to p_onward_to) / density",
        J_RIGHT,
        SHIFT,
        part=ShiftRules(offset_left=False),
    ),
    mistake(
        "offset-without-onward-density",
        "the offset path's density at x_c is left out, the base path's is not",
        "J = (p_to s_to) / density",
        J_RIGHT,
        SHIFT,
        part=ShiftRules(offset_onward=False),
    ),
    mistake(
        "chosen-light-has-a-density",
        "the density at x_c counts although the light was chosen",
        "q = pdf_onward for technique 1",
        "q = 1 for technique 1",
        SHIFT,
        part=ShiftRules(chosen_density=True),
    ),
)
