"""Cases of targets that are given as data: designed rows of L3.

The points, samples and reservoirs are those of other rows; the target is that of a
glossy surface that the contract has no formula for.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.given_targets import glossy, with_given_targets
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import (
    FEW_NEIGHBORS,
    fused_rows,
    in_float32,
    initial_rows,
    moved_rows,
    size_of,
    spatial_rows,
    temporal_rows,
)
from restir_gi.reference.oracle.parts import SEED


# The same cases for every backend.
@lru_cache(maxsize=4)
def given_target_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L3: designed rows of each pass that has targets as data.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2041, seed])
    cases = [initial_rows(rng, "outgoing"), temporal_rows(rng, "outgoing", 20.0)]
    for mis in ("1/Z", "1/M", *MIS.more):
        cases.append(moved_rows(rng, "outgoing", 20.0, mis))
        cases.append(spatial_rows(rng, "outgoing", 40.0, mis, FEW_NEIGHBORS))
        cases.append(fused_rows(rng, "outgoing", 40.0, mis, FEW_NEIGHBORS))
    cases.append(spatial_rows(rng, "outgoing", 60.0, "1/Z", size_of(30)))
    return tuple(
        replayed("L3", with_given_targets(in_float32(_named(case), precision), glossy))
        for case in cases
    )


def _named(case: Case) -> Case:
    """A case under a name that says where its targets are from."""
    return replace(case, name=case.name.replace("outgoing", DATA))
