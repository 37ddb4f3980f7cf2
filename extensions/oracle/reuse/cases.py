"""Cases of reuse: tables made here, without a scene, the same for a seed."""

from typing import Any

import numpy as np
from numpy.random import Generator

from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.draws import ends_of_u
from restir_gi.reference.oracle.parts import SEED

ROWS, SLOTS = 384, 4
WEIGHTS = ("1/M", "1/Z", "balance", "pairwise", "defensive")
EMPTY, NULL, LOST, STRANGE = 0.1, 0.25, 0.2, 0.3
"""Shares of slots without source and of sources with M = 0, of sources without sample,
of shifts that fail, and of samples that another source could not have made."""


def table_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases of all weights, with the extremes.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given: numbers that float32 holds.
    seed : int; of all tables
    """
    rng = np.random.default_rng([2029, seed])
    found = []
    for mis in WEIGHTS:
        for canonical in (0, SLOTS - 1):
            cap = 40.0 if canonical == 0 else 20.0
            settings: dict[str, Value] = {
                "mis": mis,
                "canonical": canonical,
                "cap": cap,
            }
            name = f"path-reuse-{mis.replace('/', '-over-')}-{canonical}"
            tables = _tables(rng, canonical, 1.0)
            found.append(_case(name, settings, tables, precision, random=True))
        settings = {"mis": mis, "canonical": 1, "cap": 3.0}
        name = f"path-reuse-{mis.replace('/', '-over-')}"
        for word, scale in (("dim", 1e-5), ("bright", 1e5)):
            tables = _tables(rng, 1, scale)
            found.append(_case(f"{name}-{word}", settings, tables, precision, True))
        alone = _alone(_tables(rng, 1, 1.0), 1)
        found.append(_case(f"{name}-alone", settings, alone, precision, False))
    return found


def _case(
    name: str,
    settings: dict[str, Value],
    inputs: dict[str, Any],
    precision: Precision,
    random: bool,
) -> Case:
    held = {
        n: v.astype(np.float32) if v.dtype.kind == "f" else v for n, v in inputs.items()
    }
    return Case(
        name,
        "path_reuse",
        settings=settings,
        inputs=given(held, precision),
        random=random,
    )


def _tables(rng: Generator, canonical: int, scale: float) -> dict[str, Any]:
    """Of targets around ``scale``."""
    shape = (ROWS, SLOTS)

    def spread(*more: int) -> Any:
        return 10.0 ** rng.normal(0, 0.7, (*shape, *more))

    there = rng.random(shape) > EMPTY
    there[:, canonical] = True
    empty = rng.random(shape) < EMPTY
    empty[:, canonical] = False
    full = there & ~empty & (rng.random(shape) > NULL)
    arrives = full & (rng.random(shape) > LOST)
    arrives[:, canonical] = full[:, canonical]
    base = np.where(full, scale * spread(), 0.0)
    here = np.where(arrives, scale * spread(), 0.0)
    jacobian = np.where(arrives, spread(), 0.0)
    here[:, canonical], jacobian[:, canonical] = base[:, canonical], 1.0
    known = rng.random((*shape, SLOTS)) > STRANGE
    at_others = np.where(known & arrives[:, :, None], scale * spread(SLOTS), 0.0)
    return {
        "W": np.where(full, spread(), 0.0),
        "M": np.where(empty, 0.0, rng.integers(1, 25, shape)),
        "there": there.astype(np.uint32),
        "target_base": base,
        "target_here": here,
        "jacobian": jacobian,
        "target_at": at_others,
        "u": ends_of_u(rng, ROWS * SLOTS).reshape(shape),
    }


def _alone(tables: dict[str, Any], canonical: int) -> dict[str, Any]:
    """No source at all, sources of which none has a sample, and a null of one's own."""
    there, W = tables["there"].copy(), tables["W"].copy()
    others = np.arange(SLOTS) != canonical
    there[0::3, others] = 0
    W[1::3, others] = 0.0
    W[2::3, canonical] = 0.0
    return tables | {"there": there, "W": W}
