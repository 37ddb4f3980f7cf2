"""Cases of settings that have to be declared, but for surfaces and weights."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.contract.passes import (
    ASKED,
    BORDER,
    CLAMPED,
    DISK,
    MIRRORED,
    REFUSED,
    SEARCH,
    TABLE,
    VISIBILITY,
)
from restir_gi.reference.oracle.levels.exact import examined_exactly
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.kernels import shade_case
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import image_case, in_float32
from restir_gi.reference.oracle.parts import SEED

SEEN, FAR = 0.6, 0.05
"""Shares of the samples that are seen, and of offsets that lead far away."""

COUNT = 5
"""Neighbours of each pixel."""


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


@lru_cache(maxsize=4)
def declared_row_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L3: neighbours of tables, and beyond the border.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2040, seed])
    cases = [_searched(rng, *about) for about in SEARCHES]
    return tuple(replayed("L3", in_float32(case, precision)) for case in cases)


# Size of the image, and of its patches; search and border; and how far offsets reach.
SEARCHES: tuple[tuple[tuple[int, int], int, str, str, int], ...] = (
    ((64, 24), 6, TABLE, REFUSED, 12),
    ((27, 19), 4, TABLE, CLAMPED, 30),
    ((64, 24), 6, TABLE, MIRRORED, 12),
    ((201, 1), 3, TABLE, MIRRORED, 5),
    ((27, 19), 4, DISK, CLAMPED, 0),
    ((64, 24), 6, DISK, MIRRORED, 0),
)


def _searched(
    rng: np.random.Generator,
    size: tuple[int, int],
    patch: int,
    search: str,
    border: str,
    reach: int,
) -> Case:
    """Case of pass ``neighbors`` with declared settings; others are left out."""
    settings: dict[str, Value] = {"max_angle": 40.0, "max_depth": 0.2}
    if search == DISK:
        settings |= {"radius": 0.3, "min_radius": 1.5}
    asked = {SEARCH: search, BORDER: border}
    settings |= {s.name: word for s, word in asked.items() if word != s.default}
    case = image_case(rng, f"{search}-{border}", size, COUNT, patch, settings)
    if search == DISK:
        return case
    inputs = {name: a for name, a in case.inputs.items() if name != "u"}
    # Some are further away than the image is wide: no reflection brings them back.
    far = rng.random((case.rows, COUNT, 1)) < FAR
    offsets = rng.integers(-reach, reach + 1, (case.rows, COUNT, 2))
    inputs["offsets"] = np.where(far, offsets * 2 * max(size), offsets)
    return replace(case, name=f"{case.name}-{size[0]}", inputs=inputs)


def shaded_if_seen(case: Case, rng: np.random.Generator) -> Case:
    """A case of pass ``shade`` in which it is asked what the visible points see."""
    seen = (rng.random(case.rows) < SEEN).astype(np.uint32)
    return replace(
        case,
        name=f"{case.name}-if-seen",
        settings={**case.settings, VISIBILITY.name: ASKED},
        inputs={**case.inputs, "visible": seen},
    )
