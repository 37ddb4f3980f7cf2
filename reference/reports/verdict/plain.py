"""A verdict for programs: text, numbers, lists and dicts alone."""

import re
from collections.abc import Mapping
from typing import Any

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Passes
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis, Explanation
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis
from restir_gi.reference.oracle.levels.probe import Answer, Finding
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.replay.typical import excess_of, wrong_rows
from restir_gi.reference.oracle.verdict import (
    Timed,
    Verdict,
    departs,
    explicable,
    settles,
)
from restir_gi.reference.reports.verdict.declared import (
    biased_by_design,
    declaration_of,
    measured_of,
)
from restir_gi.reference.reports.verdict.rows import as_number, command, failing_case
from restir_gi.reference.reports.verdict.schema import VERSION
from restir_gi.reference.reports.verdict.sentences import (
    cause,
    conclusion,
    explained,
    what_is_wrong,
)
from restir_gi.reference.reports.verdict.worst import answers_of, worst_answer

MOST_FAILURES = 3
"""Calls of a pass that failed, of which the output is shown."""


def as_plain(
    verdict: Verdict,
    name: str,
    passes: Passes,
    again: str = "",
    kind: str = "passes",
    asked: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """A verdict for programs.

    JSON can hold it; numbers that are not finite are ``None``.

    Parameters
    ----------
    verdict : Verdict; as far as the ladder was run
    again : str; command of the check, to which ``--case NAME`` is added
    kind : 'passes' or 'capture'; what was judged
    asked : mapping, optional; options of the check that decide what is asked
    """
    told = [_pass(verdict, one, again) for one in passes]
    wrong = [p["name"] for p in told if p["status"] == "wrong"]
    return {
        "schema": VERSION,
        "kind": kind,
        "status": verdict.status,
        "backend": name,
        "headline": _headline(verdict, told),
        "asked": dict(asked or {}),
        "steps": [_step(timed, verdict) for timed in verdict.steps],
        "certified": as_number(verdict.certified),
        "measured": measured_of(verdict),
        "left": list(verdict.left),
        "not_asked": list(verdict.not_asked),
        "absent": list(verdict.absent),
        "missing": list(verdict.missing),
        "near": list(verdict.near),
        "at_extremes": list(verdict.at_extremes),
        "left_running": verdict.left_running,
        "declaration": declaration_of(verdict),
        "first_wrong_pass": wrong[0] if wrong else None,
        "passes": told,
        "mistakes": _mistakes(verdict),
    }


def _headline(verdict: Verdict, told: list[dict[str, Any]]) -> str:
    def of(status: str) -> list[str]:
        return [p["name"] for p in told if p["status"] == status]

    right, departed, designed = of("right"), of("departs"), of("by design")
    wrong = [p for p in told if p["status"] == "wrong"]
    if verdict.status in ("PASS", "QUICK"):
        text = f"all that was asked is right to rounding, in {_count(right)}"
        if designed and not right:
            text = "all rows are those of what is declared, to rounding"
        if departed:
            others = "" if designed else "the others: "
            text += f"; no bias comes of {others}{', '.join(departed)}"
        if verdict.biases:
            text += f"; {biased_by_design(verdict)}, which is accepted"
        if verdict.status == "QUICK":
            return f"{text}; the quick steps alone, no verdict of the whole"
        bound = verdict.certified
        return text if bound is None else f"{text}; bias of the mean ≤ {bound:.2%}"
    open_passes = [p for p in told if p["status"] == "undecided"]
    if verdict.status == "UNDECIDED" and open_passes:
        return str(open_passes[0]["sentence"])
    if wrong:
        others = ", ".join(p["name"] for p in wrong[1:])
        more = f"; also wrong: {others}" if others else ""
        return f"{wrong[0]['sentence']}{more}"
    if verdict.status == "FAIL":
        return _why_it_fails(verdict)
    if not verdict.judged and not any(timed.step.findings for timed in verdict.steps):
        return "nothing was judged"
    if verdict.unasked:
        calls = _count(verdict.unasked, "call", "calls")
        return f"nothing is wrong so far, {calls} had no time or were cut short"
    if verdict.left:
        late = _count(verdict.left, "step", "steps")
        return f"nothing is wrong so far, {late} had no time"
    return "nothing is wrong so far, but more time is wanted"


def _why_it_fails(verdict: Verdict) -> str:
    """Of a verdict without a wrong pass."""
    if verdict.missing:
        return verdict.missing[0]
    if verdict.unaccepted and not verdict.wrong:
        return f"{biased_by_design(verdict)}; {verdict.to_accept}"
    if not verdict.judged and verdict.near:
        return f"nothing was judged: {verdict.near[0]}"
    wrong = [f for step in verdict.binding for f in step.findings if not f.passed]
    if wrong and wrong[0].asked:
        told = "each pass is right by itself, and together they are wrong"
        return f"{told}: {wrong[0].text}"
    if wrong:
        return wrong[0].text
    extremes = "; ".join(verdict.at_extremes[:1])
    return f"right in the working range, and wrong at extremes: {extremes}"


def _count(names: list[str], one: str = "pass", many: str = "passes") -> str:
    return f"{len(names)} {one if len(names) == 1 else many}"


def _step(timed: Timed, verdict: Verdict) -> dict[str, Any]:
    step = timed.step
    wrong = [a for a in step.answers if a.finding and not a.finding.passed]
    names = [a.probe.case.pass_name for a in wrong]
    binds = step in verdict.binding
    if binds:
        names += [f.asked[0] for f in step.findings if _is_of_one_pass(f)]
    return {
        "rung": step.level,
        "title": step.title,
        "seconds": float(timed.seconds),
        "asked": len(step.answers) + len(step.findings),
        "unanswered": sum(a.finding is None for a in step.answers),
        "failed": len(step.faults),
        "together": [f.text for f in step.findings if binds and _is_of_several(f)],
        "wrong_passes": list(dict.fromkeys(names)),
        "faults": step.faults,
        "binds": binds,
        "void": not binds and not step.only_under,
        "certified": as_number(step.certified),
        "more": step.more,
        "unasked": list(step.unasked),
    }


def _is_of_one_pass(finding: Finding) -> bool:
    """Whether a test of several calls has failed, all of one pass of the backend."""
    return not finding.passed and len(finding.asked) == 1


def _is_of_several(finding: Finding) -> bool:
    """Whether a test has failed that is not of one pass alone."""
    return not finding.passed and len(finding.asked) != 1


def _pass(verdict: Verdict, pass_name: str, again: str) -> dict[str, Any]:
    answers = answers_of(verdict, pass_name)
    wrong = [a for a in answers if a.finding and not a.finding.passed]
    related = [
        finding.text
        for step in verdict.binding
        for finding in step.findings
        if _is_of_one_pass(finding) and finding.asked == (pass_name,)
    ]
    faults = [a.finding.text for a in wrong if a.finding] + related
    judged, failed = _judged(answers), _judged(wrong)
    rows = sum(case.rows for case, _ in judged)
    worst = worst_answer(answers)
    diagnosis = next((d for d in verdict.diagnoses if d.pass_name == pass_name), None)
    status = "wrong" if related else _status(diagnosis, answers, wrong)
    why = cause(diagnosis) if faults else ""
    what = what_is_wrong(failed, rows) or (faults[0] if faults else "")
    return {
        "name": pass_name,
        "status": status,
        "sentence": _sentence(pass_name, status, what, why) if faults else None,
        "fault": _shown_fault(wrong, faults) if faults else None,
        "faults": faults,
        "reason": _reason(diagnosis, wrong, related) if faults else None,
        "cases": len(answers),
        "wrong_rows": sum(len(wrong_rows(*pair)) for pair in failed),
        "rows": rows,
        "excess": _largest(judged),
        "excuses": _rounding_budget(judged),
        "failing": failing_case(worst, again) if worst else None,
        "failures": [_failure(a, again) for a in wrong if a.outputs is None][
            :MOST_FAILURES
        ],
        "conclusion": conclusion(diagnosis, worst is not None) if faults else None,
        "fit": diagnosis.fit if diagnosis and diagnosis.fit else None,
        "explanations": [_explanation(e) for e in _explanations(diagnosis)],
        "closest": _explanation(diagnosis.closest)
        if diagnosis and diagnosis.closest
        else None,
        "diagnosis": [h.name for h in _hypotheses(diagnosis)],
    }


def _reason(
    diagnosis: Diagnosis | None, wrong: list[Answer], related: list[str]
) -> dict[str, Any]:
    """Why a pass is wrong, without what hangs on how many rows were asked.

    Two verdicts with the same reason are of the same fault.
    """
    largest = _largest(_judged(wrong))
    closest = diagnosis.closest if diagnosis else None
    return {
        "named": sorted(
            sorted({h.name for h in one.hypotheses}) for one in _explanations(diagnosis)
        ),
        "term": without_counts(diagnosis.fit) if diagnosis and diagnosis.fit else None,
        "nearest": sorted({h.name for h in closest.hypotheses}) if closest else [],
        "outputs": sorted(n for n, e in largest.items() if e is None or e > 1),
        "cases": sorted({_name_of(a) for a in wrong}),
        "failed": sorted({_failure_of(a) for a in wrong if not explicable(a)}),
        "tests": sorted({text.partition(":")[0] for text in related}),
    }


def _failure_of(answer: Answer) -> str:
    """A case without numbers to replay, and why, without numbers of rows and places."""
    assert answer.finding is not None
    why = answer.finding.text.removeprefix(f"{answer.probe.case.name}: ")
    return f"{_name_of(answer)}: {re.sub('0x[0-9a-f]+|[0-9][0-9,.]*', '#', why)}"


def _name_of(answer: Answer) -> str:
    """Of a case, without the number of a captured frame."""
    return re.sub(r"-frame-\d+$", "", answer.probe.case.name)


def without_counts(text: str) -> str:
    """A sentence without how many rows it is about."""
    return re.sub(r",? in (all )?[\d,]+ (of [\d,]+ )?(wrong )?rows", "", text)


def _judged(answers: list[Answer]) -> list[tuple[Case, Judgement]]:
    """Cases of which numbers were compared."""
    return [
        (a.probe.case, a.finding.judgement)
        for a in answers
        if a.finding and a.finding.judgement
    ]


def _sentence(pass_name: str, status: str, what: str, why: str) -> str:
    if status == "by design":
        return f"{pass_name} is biased by design, as it declares: {why}"
    if status == "undecided":
        return f"{pass_name} cannot be judged yet: {why}"
    verb = "departs from the contract" if status == "departs" else "is wrong"
    # The one output of a kernel has the kernel's name.
    own = what.startswith(f"{pass_name} ") and status == "wrong"
    told = what if own else f"{pass_name} {verb}: {what}"
    return f"{told}; {why}" if why else told


def _shown_fault(wrong: list[Answer], faults: list[str]) -> str:
    """That of a replay if there is one, which holds whatever a backend chooses."""
    replays = (a.finding.text for a in wrong if a.finding and a.finding.judgement)
    return next(replays, faults[0])


def _failure(answer: Answer, again: str) -> dict[str, Any]:
    """A call that gave nothing to judge, and what the backend wrote meanwhile."""
    assert answer.finding is not None
    return {
        "case": answer.probe.case.name,
        "reason": answer.finding.text,
        "output": answer.finding.output,
        "command": command(answer, again),
    }


def _status(
    diagnosis: Diagnosis | None, answers: list[Answer], wrong: list[Answer]
) -> str:
    if not wrong:
        return "right" if answers else "not judged"
    if diagnosis and settles(diagnosis) and all(map(explicable, wrong)):
        return "departs" if departs(diagnosis) else "by design"
    return "undecided" if diagnosis and diagnosis.undecided else "wrong"


def _largest(judged: list[tuple[Case, Judgement]]) -> dict[str, float | None]:
    """Of each output, within the working range."""
    most: dict[str, float] = {}
    for case, judgement in judged:
        within = slice(None) if case.beyond is None else ~case.beyond
        for compared in judgement.compared:
            excess = float(excess_of(compared)[within].max(initial=0.0))
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


def _explanations(diagnosis: Diagnosis | None) -> tuple[Explanation, ...]:
    return diagnosis.explanations if diagnosis else ()


def _hypotheses(diagnosis: Diagnosis | None) -> list[Hypothesis]:
    """All that a pass is explained by, or nearly, each once."""
    closest = diagnosis.closest if diagnosis else None
    every = [*_explanations(diagnosis), *([closest] if closest else [])]
    return list(dict.fromkeys(h for one in every for h in one.hypotheses))


def _explanation(one: Explanation) -> dict[str, Any]:
    return {
        "told": explained(one),
        "departures": [h.name for h in one.departures if h not in one.designed],
        "designed": [h.name for h in one.designed] if one.by_design else [],
        "mistakes": [h.name for h in one.mistakes],
        "innocent": one.innocent,
        "right": one.right,
        "rows": one.rows,
        "unexplained": one.rows - one.right,
    }


def _mistakes(verdict: Verdict) -> list[dict[str, Any]]:
    """What the documentation says of each hypothesis that is named."""
    named = dict.fromkeys(h for d in verdict.diagnoses for h in _hypotheses(d))
    return [
        {
            "name": h.name,
            "mistake": h.mistake,
            "wrong": h.wrong,
            "right": h.right,
            "passes": list(h.passes),
            "seen": list(h.seen),
            "departure": h.departure,
        }
        for h in named
    ]
