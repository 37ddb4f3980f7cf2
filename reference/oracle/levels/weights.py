"""Cases of declared MIS weights: designed rows of L3.

Each declared value is asked of each pass that has it, with both targets, and once with
as many neighbours as there may be; and, of those who declare both, on a declared
surface.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.random import Generator

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.surfaces import GGX
from restir_gi.reference.oracle.contract.weights import MIS, MIS_AT_REST
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import (
    FEW_NEIGHBORS,
    MOST_NEIGHBORS,
    fused_rows,
    in_float32,
    moved_rows,
    spatial_rows,
    temporal_rows,
)
from restir_gi.reference.oracle.levels.surfaces import scattered, with_materials
from restir_gi.reference.oracle.parts import SEED


# The same cases for every backend.
@lru_cache(maxsize=4)
def weight_row_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L3: designed rows of each declared weight.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2039, seed])
    return tuple(replayed("L3", in_float32(case, precision)) for case in _cases(rng))


def _cases(rng: Generator) -> Iterator[Case]:
    for mis in MIS_AT_REST.more:
        yield temporal_rows(rng, "scattered", 20.0, mis)
        yield temporal_rows(rng, "outgoing", 5.5, mis)
    for mis in MIS.more:
        yield moved_rows(rng, "scattered", 20.0, mis)
        yield moved_rows(rng, "outgoing", 7.25, mis)
        yield spatial_rows(rng, "scattered", 40.0, mis, FEW_NEIGHBORS)
        yield spatial_rows(rng, "outgoing", 12.0, mis, FEW_NEIGHBORS)
        yield spatial_rows(rng, "scattered", 60.0, mis, MOST_NEIGHBORS)
        yield fused_rows(rng, "scattered", 40.0, mis, FEW_NEIGHBORS)
        yield fused_rows(rng, "outgoing", 12.0, mis, FEW_NEIGHBORS)
        for case in (
            moved_rows(rng, "outgoing", 20.0, mis),
            spatial_rows(rng, "outgoing", 40.0, mis, FEW_NEIGHBORS),
            fused_rows(rng, "outgoing", 40.0, mis, FEW_NEIGHBORS),
        ):
            yield with_materials(rng, scattered(case), GGX)
