"""Two grades: what is wrong within the working range, and what is wrong beyond it."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.working_range import beyond_range, where_beyond

PLACES = {"float32": 9, "float64": 17}
"""Decimals that tell any two numbers of a type apart."""


def graded(case: Case) -> Case:
    """A case with its rows beyond the working range, by what its inputs are."""
    one = whole_contract()[case.pass_name]
    return replace(case, beyond=beyond_range(one, dict(case.inputs)))


def told_at_extremes(
    case: Case, judgement: Judgement, wrong: Masks, precision: Precision
) -> str:
    """What is wrong beyond the working range, in one line; empty where nothing is.

    Parameters
    ----------
    wrong : (N,) bool; rows beyond the range that no rounding explains
    """
    if not wrong.any() or case.beyond is None:
        return ""
    # Some rows are not looked at for other reasons than their numbers.
    out = beyond_range(whole_contract()[case.pass_name], dict(case.inputs))
    seen = _sees_a_point(case) & (False if out is None else out)
    wrong = wrong & seen
    if not wrong.any():
        return ""
    what, row = differing(judgement, wrong, precision)
    where = where_beyond(whole_contract()[case.pass_name], dict(case.inputs), row)
    return (
        f"{case.name}: at extremes alone: {what} where {where}, {int(wrong.sum())} of"
        f" {int((case.beyond & seen).sum())} such rows"
    )


def _sees_a_point(case: Case) -> Masks:
    """Rows whose pixel sees a surface: what others hold is shaded by nobody."""
    normal = case.inputs.get("visible_normal")
    if normal is None:
        return np.ones(case.rows, bool)
    seen: Masks = np.any(normal != 0, axis=-1)
    return seen


def differing(
    judgement: Judgement, wrong: Masks, precision: Precision
) -> tuple[str, int]:
    """What is wrong in the worst of some rows, and in which.

    Parameters
    ----------
    wrong : (N,) bool; rows to choose from, one at least
    """
    decisions = judgement.decisions
    if decisions is not None and (decisions.illegal & wrong).any():
        row = int(np.flatnonzero(decisions.illegal & wrong)[0])
        what = f"{decisions.what} differs from the exact rule by more than rounding"
        return f"{what} explains", row
    excess = [np.where(wrong, c.excess, 0.0) for c in judgement.compared]
    worst = int(np.argmax([e.max() for e in excess]))
    row, compared = int(excess[worst].argmax()), judgement.compared[worst]
    found, expected = (np.ravel(a[row]) for a in (compared.found, compared.expected))
    column = int(np.abs(found.astype(np.float64) - expected).argmax())
    places = PLACES[precision]
    return (
        f"{compared.name} is {found[column]:.{places}g} instead of"
        f" {expected[column]:.{places}g}",
        row,
    )
