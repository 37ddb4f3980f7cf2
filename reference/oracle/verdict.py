"""The verdict: what the levels have shown, within the time that was given."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

from restir_gi.reference.oracle.cases import UnaskedError
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis, diagnose
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.steps import Level, LevelStep

Status = Literal["PASS", "FAIL", "UNDECIDED"]


@dataclass(frozen=True, slots=True, eq=False)
class Timed:
    """A step and how long it took.

    Attributes
    ----------
    step : LevelStep; what was found
    seconds : float; of wall time
    """

    step: LevelStep
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What is said of a backend.

    Attributes
    ----------
    status : 'PASS', 'FAIL' or 'UNDECIDED'; right to rounding; wrong; or out of time
    steps : list of Timed; as far as the ladder was run
    left : list of str; titles of steps for which there was no time
    diagnoses : list of Diagnosis; of passes that are not the contract's, in its order
    absent : list of str; passes that the backend does not have
    left_running : int
        Processes that the backend had left when it was closed; they were ended.
    """

    status: Status
    steps: list[Timed]
    left: list[str]
    diagnoses: list[Diagnosis]
    absent: list[str]
    left_running: int = 0

    @property
    def unasked(self) -> list[str]:
        """Calls of which nothing is known."""
        return [line for timed in self.steps for line in timed.step.unasked]

    @property
    def certified(self) -> float | None:
        """Bound on the relative bias of the mean; ``None`` where there is none."""
        bounds = [step.certified for step in self.binding]
        return min((b for b in bounds if b is not None), default=None)

    @property
    def more(self) -> list[str]:
        """What more time would buy."""
        return [step.more for step in self.binding if step.more]

    @property
    def departures(self) -> list[Diagnosis]:
        """Passes that are other than the contract's, and yet bring no bias."""
        return [d for d in self.diagnoses if departs(d)]

    @property
    def binding(self) -> list[LevelStep]:
        """Steps whose findings hold for a backend that departs as this one does."""
        kinds = {h.departure for d in self.departures for h in d.matches}
        steps = [timed.step for timed in self.steps]
        return [step for step in steps if not kinds & set(step.relies_on)]


def run_ladder(
    passes: Passes,
    precision: Precision,
    levels: Iterator[Level],
    budget: float,
    clock: Callable[[], float],
    tell: Callable[[str], None],
) -> Verdict:
    """Run the ladder until the time is over.

    All steps of a budget are taken although one has failed: the diagnosis wants them.

    Parameters
    ----------
    budget : float, s
        No step begins after that, and those who ask a backend stop by themselves.
    clock : callable; gives seconds
    tell : callable; told the title of each step before it begins
    """
    start, steps, left = clock(), [], []
    for level, title, take in levels:
        if clock() - start >= budget:
            left.append(f"{level} {title}")
            continue
        tell(f"{level} {title}")
        began = clock()
        try:
            steps.append(Timed(take(), clock() - began))
        except UnaskedError:
            left.append(f"{level} {title}")
    answers = [a for timed in steps for a in timed.step.answers]
    wrong = {
        a.probe.case.pass_name for a in answers if a.finding and not a.finding.passed
    }
    diagnoses = [
        diagnose(name, _of_pass(answers, name), precision)
        for name in passes
        if name in wrong
    ]
    judged = {a.probe.case.pass_name for a in answers if a.finding}
    asked = {a.probe.case.pass_name for a in answers}
    findings = [f for timed in steps for f in timed.step.findings]
    absent = [name for name in passes if name in asked - judged]
    verdict = Verdict("PASS", steps, left, diagnoses, absent)
    if _is_wrong(verdict, answers):
        return replace(verdict, status="FAIL")
    if left or verdict.unasked or not (judged or findings) or verdict.more:
        return replace(verdict, status="UNDECIDED")
    return verdict


def departs(diagnosis: Diagnosis) -> bool:
    """Whether a pass is only other than the contract's, and no bias comes of it.

    All that reproduce its answers are departures.
    """
    return bool(diagnosis.matches) and all(h.departure for h in diagnosis.matches)


def _is_wrong(verdict: Verdict, answers: list[Answer]) -> bool:
    """Whether anything is wrong that no departure explains."""
    departed = {d.pass_name for d in verdict.departures}
    unexplained = [
        a.finding
        for a in answers
        if a.finding and not (a.probe.case.pass_name in departed and explicable(a))
    ]
    whole = [finding for step in verdict.binding for finding in step.findings]
    return any(not finding.passed for finding in (*unexplained, *whole))


def explicable(answer: Answer) -> bool:
    """Whether a replay can explain an answer; at some extremes it cannot.

    There are outputs, and exact arithmetic has numbers to hold against them.
    """
    if answer.finding is None or answer.outputs is None:
        return False
    return answer.finding.judgement is not None or answer.probe.level == "L1"


def _of_pass(answers: list[Answer], name: str) -> list[Answer]:
    return [a for a in answers if a.probe.case.pass_name == name and explicable(a)]
