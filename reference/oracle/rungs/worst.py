"""Cases of L0 on which the project's own kernels were worst, found by search."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.exactness.worst import worst_inputs
from reference.oracle.cases import Case
from reference.oracle.contract.fields import Precision, Value

# Kernel, pass, settings, and what the pass wants beside the kernel's inputs.
_ASKED: tuple[tuple[str, str, dict[str, Value], tuple[str, ...]], ...] = (
    ("jacobian", "jacobian", {}, ()),
    ("target, scattered", "target", {"target": "scattered"}, ()),
    ("target, outgoing", "target", {"target": "outgoing"}, ()),
    ("integrand", "shade", {}, ("W",)),
    ("which of two is kept", "merge", {}, ("M_a", "M_b")),
    ("closing: W", "finalize", {}, ()),
)


def worst_cases(precision: Precision) -> list[Case]:
    """One case for each kernel that a pass of the contract is.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        Of the backend: the rows that were found in that type.

    Returns
    -------
    list of Case
        Of few rows each; numbers that the kernel does not look at are 1.
    """
    return [
        Case(
            f"kernel-worst-{pass_name}" + "".join(f"-{v}" for v in settings.values()),
            pass_name,
            settings,
            _with_ones(dict(worst_inputs(name, precision)), ones),
        )
        for name, pass_name, settings, ones in _ASKED
    ]


def _with_ones(
    inputs: dict[str, NDArray[Any]], names: tuple[str, ...]
) -> dict[str, NDArray[Any]]:
    first = next(iter(inputs.values()))
    return inputs | {name: np.ones(len(first), first.dtype) for name in names}
