"""Shifts of whole paths as a part of the contract."""

from extensions.oracle.shifts.cases import PLACES, null_case, shift_case
from extensions.oracle.shifts.criterion import judge_joinable
from extensions.oracle.shifts.exact_cases import exact_cases
from extensions.oracle.shifts.jacobian import judge_jacobian
from extensions.oracle.shifts.mistakes import SHIFT_MISTAKES
from extensions.oracle.shifts.own import OWN
from extensions.oracle.shifts.passes import SHIFT_PASSES
from extensions.oracle.shifts.replay import judge_shift
from reference.oracle.contract.fields import Precision
from reference.oracle.levels.probe import Probe
from reference.oracle.levels.replayed import replayed
from reference.oracle.parts import Part


def _probes(precision: Precision) -> list[Probe]:
    exact = [replayed("L0", case) for case in exact_cases(precision)]
    return [*exact, replayed("L3", null_case(precision))]


def _frames(precision: Precision, names: frozenset[str]) -> list[Probe]:
    if "shift" not in names:
        return []
    return [replayed("L3", shift_case(place, precision)) for place in PLACES]


PART = Part(
    title="shifts of paths",
    passes=SHIFT_PASSES,
    judges={
        "joinable": judge_joinable,
        "path_jacobian": judge_jacobian,
        "shift": judge_shift,
    },
    own=OWN,
    probes=_probes,
    hypotheses=SHIFT_MISTAKES,
    frames=_frames,
)
