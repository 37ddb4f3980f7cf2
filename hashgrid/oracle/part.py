"""The hash grid as a part of the contract."""

from restir_gi.hashgrid.oracle.cases import cases_of_edges, hash_grid_cases
from restir_gi.hashgrid.oracle.contract import HASH_GRID_PASSES
from restir_gi.hashgrid.oracle.exact import drawn_light_probes
from restir_gi.hashgrid.oracle.light_replay import LIGHT_JUDGES
from restir_gi.hashgrid.oracle.mistakes import HASH_GRID_MISTAKES
from restir_gi.hashgrid.oracle.own import HASH_GRID_OWN
from restir_gi.hashgrid.oracle.replay import GRID_JUDGES
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import SEED, Part


def _probes(precision: Precision, seed: int = SEED) -> list[Probe]:
    tables = [replayed("L0", case) for case in hash_grid_cases(precision, seed)]
    return [*tables, *drawn_light_probes(precision)]


def _more(precision: Precision, seed: int = SEED) -> list[Probe]:
    return [replayed("L0", case) for case in cases_of_edges(precision, seed)]


PART = Part(
    title="hash grid",
    passes=HASH_GRID_PASSES,
    judges={**GRID_JUDGES, **LIGHT_JUDGES},
    own=HASH_GRID_OWN,
    probes=_probes,
    hypotheses=HASH_GRID_MISTAKES,
    more=_more,
)
