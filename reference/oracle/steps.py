"""Steps of the ladder, and asking a backend."""

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

import numpy as np

from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    Buffers,
    Case,
    Failure,
    Unasked,
    UnaskedError,
    pass_of,
    refused,
)
from restir_gi.reference.oracle.contract.fields import Passes
from restir_gi.reference.oracle.diagnosis.hypothesis import Departure
from restir_gi.reference.oracle.levels.probe import Answer, Finding, Probe, examined
from restir_gi.reference.oracle.loop import Ask


@dataclass(frozen=True, slots=True)
class MeasuredBias:
    """Bias of the mean of whole runs.

    Attributes
    ----------
    relative, error : float; to the truth, and its standard error
    runs : int; independent ones
    """

    relative: float
    error: float
    runs: int

    @property
    def text(self) -> str:
        """In words."""
        return (
            f"{100 * self.relative:+.2g} % ± {100 * self.error:.1g} % of the mean of"
            f" {self.runs} runs inside a sphere (measured)"
        )


@dataclass(frozen=True, slots=True, eq=False)
class LevelStep:
    """A part of the ladder, judged as one.

    Attributes
    ----------
    level : str; "L0" to "L4"
    findings : list of Finding; of what is no single call
    certified : float or None; bound on the relative bias, where one was found
    more : str; what more time would buy; empty where it buys nothing
    relies_on : tuple of str
        Departures from the contract under which its findings say nothing.
    only_under : tuple of str
        Departures of which there must be one: it stands in for what they make void.
    unasked : list of str; calls of which nothing is known, and why, a line each
    measured : MeasuredBias or None; of the mean, where whole runs were made
    """

    level: str
    title: str
    answers: list[Answer] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    certified: float | None = None
    more: str = ""
    relies_on: tuple[Departure, ...] = ()
    only_under: tuple[Departure, ...] = ()
    unasked: list[str] = field(default_factory=list)
    measured: MeasuredBias | None = None

    def binds(self, kinds: Set[str]) -> bool:
        """Whether its findings hold for a backend that departs in these ways."""
        wanted = not self.only_under or bool(kinds & set(self.only_under))
        return wanted and not kinds & set(self.relies_on)

    @property
    def faults(self) -> list[str]:
        """What is wrong, a line each."""
        found = [a.finding for a in self.answers if a.finding is not None]
        return [f.text for f in (*found, *self.findings) if not f.passed]


Level = tuple[str, str, Callable[[], LevelStep]]


def asked(
    level: str, title: str, passes: Passes, backend: Backend, probes: Sequence[Probe]
) -> LevelStep:
    """A step of probes: ask a backend, and examine what it answers.

    With an answer to each question that was asked, in the same order.
    """
    outcomes = backend.run(passes, [probe.case for probe in probes])
    _canary()
    answers, unasked = [], []
    for probe, outcome in zip(probes, outcomes, strict=True):
        # A failure is known as it is; to judge numbers takes time.
        late = isinstance(outcome, Mapping) and backend.remaining() <= 0
        known = NO_TIME if late else outcome
        if isinstance(known, Unasked):
            unasked.append(f"{probe.case.name}: {known.reason}")
        else:
            answers.append(examined(passes, backend.precision, probe, known))
    return LevelStep(level, title, answers, unasked=unasked)


def _canary() -> None:
    """Subnormal numbers are alive here: a library may switch them off for everybody."""
    small = np.full(1, 1e-40, np.float32)
    if not (small * np.float32(0.5)).any():
        raise RuntimeError("subnormal numbers became 0 in the oracle's own process")


class NoAnswerError(Exception):
    """A backend did not answer in the middle of a step."""


class NothingOfItsOwnError(Exception):
    """A backend has none of the passes that a step is about."""


PATIENCE = 8
"""Calls without a pass of the backend's own, after which a step is given up: a frame of
the loop has four."""


class Asker:
    """Asks a backend case by case; what it lacks, the built-in one answers.

    Attributes
    ----------
    answered : dict of str to int; calls that the backend has answered, of each pass
    lacked : int; calls that the built-in one answered
    """

    def __init__(self, passes: Passes, backend: Backend) -> None:
        self._passes, self._backend = passes, backend
        self._standing_in = BuiltIn(backend.precision)
        self.lacked = 0
        self.answered: dict[str, int] = {}

    def __call__(self, case: Case) -> Buffers:
        """Outputs of a case, of the right form, by the backend or the built-in one.

        Raises NoAnswerError: the backend has the pass, and gives nothing that can be
        judged.
        Raises NothingOfItsOwnError: nothing that was asked so far was the backend's:
        there is nothing to judge.
        Raises UnaskedError: there was no time to ask, or nothing is known for another
        reason.
        """
        if self._backend.remaining() <= 0:
            raise UnaskedError(f"{case.name}: {NO_TIME.reason}")
        outcome = self._backend.run(self._passes, [case])[0]
        if isinstance(outcome, Unasked):
            raise UnaskedError(f"{case.name}: {outcome.reason}")
        if outcome is None:
            self.lacked += 1
            if self.lacked >= PATIENCE and not self.answered:
                raise NothingOfItsOwnError
            own: Buffers = getattr(self._standing_in, case.pass_name)(
                **case.inputs, **case.settings
            )
            return own
        self.answered[case.pass_name] = self.answered.get(case.pass_name, 0) + 1
        if not isinstance(outcome, Failure):
            bad = refused(self._passes, case, self._backend.precision, outcome)
            if bad is None:
                asked = pass_of(self._passes, case).outputs
                return {field.name: outcome[field.name] for field in asked}
            outcome = bad
        raise NoAnswerError(outcome.reason)


def taken(
    level: str,
    title: str,
    passes: Passes,
    backend: Backend,
    tests: Iterable[Callable[[Ask], Finding]],
    relies_on: tuple[Departure, ...] = (),
) -> LevelStep:
    """A step of tests that ask the backend themselves.

    Findings of tests in which nothing was the backend's own are left out.

    Parameters
    ----------
    relies_on : tuple of str; departures under which these say nothing
    """
    found, unasked = [], []
    for test in tests:
        ask = Asker(passes, backend)
        try:
            finding = test(ask)
        except NoAnswerError as reason:
            finding = Finding(False, str(reason))
        except NothingOfItsOwnError:
            continue
        except UnaskedError as reason:
            unasked.append(str(reason))
            continue
        if ask.answered:
            found.append(_with_own_passes(finding, ask))
    return LevelStep(level, title, findings=found, relies_on=relies_on, unasked=unasked)


def _with_own_passes(finding: Finding, ask: Asker) -> Finding:
    """Which passes can be wrong, where not all of the loop are the backend's own."""
    finding = replace(finding, asked=tuple(ask.answered))
    if finding.passed or not ask.lacked:
        return finding
    own = ", ".join(ask.answered)
    return replace(finding, text=f"{finding.text}; the backend's own here: {own}")
