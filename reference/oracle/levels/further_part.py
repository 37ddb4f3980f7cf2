"""The further passes as a part of the contract."""

from reference.oracle.builtin.further import FURTHER
from reference.oracle.contract.fields import Precision
from reference.oracle.contract.further import FURTHER_PASSES
from reference.oracle.diagnosis.further import FURTHER_MISTAKES
from reference.oracle.levels.further import further_cases
from reference.oracle.levels.probe import Probe
from reference.oracle.levels.replayed import replayed
from reference.oracle.parts import Part
from reference.oracle.replay.further.judges import FURTHER_JUDGES


def _probes(precision: Precision) -> list[Probe]:
    return [replayed("L0", case) for case in further_cases(precision)]


FURTHER_PART = Part(
    title="further passes",
    passes=FURTHER_PASSES,
    judges=FURTHER_JUDGES,
    own=FURTHER,
    probes=_probes,
    hypotheses=FURTHER_MISTAKES,
)
