"""The verdict on captured frames: right to rounding, and chosen as the weights say."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.capture.cases import (
    Answered,
    RecordedFrames,
    captured_cases,
    emptied,
)
from restir_gi.reference.oracle.capture.choices import choice_findings
from restir_gi.reference.oracle.capture.sources import with_source
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.declaration.choices import BOILING
from restir_gi.reference.oracle.declaration.declared import (
    NOTHING_DECLARED,
    Declaration,
)
from restir_gi.reference.oracle.declaration.followed import BiasByDesign
from restir_gi.reference.oracle.diagnosis.alternatives import ALTERNATIVES
from restir_gi.reference.oracle.diagnosis.hypothesis import combined
from restir_gi.reference.oracle.levels.probe import Answer, Finding, Probe, examined
from restir_gi.reference.oracle.levels.replayed import examined_by_replay, found_in
from restir_gi.reference.oracle.parts import judge_of, whole_contract
from restir_gi.reference.oracle.replay.reuse import STREAMS
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES, Rules
from restir_gi.reference.oracle.steps import Level, LevelStep
from restir_gi.reference.oracle.verdict import Timed, Verdict, run_ladder

PRECISION: Precision = "float32"
"""Of engines."""


def judge_captured(
    recorded: RecordedFrames,
    budget: float,
    declaration: Declaration = NOTHING_DECLARED,
    extremes: bool = False,
    tell: Callable[[str], None] = lambda title: None,
) -> Verdict:
    """Judge what a renderer has written, for what it has read.

    Raises UsageError: a buffer is missing that a pass has read.

    Parameters
    ----------
    budget : float, s
    declaration : Declaration; what the renderer says of itself
    extremes : bool; fail also for what is wrong beyond the working range alone
    """
    passes, clock = whole_contract(), time.monotonic
    declaration = _with_storage(declaration, recorded.storage)
    boiling = any(h.name == BOILING.name for h in declaration.hypotheses)
    recorded = replace(recorded, boiling=boiling)
    answered = list(captured_cases(recorded))
    levels = _levels(passes, answered, declaration)
    verdict = run_ladder(
        passes, PRECISION, levels, budget, clock, tell, declaration, extremes
    )
    verdict = _with_sources(verdict, recorded)
    if verdict.left:
        return verdict
    began = clock()
    findings = [
        finding
        for name in STREAMS
        if (rules := _known_rules(verdict, name)) is not None
        for finding in choice_findings(
            [one for one in answered if one.case.pass_name == name], rules, PRECISION
        )
    ]
    step = LevelStep("L4", "choices", findings=findings)
    verdict = _with_filter(verdict, recorded)
    steps = [*verdict.steps, Timed(step, clock() - began)]
    wrong = any(not finding.passed for finding in findings)
    status = "FAIL" if wrong else verdict.status
    return replace(verdict, steps=steps, status=status)


def _with_filter(verdict: Verdict, recorded: RecordedFrames) -> Verdict:
    """The verdict, with the bias of a filter that empties reservoirs."""
    count, rows = emptied(recorded)
    if not recorded.boiling or not count:
        return verdict
    accepted = verdict.declaration.accepts(BOILING.name)
    told = f"emptied are {count:,} of {rows:,} reservoirs, which are not looked at"
    biases = [
        BiasByDesign(name, (BOILING.name,), None, accepted, told)
        for name in ("moved", "fused")
        if name in verdict.judged
    ]
    status = "FAIL" if biases and not accepted else verdict.status
    return replace(verdict, biases=[*verdict.biases, *biases], status=status)


def _with_storage(declaration: Declaration, storage: str) -> Declaration:
    """A declaration that says how reservoirs are stored, if it does not already."""
    kinds = {h.departure for h in declaration.hypotheses}
    if storage == "exact" or "storage" in kinds:
        return declaration
    stored = next(h for h in ALTERNATIVES if h.name == f"stored-as-{storage}")
    return replace(declaration, hypotheses=(*declaration.hypotheses, stored))


def _levels(
    passes: Passes, answered: Sequence[Answered], declaration: Declaration
) -> Iterator[Level]:
    for number in dict.fromkeys(one.frame for one in answered):
        of_frame = [one for one in answered if one.frame == number]
        about = passes, f"frame {number}", of_frame, declaration
        yield "L3", f"frame {number}", partial(_frame_step, *about)


def _frame_step(
    passes: Passes, title: str, of_frame: list[Answered], declaration: Declaration
) -> LevelStep:
    answers = []
    for one in of_frame:
        rules = declaration.rules_of(one.case.pass_name)
        probe = Probe("L3", one.case, partial(_examined, rules=rules))
        answers.append(examined(passes, PRECISION, probe, one.outputs))
    return LevelStep("L3", title, answers)


def _examined(
    case: Case, outputs: Buffers, precision: Precision, rules: Rules
) -> Finding:
    """Beside the contract where the declaration is followed, else beside that.

    So the rows that are told are those that nothing of what was declared explains.
    """
    judgement = judge_of(case.pass_name)(case, outputs, rules, precision)
    declared = found_in(case, judgement, precision)
    if not declared.passed:
        return declared
    return examined_by_replay(case, outputs, precision)


def _known_rules(verdict: Verdict, name: str) -> Rules | None:
    """By what a pass calculates, if that is known and right."""
    if name not in verdict.judged:
        return None
    wrong = next((d for d in verdict.diagnoses if d.pass_name == name), None)
    if wrong is None:
        return CONTRACT_RULES
    if wrong not in verdict.settled:
        return None
    return combined(wrong.explanations[0].hypotheses)


def _outputs(answer: Answer) -> list[NDArray[Any]]:
    return list((answer.outputs or {}).values())


def _with_sources(verdict: Verdict, recorded: RecordedFrames) -> Verdict:
    """The verdict, with the buffers that a wrong pass seems to have read.

    It is open where all that is wrong might be right, if more was dumped.
    """
    diagnoses = [with_source(d, verdict, recorded) for d in verdict.diagnoses]
    found = replace(verdict, diagnoses=diagnoses)
    left = [d for d in diagnoses if d not in found.settled]
    is_open = bool(left) and all(d.undecided for d in left)
    # Whatever the rays have found, no output may be NaN or infinite.
    answers = [answer for timed in found.steps for answer in timed.step.answers]
    is_open &= all(np.isfinite(o).all() for a in answers for o in _outputs(a))
    if found.wrong and is_open and not found.unaccepted:
        return replace(found, status="UNDECIDED", wrong=False)
    return found
