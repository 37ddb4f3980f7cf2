"""Where a pass is wrong most: its case, and the rows of that."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.oracle.replay.typical import excess_of
from restir_gi.reference.oracle.verdict import Verdict


def answers_of(verdict: Verdict, pass_name: str) -> list[Answer]:
    """Answers of a pass that show something, each with a finding.

    In the order of the ladder.
    """
    return [
        answer
        for timed in verdict.steps
        for answer in timed.step.answers
        if answer.finding is not None and answer.probe.case.pass_name == pass_name
    ]


def worst_answer(answers: list[Answer]) -> Answer | None:
    """The wrong replay with the most wrong rows.

    Has a judgement; ``None`` where no replay is wrong: a backend may have crashed, or
    only an expectation may be off.
    """
    wrong = [a for a in answers if _judgement(a) and a.finding and not a.finding.passed]
    return max(wrong, key=lambda answer: _badness(_sure(answer)), default=None)


def worst_rows(judgement: Judgement, most: int) -> Indices:
    """Rows that are wrong most.

    Parameters
    ----------
    judgement : Judgement; of N rows
    most : int; no more rows than that

    Returns
    -------
    (R,) int
        The worst first; where all rows are right but too many decisions differ, those
        that are.
    """
    rows = np.flatnonzero(judgement.wrong)
    if not rows.size:
        rows = np.flatnonzero(other_decisions(judgement))
    excess = np.max([excess_of(c) for c in judgement.compared], axis=0)
    differences = np.max([_relative(c) for c in judgement.compared], axis=0)
    order = np.lexsort((rows, -differences[rows], -excess[rows]))
    worst: Indices = rows[order[:most]]
    return worst


def other_decisions(judgement: Judgement) -> Masks:
    """Rows that kept another slot than exact arithmetic does.

    Returns (N,) bool; all false for a pass that keeps no slots.
    """
    terms = judgement.terms
    if not {"kept slot", "slot in exact arithmetic"} <= set(terms):
        return np.zeros(len(judgement.compared[0].found), bool)
    differs: Masks = terms["kept slot"] != terms["slot in exact arithmetic"]
    return differs


def _judgement(answer: Answer) -> Judgement | None:
    return answer.finding.judgement if answer.finding else None


def _sure(answer: Answer) -> Judgement:
    judgement = _judgement(answer)
    assert judgement is not None
    return judgement


def _badness(judgement: Judgement) -> tuple[int, float]:
    largest = max(float(excess_of(c).max(initial=0.0)) for c in judgement.compared)
    return int(judgement.wrong.sum()), largest


def _relative(compared: Compared) -> Scalars:
    """(N,): difference over the size, where anything less than infinity was allowed."""
    found = compared.found.astype(np.float64)
    bound = np.isfinite(compared.allowed)
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.maximum(np.abs(found), np.abs(compared.expected))
        ratio = np.abs(found - compared.expected) / np.where(size > 0, size, 1.0)
    known = np.where(bound & ~np.isnan(ratio), ratio, 0.0).reshape(len(found), -1)
    largest: Scalars = known.max(axis=1, initial=0.0)
    return largest
