"""Cases of reuse: tables made here, without a scene, always the same."""

from typing import Any

import numpy as np
from numpy.random import Generator

from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value

ROWS, SLOTS = 384, 4
WEIGHTS = ("1/M", "1/Z", "balance", "pairwise", "defensive")
EMPTY, NULL, LOST, STRANGE = 0.1, 0.25, 0.2, 0.3
"""Shares of slots without source, of sources without sample, of shifts that fail, and
of samples that another source could not have made."""


def table_cases(precision: Precision) -> list[Case]:
    """Cases of all weights, with the extremes.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given: numbers that float32 holds.
    """
    rng = np.random.default_rng(2029)
    found = []
    for mis in WEIGHTS:
        for canonical in (0, SLOTS - 1):
            cap = 500.0 if canonical == 0 else 20.0
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
        for word, scale in (("dim", 1e-12), ("bright", 1e12)):
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
    """Of targets around ``scale``, and weights around its inverse."""
    shape = (ROWS, SLOTS)

    def spread(*more: int) -> Any:
        return 10.0 ** rng.normal(0, 0.7, (*shape, *more))

    there = rng.random(shape) > EMPTY
    there[:, canonical] = True
    full = there & (rng.random(shape) > NULL)
    arrives = full & (rng.random(shape) > LOST)
    arrives[:, canonical] = full[:, canonical]
    base = np.where(full, scale * spread(), 0.0)
    here = np.where(arrives, scale * spread(), 0.0)
    jacobian = np.where(arrives, spread(), 0.0)
    here[:, canonical], jacobian[:, canonical] = base[:, canonical], 1.0
    known = rng.random((*shape, SLOTS)) > STRANGE
    at_others = np.where(known & arrives[:, :, None], scale * spread(SLOTS), 0.0)
    return {
        "W": np.where(full, spread() / scale, 0.0),
        "M": rng.integers(1, 25, shape).astype(float),
        "there": there.astype(np.uint32),
        "target_base": base,
        "target_here": here,
        "jacobian": jacobian,
        "target_at": at_others,
        "u": rng.random(shape),
    }


def _alone(tables: dict[str, Any], canonical: int) -> dict[str, Any]:
    """No source at all, sources of which none has a sample, and a null of one's own."""
    there, W = tables["there"].copy(), tables["W"].copy()
    others = np.arange(SLOTS) != canonical
    there[0::3, others] = 0
    W[1::3, others] = 0.0
    W[2::3, canonical] = 0.0
    return tables | {"there": there, "W": W}
