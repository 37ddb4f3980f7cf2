"""Shifts of whole paths as a part of the contract."""

from restir_gi.extensions.oracle.shifts.cases import PLACES, null_case, shift_case
from restir_gi.extensions.oracle.shifts.criterion import judge_joinable
from restir_gi.extensions.oracle.shifts.exact_cases import exact_cases
from restir_gi.extensions.oracle.shifts.jacobian import judge_jacobian
from restir_gi.extensions.oracle.shifts.mistakes import SHIFT_MISTAKES
from restir_gi.extensions.oracle.shifts.own import OWN
from restir_gi.extensions.oracle.shifts.passes import SHIFT_PASSES
from restir_gi.extensions.oracle.shifts.replay import judge_shift
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import Part


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
