"""L3: a pass once more, from the backend's own numbers."""

import numpy as np

from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Finding, Probe
from restir_gi.reference.oracle.parts import judge_of
from restir_gi.reference.oracle.replay.judgement import BUDGET_ALARM, Judgement
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES


def replayed(level: str, case: Case) -> Probe:
    """Question of a case that the replay answers.

    No false alarm, but for the budget of decisions within rounding.
    """
    return Probe(level, case, _examine)


def _examine(case: Case, outputs: Buffers, precision: Precision) -> Finding:
    judgement = judge_of(case.pass_name)(case, outputs, CONTRACT_RULES, precision)
    if judgement.passed:
        return Finding(True, judgement=judgement)
    return Finding(False, f"{case.name}: {_told(case, judgement)}", judgement)


def _told(case: Case, judgement: Judgement) -> str:
    wrong = judgement.wrong
    if not wrong.any():
        assert judgement.decisions is not None
        return (
            f"{judgement.decisions.differing} decisions differ where rounding leaves"
            f" {judgement.decisions.expected:.3g} open; more than"
            f" {judgement.decisions.budget} have a probability below {BUDGET_ALARM:g}"
        )
    share = f"{int(wrong.sum())} of {case.rows} rows are wrong"
    decisions = judgement.decisions
    if decisions is not None and decisions.illegal.any():
        row = int(np.flatnonzero(decisions.illegal)[0])
        return (
            f"{share}; in {_place(case, row)} {decisions.what} differs from the exact"
            " rule by more than rounding explains"
        )
    worst = max(judgement.compared, key=lambda c: float(c.excess.max()))
    row = int(worst.excess.argmax())
    found, expected = (a[row].ravel() for a in (worst.found, worst.expected))
    column = int(np.abs(found.astype(float) - expected).argmax())
    return (
        f"{share}; in {_place(case, row)} {worst.name} is {found[column]:.9g} instead"
        f" of {expected[column]:.9g}"
    )


def _place(case: Case, row: int) -> str:
    if case.width is None:
        return f"row {row}"
    return f"pixel ({row % case.width}, {row // case.width})"
