"""A kernel's results beside exact numbers."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel
from restir_gi.reference.oracle.exact.numbers import (
    EXACT,
    Exact,
    Type,
    UndecidedError,
    exactly,
)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Rows of a kernel beside exact numbers.

    Attributes
    ----------
    ulp : (N,) float64
        Distance to the exact number, in units in its last place; the largest of the
        components.  0 for rows that are not judged, infinite for what is not finite.
    share : (N,) float64
        The same distance as a share of what rounding explains: it passes up to 1.
    open : (N,) bool
        Rows that rounding leaves open, or that are beyond the type: finite, no more.
    """

    ulp: Scalars
    share: Scalars
    open: Masks


def judge(kernel: Kernel, inputs: Inputs, found: NDArray[Any], type_: Type) -> Judged:
    """Hold results against exact numbers.

    Parameters
    ----------
    found : (N,) or (N, k) array; what it said
    """
    rows = len(found)
    ulp, share, open_rows = np.zeros(rows), np.zeros(rows), np.zeros(rows, bool)
    for row in range(rows):
        given = {name: exactly(a[row], type_) for name, a in inputs.items()}
        try:
            said = kernel.formula(given)
        except UndecidedError:
            open_rows[row] = True
            ulp[row] = share[row] = 0.0 if np.isfinite(found[row]).all() else np.inf
            continue
        wanted = said if isinstance(said, tuple) else (said,)
        got = np.atleast_1d(found[row])
        each = [_beside(kernel, a, b) for a, b in zip(got, wanted, strict=True)]
        ulp[row], share[row] = (max(column[k] for column in each) for k in (0, 1))
        open_rows[row] = any(e[2] for e in each)
    return Judged(ulp, share, open_rows)


def _beside(kernel: Kernel, got: Any, wanted: Any) -> tuple[float, float, bool]:
    """Error in ulp, as a share of the bound, and whether the row is open."""
    if isinstance(wanted, bool):
        wrong = 0.0 if bool(got) == wanted else np.inf
        return wrong, wrong, False
    if not np.isfinite(got):
        return np.inf, np.inf, False
    surely_beyond = wanted.type.most * (1 + 8 * wanted.type.unit)
    if kernel.saturates and wanted.value > surely_beyond:
        wrong = 0.0 if float(got) == float(wanted.type.most) else np.inf
        return wrong, wrong, False
    if EXACT.isinf(wanted.error):
        return 0.0, 0.0, True
    off = abs(EXACT.mpf(float(got)) - wanted.value)
    if off == 0:
        return 0.0, 0.0, False
    share = float(off / wanted.error) if wanted.error > 0 else np.inf
    return float(off / _last_place(wanted)), share, False


def _last_place(number: Exact) -> Any:
    """Distance of a number to the next larger one of its type."""
    if number.value == 0:
        return number.type.least
    power = EXACT.frexp(abs(number.value))[1] - 1
    return max(EXACT.ldexp(2 * number.type.unit, power), number.type.least)
