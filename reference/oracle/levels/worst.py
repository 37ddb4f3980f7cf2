"""Cases of L0 on which the project's own kernels were worst, found by search."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.exact.kernel import Inputs
from restir_gi.reference.oracle.exact.worst import worst_inputs

LEAST: Mapping[Precision, float] = {"float32": 2.0**-30, "float64": 2.0**-240}
"""Four factors of this size, or of its inverse, stay within the type: beyond, backends
may order their operations so that one overflows and another does not."""

# Kernel, pass, settings, and what the pass wants beside the kernel's inputs.
_ASKED: tuple[tuple[str, str, dict[str, Value], tuple[str, ...]], ...] = (
    ("jacobian", "jacobian", {}, ()),
    ("target, scattered", "target", {"target": "scattered"}, ()),
    ("target, outgoing", "target", {"target": "outgoing"}, ()),
    ("integrand", "shade", {}, ("W",)),
    ("closing: W", "finalize", {}, ()),
)


def worst_cases(precision: Precision) -> list[Case]:
    """One case of few rows for each kernel that a pass of the contract is.

    Numbers that the kernel does not look at are 1.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        Of the backend: the rows that were found in that type.
    """
    return [
        Case(
            f"kernel-worst-{pass_name}" + "".join(f"-{v}" for v in settings.values()),
            pass_name,
            settings,
            _with_ones(
                _within_reach(worst_inputs(name, precision), LEAST[precision]), ones
            ),
        )
        for name, pass_name, settings, ones in _ASKED
    ]


def _within_reach(inputs: Inputs, least: float) -> dict[str, NDArray[Any]]:
    """Rows whose products stay within the type."""
    sizes = [abs(a).reshape(len(a), -1).astype(np.float64) for a in inputs.values()]
    size = np.concatenate(sizes, axis=1)
    kept = ((size == 0) | ((size > least) & (size < 1 / least))).all(axis=1)
    return {name: a[kept] for name, a in inputs.items()}


def _with_ones(
    inputs: dict[str, NDArray[Any]], names: tuple[str, ...]
) -> dict[str, NDArray[Any]]:
    first = next(iter(inputs.values()))
    return inputs | {name: np.ones(len(first), first.dtype) for name in names}
