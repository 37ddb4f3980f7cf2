"""L3: a pass once more, from the backend's own numbers."""

from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.grades import (
    graded,
    told_at_extremes,
)
from restir_gi.reference.oracle.levels.probe import Finding, Probe
from restir_gi.reference.oracle.parts import judge_of
from restir_gi.reference.oracle.replay.judgement import BUDGET_ALARM, Judgement
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.typical import told_rows


def replayed(level: str, case: Case) -> Probe:
    """Question of a case that the replay answers.

    No false alarm, but for the budget of decisions within rounding.
    """
    return Probe(level, graded(case), examined_by_replay)


def examined_by_replay(case: Case, outputs: Buffers, precision: Precision) -> Finding:
    """Examine an answer beside the replay; rows beyond the range do not fail."""
    judgement = judge_of(case.pass_name)(case, outputs, CONTRACT_RULES, precision)
    return found_in(case, judgement, precision)


def found_in(case: Case, judgement: Judgement, precision: Precision) -> Finding:
    """What a judgement shows, in both grades."""
    wrong = judgement.wrong
    if (wrong & case.within).any() or judgement.over_budget:
        return Finding(False, f"{case.name}: {_told(case, judgement)}", judgement)
    extremes = told_at_extremes(case, judgement, wrong, precision)
    return Finding(True, judgement=judgement, at_extremes=extremes)


def _told(case: Case, judgement: Judgement) -> str:
    if not (judgement.wrong & case.within).any():
        assert judgement.decisions is not None
        return (
            f"{judgement.decisions.differing} decisions differ where rounding leaves"
            f" {judgement.decisions.expected:.3g} open; more than"
            f" {judgement.decisions.budget} have a probability below {BUDGET_ALARM:g}"
        )
    return told_rows(case, judgement)
