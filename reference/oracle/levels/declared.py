"""Cases of settings that have to be declared, but for surfaces and weights."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.passes import ASKED, VISIBILITY
from restir_gi.reference.oracle.levels.exact import examined_exactly
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.kernels import shade_case
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.parts import SEED

SEEN = 0.6
"""Share of the samples that are seen."""


# The same cases for every backend, so that their exact numbers are calculated once.
@lru_cache(maxsize=4)
def declared_kernel_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L0: shading that asks what the visible point sees.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2039, seed])
    case = shaded_if_seen(shade_case(rng, precision), rng)
    return (Probe("L0", graded(case), examined_exactly),)


def shaded_if_seen(case: Case, rng: np.random.Generator) -> Case:
    """A case of pass ``shade`` in which it is asked what the visible points see."""
    seen = (rng.random(case.rows) < SEEN).astype(np.uint32)
    return replace(
        case,
        name=f"{case.name}-if-seen",
        settings={**case.settings, VISIBILITY.name: ASKED},
        inputs={**case.inputs, "visible": seen},
    )
