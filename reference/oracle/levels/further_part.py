"""The further passes as a part of the contract."""

from restir_gi.reference.oracle.builtin.further import FURTHER
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.further import FURTHER_PASSES
from restir_gi.reference.oracle.diagnosis.further import FURTHER_MISTAKES
from restir_gi.reference.oracle.levels.further import declared_cases, further_cases
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import SEED, Part
from restir_gi.reference.oracle.replay.further.judges import FURTHER_JUDGES


def _probes(precision: Precision, seed: int = SEED) -> list[Probe]:
    return [replayed("L0", case) for case in further_cases(precision, seed)]


def _more(precision: Precision, seed: int = SEED) -> list[Probe]:
    return [replayed("L0", case) for case in declared_cases(precision, seed)]


FURTHER_PART = Part(
    title="further passes",
    passes=FURTHER_PASSES,
    judges=FURTHER_JUDGES,
    own=FURTHER,
    probes=_probes,
    hypotheses=FURTHER_MISTAKES,
    more=_more,
)
