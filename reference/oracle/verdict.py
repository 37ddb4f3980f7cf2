"""The verdict: what the rungs have shown, within the time that was given."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from reference.oracle.contract.fields import Passes, Precision
from reference.oracle.diagnosis.diagnose import Diagnosis, diagnose
from reference.oracle.rungs.probe import Answer
from reference.oracle.steps import Rung, Step

Status = Literal["PASS", "FAIL", "UNDECIDED"]


@dataclass(frozen=True, slots=True, eq=False)
class Timed:
    """A step and how long it took.

    Attributes
    ----------
    step : Step
        What was found.
    seconds : float
        Of wall time.
    """

    step: Step
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What is said of a backend.

    Attributes
    ----------
    status : 'PASS', 'FAIL' or 'UNDECIDED'
        Right to rounding; wrong; or out of time.
    steps : list of Timed
        As far as the ladder was climbed.
    left : list of str
        Titles of steps for which there was no time.
    diagnoses : list of Diagnosis
        Of passes that are wrong, in the order of the contract.
    absent : list of str
        Passes that the backend does not have.
    """

    status: Status
    steps: list[Timed]
    left: list[str]
    diagnoses: list[Diagnosis]
    absent: list[str]

    @property
    def certified(self) -> float | None:
        """Bound on the relative bias of the mean; ``None`` where there is none."""
        bounds = [timed.step.certified for timed in self.steps]
        return min((b for b in bounds if b is not None), default=None)

    @property
    def more(self) -> list[str]:
        """What more time would buy."""
        return [timed.step.more for timed in self.steps if timed.step.more]


def climb(
    passes: Passes,
    precision: Precision,
    rungs: Iterator[Rung],
    budget: float,
    clock: Callable[[], float],
    tell: Callable[[str], None],
) -> Verdict:
    """Climb the ladder until the time is over.

    Parameters
    ----------
    passes : mapping of str to Pass
        The contract.
    precision : 'float32' or 'float64'
        Of the backend.
    rungs : iterator of Rung
        The ladder.
    budget : float, s
        No step begins after that.
    clock : callable
        Gives seconds.
    tell : callable
        Told the title of each step before it begins.

    Returns
    -------
    Verdict
        All steps of a budget are taken although one has failed: the diagnosis wants
        them.
    """
    start, steps, left = clock(), [], []
    for rung, title, take in rungs:
        if clock() - start >= budget:
            left.append(f"{rung} {title}")
            continue
        tell(f"{rung} {title}")
        began = clock()
        steps.append(Timed(take(), clock() - began))
    answers = [a for timed in steps for a in timed.step.answers]
    wrong = {
        a.probe.case.pass_name for a in answers if a.finding and not a.finding.passed
    }
    diagnoses = [
        diagnose(name, _of_pass(answers, name), precision)
        for name in passes
        if name in wrong
    ]
    faults = any(timed.step.faults for timed in steps)
    judged = {a.probe.case.pass_name for a in answers if a.finding}
    asked = {a.probe.case.pass_name for a in answers}
    findings = [f for timed in steps for f in timed.step.findings]
    status: Status = "PASS"
    if faults:
        status = "FAIL"
    elif left or not (judged or findings) or any(t.step.more for t in steps):
        status = "UNDECIDED"
    absent = [name for name in passes if name in asked - judged]
    return Verdict(status, steps, left, diagnoses, absent)


def _of_pass(answers: list[Answer], name: str) -> list[Answer]:
    """Answers that a replay can explain; those at the extremes it cannot."""
    return [
        a
        for a in answers
        if a.probe.case.pass_name == name
        and a.finding
        and (a.finding.judgement or a.probe.rung == "L1")
    ]
