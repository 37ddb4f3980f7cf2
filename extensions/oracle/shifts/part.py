"""Shifts of whole paths as a part of the contract."""

from restir_gi.extensions.oracle.shifts.cases import (
    PLACES,
    null_case,
    shift_case,
    without_light_choice,
)
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
from restir_gi.reference.oracle.parts import SEED, Part


def _probes(precision: Precision, seed: int = SEED) -> list[Probe]:
    exact = [replayed("L0", case) for case in exact_cases(precision, seed)]
    return [*exact, replayed("L3", null_case(precision))]


def _frames(
    precision: Precision, names: frozenset[str], seed: int = SEED
) -> list[Probe]:
    if "shift" not in names:
        return []
    cases = [shift_case(place, precision, seed) for place in PLACES]
    cases += [without_light_choice(case) for case in cases[:3:2]]
    return [replayed("L3", case) for case in cases]


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
