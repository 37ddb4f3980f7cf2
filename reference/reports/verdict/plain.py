"""A verdict for programs: text, numbers, lists and dicts alone."""

from typing import Any

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Passes
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.verdict import Timed, Verdict, departs, explicable
from restir_gi.reference.reports.verdict.rows import as_number, worst_case
from restir_gi.reference.reports.verdict.worst import (
    answers_of,
    excess_of,
    worst_answer,
)

DOCUMENTATION = ""
"""Address of the documentation, with its last slash; empty where it has none."""


def as_plain(verdict: Verdict, name: str, passes: Passes) -> dict[str, Any]:
    """A verdict for programs.

    JSON can hold it; numbers that are not finite are ``None``.

    Parameters
    ----------
    verdict : Verdict; as far as the ladder was run
    """
    told = [_pass(verdict, pass_name) for pass_name in passes]
    wrong = [p["name"] for p in told if p["status"] == "wrong"]
    return {
        "status": verdict.status,
        "backend": name,
        "headline": _headline(verdict, told),
        "steps": [_step(timed) for timed in verdict.steps],
        "certified": as_number(verdict.certified),
        "left": list(verdict.left),
        "absent": list(verdict.absent),
        "left_running": verdict.left_running,
        "first_wrong_pass": wrong[0] if wrong else None,
        "passes": told,
    }


def _headline(verdict: Verdict, told: list[dict[str, Any]]) -> str:
    def of(status: str) -> list[str]:
        return [p["name"] for p in told if p["status"] == status]

    right, wrong, departed = of("right"), of("wrong"), of("departs")
    if verdict.status == "PASS":
        text = f"all that was asked is right to rounding, in {_count(right)}"
        if departed:
            text += f"; no bias comes of the others: {', '.join(departed)}"
        bound = verdict.certified
        return text if bound is None else f"{text}; bias of the mean ≤ {bound:.2%}"
    if wrong:
        return f"{_count(wrong)} wrong, begin with {wrong[0]}"
    if verdict.status == "FAIL":
        return "no single pass is wrong, but all of them together are"
    if not right and not any(timed.step.findings for timed in verdict.steps):
        return "nothing was judged"
    if verdict.unasked:
        calls = _count(verdict.unasked, "call", "calls")
        return f"nothing is wrong so far, {calls} had no time or were cut short"
    if verdict.left:
        late = _count(verdict.left, "step", "steps")
        return f"nothing is wrong so far, {late} had no time"
    return "nothing is wrong so far, but more time is wanted"


def _count(names: list[str], one: str = "pass", many: str = "passes") -> str:
    return f"{len(names)} {one if len(names) == 1 else many}"


def _step(timed: Timed) -> dict[str, Any]:
    step = timed.step
    wrong = [a for a in step.answers if a.finding and not a.finding.passed]
    return {
        "rung": step.level,
        "title": step.title,
        "seconds": float(timed.seconds),
        "asked": len(step.answers) + len(step.findings),
        "unanswered": sum(a.finding is None for a in step.answers),
        "failed": len(step.faults),
        "wrong_passes": list(dict.fromkeys(a.probe.case.pass_name for a in wrong)),
        "faults": step.faults,
        "certified": as_number(step.certified),
        "more": step.more,
        "unasked": list(step.unasked),
    }


def _pass(verdict: Verdict, pass_name: str) -> dict[str, Any]:
    answers = answers_of(verdict, pass_name)
    faults = [a.finding.text for a in answers if a.finding and not a.finding.passed]
    judged = [
        (a.probe.case, a.finding.judgement)
        for a in answers
        if a.finding and a.finding.judgement
    ]
    worst = worst_answer(answers)
    matches = [d for d in verdict.diagnoses if d.pass_name == pass_name]
    return {
        "name": pass_name,
        "status": _status(matches, answers),
        "fault": faults[0] if faults else None,
        "faults": faults,
        "cases": len(answers),
        "wrong_rows": sum(int(judgement.wrong.sum()) for _, judgement in judged),
        "rows": sum(case.rows for case, _ in judged),
        "excess": _largest([judgement for _, judgement in judged]),
        "excuses": _rounding_budget(judged),
        "worst": worst_case(worst) if worst else None,
        "conclusion": _conclusion(matches, worst) if faults else None,
        "diagnosis": [entry for diagnosis in matches for entry in _named(diagnosis)],
    }


def _status(matches: list[Diagnosis], answers: list[Answer]) -> str:
    wrong = [a for a in answers if a.finding and not a.finding.passed]
    if not wrong:
        return "right" if answers else "not judged"
    if any(map(departs, matches)) and all(map(explicable, wrong)):
        return "departs"
    return "wrong"


def _largest(judgements: list[Judgement]) -> dict[str, float | None]:
    most: dict[str, float] = {}
    for compared in (c for judgement in judgements for c in judgement.compared):
        excess = float(excess_of(compared).max(initial=0.0))
        most[compared.name] = max(excess, most.get(compared.name, 0.0))
    return {name: as_number(excess) for name, excess in most.items()}


def _rounding_budget(judged: list[tuple[Case, Judgement]]) -> dict[str, Any] | None:
    """Of the case that comes closest to its budget, or exceeds it most."""
    counted = [
        (case, judgement.decisions)
        for case, judgement in judged
        if judgement.counted and judgement.decisions is not None
    ]
    if not counted:
        return None
    case, most = max(counted, key=lambda pair: pair[1].differing - pair[1].budget)
    return {
        "case": case.name,
        "used": int(most.differing),
        "expected": float(most.expected),
        "budget": most.budget,
    }


def _conclusion(matches: list[Diagnosis], worst: Answer | None) -> str:
    names = [h.name for diagnosis in matches for h in diagnosis.matches]
    if not names and worst is None:
        return "no wrong answer that a replay could explain"
    if not names:
        return "no known mistake"
    return f"is{'' if len(names) == 1 else ' one of'}: {', '.join(names)}"


def _named(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    return [
        {
            "name": h.name,
            "mistake": h.mistake,
            "wrong": h.wrong,
            "right": h.right,
            "seen": list(h.seen),
            "link": f"{DOCUMENTATION}explanation/bugs.html#{h.name}",
        }
        for h in diagnosis.matches
    ]
