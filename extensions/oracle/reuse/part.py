"""Reuse of whole samples as a part of the contract."""

from extensions.oracle.reuse.cases import table_cases
from extensions.oracle.reuse.lattice import lattice_probes
from extensions.oracle.reuse.mistakes import REUSE_MISTAKES
from extensions.oracle.reuse.own import OWN
from extensions.oracle.reuse.passes import PATH_REUSE
from extensions.oracle.reuse.replay import judge_path_reuse
from reference.oracle.contract.fields import Precision
from reference.oracle.levels.probe import Probe
from reference.oracle.levels.replayed import replayed
from reference.oracle.parts import Part


def _probes(precision: Precision) -> list[Probe]:
    tables = [replayed("L0", case) for case in table_cases(precision)]
    return [*tables, *lattice_probes(precision)]


PART = Part(
    title="reuse of samples",
    passes=(PATH_REUSE,),
    judges={"path_reuse": judge_path_reuse},
    own=OWN,
    probes=_probes,
    hypotheses=REUSE_MISTAKES,
)
