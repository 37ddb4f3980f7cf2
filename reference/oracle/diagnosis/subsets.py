"""Some rows of a case, as a case of their own."""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.parts import judge_of
from restir_gi.reference.oracle.replay.blocks import rows_of
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.replay.mis import UNBIASED
from restir_gi.reference.oracle.replay.rules import Rules


@dataclass(frozen=True, slots=True, eq=False)
class AskedRows:
    """A case, what a backend gave for it, and the rows that are looked at.

    Attributes
    ----------
    rows : (N,) bool; of the case
    """

    case: Case
    outputs: Buffers
    rows: Masks


def whole(case: Case, outputs: Buffers) -> AskedRows:
    """All rows of a case within the working range."""
    everyone = np.ones(case.rows, bool)
    return AskedRows(case, outputs, everyone if case.beyond is None else ~case.beyond)


def some_rows(asked: AskedRows, rows: Indices) -> AskedRows:
    """Some rows of a case of a pass in `BY_ROW`.

    Parameters
    ----------
    rows : (K,) int
    """
    outputs = {name: np.asarray(a)[rows] for name, a in asked.outputs.items()}
    cut = replace(rows_of(asked.case, rows), random=False, beyond=None)
    return AskedRows(cut, outputs, asked.rows[rows])


def judged(
    asked: AskedRows, rules: Rules, precision: Precision
) -> tuple[Judgement, Masks]:
    """Judgement under some rules, and the rows that are right, (N,) bool.

    Where 1/M is asked for, a backend with weights of its own may have them or 1/M, and
    a sample that its own maker does not see says nothing of them: nobody makes it.
    """
    judge = judge_of(asked.case.pass_name)
    found = judge(asked.case, asked.outputs, rules, precision)
    right = ~found.wrong
    if rules.normalization in UNBIASED and asked.case.settings.get("mis") == "1/M":
        right |= _never_made(asked.case)
        as_asked = replace(rules, normalization="asked", mis_jacobian=True)
        other = judge(asked.case, asked.outputs, as_asked, precision)
        if _right(other, asked) > _right(found, asked):
            return other, ~other.wrong
    return found, right


def _never_made(case: Case) -> Masks:
    """Rows whose past does not see the sample that it holds."""
    if case.pass_name != "moved":
        return np.zeros(case.rows, bool)
    sees = np.asarray(case.inputs["visible"])[:, 1] >> np.uint32(1)
    return np.asarray(sees & np.uint32(1) == 0)


def _right(judgement: Judgement, asked: AskedRows) -> int:
    """Numbers that are right, of all outputs, and rows that are."""
    numbers = sum(int((c.excess <= 1)[asked.rows].sum()) for c in judgement.compared)
    return numbers + int((~judgement.wrong & asked.rows).sum())


def explained(asked: AskedRows, rules: Rules, precision: Precision) -> bool:
    """Whether rules reproduce all the rows that are looked at."""
    judgement, right = judged(asked, rules, precision)
    return bool(right[asked.rows].all()) and not judgement.over_budget
