"""Known mistakes with shifts of whole paths."""

from restir_gi.extensions.oracle.shifts.mistakes_domain import DOMAINS
from restir_gi.extensions.oracle.shifts.mistakes_jacobian import JACOBIANS
from restir_gi.extensions.oracle.shifts.mistakes_value import VALUES
from restir_gi.extensions.oracle.shifts.rules import ShiftRules
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, mistake
from restir_gi.reference.oracle.replay.bounded import Bounded

JOINABLE = ("joinable",)
CRITERIA = (*JOINABLE, "shift")

ROUGH_RIGHT = "√alpha ≥ roughness at both points"
ENDS_RIGHT = "√alpha ≥ roughness and single = 0 at both points"
FAR_RIGHT = "distance > least_distance · extent"


def _as_it_is(alpha: Bounded) -> Bounded:
    return alpha


CRITERION = (
    mistake(
        "alpha-for-roughness",
        "the GGX width is taken for the perceptual roughness",
        "alpha ≥ roughness",
        ROUGH_RIGHT,
        CRITERIA,
        part=ShiftRules(perceptual=_as_it_is),
    ),
    mistake(
        "first-end-rough",
        "only the point that is left has to be rough",
        "√alpha_from ≥ roughness and single_from = 0",
        ENDS_RIGHT,
        CRITERIA,
        part=ShiftRules(ends=(0,)),
    ),
    mistake(
        "second-end-rough",
        "only the point that is reached has to be rough",
        "√alpha_to ≥ roughness and single_to = 0",
        ENDS_RIGHT,
        CRITERIA,
        part=ShiftRules(ends=(1,)),
    ),
    mistake(
        "one-rough-end-is-enough",
        "one of the two points has to be rough",
        "√alpha ≥ roughness and single = 0 at either point",
        ENDS_RIGHT,
        CRITERIA,
        part=ShiftRules(one_end_is_enough=True),
    ),
    mistake(
        "single-directions-joined",
        "points that scatter into single directions alone are not refused",
        "single_from and single_to are not asked",
        "single_from = single_to = 0",
        JOINABLE,
        part=ShiftRules(single_asked=False),
    ),
    mistake(
        "least-distance-not-asked",
        "points may be as near to each other as they like",
        "distance > 0",
        FAR_RIGHT,
        CRITERIA,
        part=ShiftRules(distance_asked=False),
    ),
    mistake(
        "least-distance-in-metres",
        "the least distance does not grow with the scene",
        "distance > least_distance",
        FAR_RIGHT,
        JOINABLE,
        part=ShiftRules(metres=True),
    ),
)

SHIFT_MISTAKES: tuple[Hypothesis, ...] = (
    *CRITERION,
    *JACOBIANS,
    *DOMAINS,
    *VALUES,
)
