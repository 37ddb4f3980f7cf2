"""The verdict: what the levels have shown, within the time that was given."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Literal

import numpy as np

from restir_gi.reference.oracle.cases import UnaskedError
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.declaration.declared import (
    NOTHING_DECLARED,
    Declaration,
)
from restir_gi.reference.oracle.declaration.followed import (
    BiasByDesign,
    Followed,
    biases_by_design,
    followed_in,
)
from restir_gi.reference.oracle.diagnosis.at_fault import at_fault
from restir_gi.reference.oracle.diagnosis.diagnose import (
    Diagnosis,
    Explanation,
    diagnose,
)
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, combined
from restir_gi.reference.oracle.diagnosis.subsets import AskedRows, explained
from restir_gi.reference.oracle.diagnosis.terms import (
    first_wrong_place,
    first_wrong_term,
)
from restir_gi.reference.oracle.levels.probe import Answer, Finding
from restir_gi.reference.oracle.steps import Level, LevelStep, MeasuredBias

Status = Literal["PASS", "FAIL", "UNDECIDED", "QUICK"]


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
    status : 'PASS', 'FAIL', 'UNDECIDED' or 'QUICK'
        Right to rounding; wrong; out of time; or right in the quick steps, which are
        the only ones that were wanted.
    steps : list of Timed; as far as the ladder was run
    left : list of str; titles of steps for which there was no time
    diagnoses : list of Diagnosis; of passes that are not the contract's, in its order
    absent : list of str; passes that the backend does not have
    left_running : int
        Processes that the backend had left when it was closed; they were ended.
    missing : list of str; passes that were required and not judged, why, a line each
    near : list of str; methods that are no pass and look like one, a line each
    precision : 'float32' or 'float64'; in which the backend calculates
    wrong : bool; anything is that neither a departure nor a declaration explains
    declaration : Declaration; what the backend says of itself
    followed : list of Followed; what each judged pass does of that
    biases : list of BiasByDesign; what is biased because it is declared so
    not_asked : list of str; titles of steps that were not wanted
    """

    status: Status
    steps: list[Timed]
    left: list[str]
    diagnoses: list[Diagnosis]
    absent: list[str]
    left_running: int = 0
    missing: list[str] = field(default_factory=list)
    near: list[str] = field(default_factory=list)
    precision: Precision = "float32"
    wrong: bool = False
    declaration: Declaration = NOTHING_DECLARED
    followed: list[Followed] = field(default_factory=list)
    biases: list[BiasByDesign] = field(default_factory=list)
    not_asked: list[str] = field(default_factory=list)

    @property
    def judged(self) -> frozenset[str]:
        """Passes of the backend that something was found out about."""
        steps = [timed.step for timed in self.steps]
        answers = [a for step in steps for a in step.answers if a.finding]
        loops = [name for step in steps for f in step.findings for name in f.asked]
        return frozenset(loops).union(a.probe.case.pass_name for a in answers)

    @property
    def unasked(self) -> list[str]:
        """Calls of which nothing is known."""
        return [line for timed in self.steps for line in timed.step.unasked]

    @property
    def at_extremes(self) -> list[str]:
        """What is wrong beyond the working range alone, a line each.

        What a departure explains there as well is not wrong.
        """
        departed = {d.pass_name: d for d in self.settled}
        answers = [answer for timed in self.steps for answer in timed.step.answers]
        return [
            a.finding.at_extremes
            for a in answers
            if a.finding
            and a.finding.at_extremes
            and not _is_explained(a, departed.get(a.probe.case.pass_name), self)
        ]

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
        return [d for d in self.diagnoses if departs(d) and self._has_its_needs(d)]

    @property
    def settled(self) -> list[Diagnosis]:
        """Departures, and passes of which all that is biased is declared."""
        return [d for d in self.diagnoses if settles(d) and self._has_its_needs(d)]

    @property
    def unaccepted(self) -> list[str]:
        """Names of declared choices whose bias nobody has accepted."""
        left = [name for b in self.biases if not b.accepted for name in b.names]
        accepts = self.declaration.accepts
        return [name for name in dict.fromkeys(left) if not accepts(name)]

    @property
    def to_accept(self) -> str:
        """What makes it green on purpose, where a declared bias is in its way."""
        if not self.unaccepted:
            return ""
        names = ", ".join(f'"{name}"' for name in self.unaccepted)
        return (
            f"accept it by accept = [{names}] in the declaration, or by --accept"
            f" {','.join(self.unaccepted)}"
        )

    @property
    def measured(self) -> MeasuredBias | None:
        """Bias of the mean of whole runs; ``None`` where none were made."""
        found = [timed.step.measured for timed in self.steps]
        return next((one for one in found if one is not None), None)

    def _has_its_needs(self, diagnosis: Diagnosis) -> bool:
        """Whether what a pass leaves to another one is done there, if it was judged."""
        judged = {
            answer.probe.case.pass_name
            for timed in self.steps
            for answer in timed.step.answers
            if answer.finding
        }
        named = {h.name for other in self.diagnoses for h in other.matches}
        needs = [h.needs for h in diagnosis.matches if h.needs]
        return all(name in named or where not in judged for where, name in needs)

    @property
    def binding(self) -> list[LevelStep]:
        """Steps whose findings hold for a backend that departs as this one does."""
        kinds = {kind for d in self.settled for kind in d.kinds}
        steps = [timed.step for timed in self.steps]
        return [step for step in steps if step.binds(kinds)]


def run_ladder(
    passes: Passes,
    precision: Precision,
    levels: Iterator[Level],
    budget: float,
    clock: Callable[[], float],
    tell: Callable[[str], None],
    declaration: Declaration = NOTHING_DECLARED,
    extremes: bool = False,
) -> Verdict:
    """Run the ladder until the time is over.

    All steps of a budget are taken although one has failed: the diagnosis wants them.

    Parameters
    ----------
    budget : float, s
        No step begins after that, and those who ask a backend stop by themselves.
    clock : callable; gives seconds
    tell : callable; told the title of each step before it begins
    declaration : Declaration
        What the backend says of itself: each pass is tried with that first.
    extremes : bool
        Whether what is wrong beyond the working range alone fails too.
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
    wrong = {a.probe.case.pass_name for a in answers if _fails(a.finding, extremes)}
    diagnoses: list[Diagnosis] = []
    for name in passes:
        if name in wrong:
            explained = [e for d in diagnoses for e in d.explanations[:1]]
            of_pass = _of_pass(answers, name)
            declared = declaration.of_pass(name)
            found = _diagnosed(name, of_pass, precision, declared, explained)
            diagnoses.append(found)
    judged = {a.probe.case.pass_name for a in answers if a.finding}
    asked = {a.probe.case.pass_name for a in answers}
    findings = [f for timed in steps for f in timed.step.findings]
    absent = [name for name in passes if name in asked - judged]
    followed = _followed(declaration, answers, diagnoses, precision)
    verdict = Verdict(
        "PASS",
        steps,
        left,
        diagnoses,
        absent,
        precision=precision,
        declaration=declaration,
        followed=followed,
        biases=biases_by_design(declaration, followed, diagnoses),
    )
    if _is_wrong(verdict, answers, extremes):
        return replace(verdict, status="FAIL", wrong=True)
    if verdict.unaccepted:
        return replace(verdict, status="FAIL")
    if left or verdict.unasked or not (judged or findings) or verdict.more:
        return replace(verdict, status="UNDECIDED")
    return verdict


def _diagnosed(
    name: str,
    answers: list[Answer],
    precision: Precision,
    declared: Sequence[Hypothesis],
    explained: Sequence[Explanation],
) -> Diagnosis:
    """What explains a pass; if no known mistake does, which term is the first wrong."""
    wrong = at_fault(name, answers)
    found = diagnose(name, chain.from_iterable(wrong), precision, declared, explained)
    if found.explanations:
        return found
    told = first_wrong_term(wrong[0], precision)
    if told is not None:
        return replace(found, fit=told.sentence)
    return replace(found, fit=first_wrong_place(wrong[0], precision))


def _followed(
    declaration: Declaration,
    answers: list[Answer],
    diagnoses: list[Diagnosis],
    precision: Precision,
) -> list[Followed]:
    """What each pass with answers does of its declared choices."""
    found, by_pass = [], {d.pass_name: d for d in diagnoses}
    names = dict.fromkeys(a.probe.case.pass_name for a in answers if a.finding)
    for name in names:
        declared, given = declaration.of_pass(name), _of_pass(answers, name)
        if declared and given:
            about = name, declared, given, by_pass.get(name), precision
            found.append(followed_in(*about))
    return found


def departs(diagnosis: Diagnosis) -> bool:
    """Whether a pass is only other than the contract's, and no bias comes of it.

    All that reproduce its answers are departures.
    """
    found = diagnosis.explanations
    return bool(found) and all(one.innocent for one in found)


def settles(diagnosis: Diagnosis) -> bool:
    """Whether a pass departs, or all that is biased in it is declared."""
    found = diagnosis.explanations
    return bool(found) and all(one.innocent or one.by_design for one in found)


def by_design(diagnosis: Diagnosis) -> bool:
    """Whether a pass is biased, and all that is biased in it is declared."""
    return settles(diagnosis) and not departs(diagnosis)


def _fails(finding: Finding | None, extremes: bool) -> bool:
    """Whether an answer is wrong; at extremes too, if they are asked for."""
    if finding is None:
        return False
    return not finding.passed or (extremes and bool(finding.at_extremes))


def _is_wrong(verdict: Verdict, answers: list[Answer], extremes: bool) -> bool:
    """Whether anything is wrong that neither a departure nor a declaration explains."""
    departed = {d.pass_name for d in verdict.settled}
    unexplained = [
        a.finding
        for a in answers
        if not (a.probe.case.pass_name in departed and explicable(a))
    ]
    whole = [finding for step in verdict.binding for finding in step.findings]
    return any(_fails(finding, extremes) for finding in (*unexplained, *whole))


def _is_explained(answer: Answer, departs_in: Diagnosis | None, of: Verdict) -> bool:
    """Whether a departure explains all rows, those beyond the working range too."""
    if departs_in is None or answer.outputs is None or not explicable(answer):
        return False
    case = answer.probe.case
    asked = AskedRows(case, answer.outputs, np.ones(case.rows, bool))
    return any(
        explained(asked, combined(one.hypotheses), of.precision)
        for one in departs_in.explanations
    )


def explicable(answer: Answer) -> bool:
    """Whether a replay can explain an answer; at some extremes it cannot.

    There are outputs, and exact arithmetic has numbers to hold against them.
    """
    if answer.finding is None or answer.outputs is None:
        return False
    return answer.finding.judgement is not None or answer.probe.level == "L1"


def _of_pass(answers: list[Answer], name: str) -> list[Answer]:
    return [a for a in answers if a.probe.case.pass_name == name and explicable(a)]
