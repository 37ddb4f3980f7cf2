"""Reuse of whole samples as a part of the contract."""

from restir_gi.extensions.oracle.reuse.cases import table_cases
from restir_gi.extensions.oracle.reuse.lattice import lattice_probes
from restir_gi.extensions.oracle.reuse.mistakes import REUSE_MISTAKES
from restir_gi.extensions.oracle.reuse.own import OWN
from restir_gi.extensions.oracle.reuse.passes import PATH_REUSE
from restir_gi.extensions.oracle.reuse.replay import judge_path_reuse
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import SEED, Part


def _probes(precision: Precision, seed: int = SEED) -> list[Probe]:
    tables = [replayed("L0", case) for case in table_cases(precision, seed)]
    return [*tables, *lattice_probes(precision)]


PART = Part(
    title="reuse of samples",
    passes=(PATH_REUSE,),
    judges={"path_reuse": judge_path_reuse},
    own=OWN,
    probes=_probes,
    hypotheses=REUSE_MISTAKES,
)
