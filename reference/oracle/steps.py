"""Steps of the ladder, and asking a backend."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from reference.oracle.backends.backend import Backend
from reference.oracle.builtin.backend import BuiltIn
from reference.oracle.cases import Buffers, Case, Failure, refused
from reference.oracle.contract.fields import Passes
from reference.oracle.loop import Ask
from reference.oracle.rungs.probe import Answer, Finding, Probe, examined


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """A part of the ladder, judged as one.

    Attributes
    ----------
    rung : str
        "L0" to "L4".
    title : str
        What it is.
    answers : list of Answer
        To its probes.
    findings : list of Finding
        Of what is no single call.
    certified : float or None
        Bound on the relative bias, where one was found.
    more : str
        What more time would buy; empty where it buys nothing.
    """

    rung: str
    title: str
    answers: list[Answer] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    certified: float | None = None
    more: str = ""

    @property
    def faults(self) -> list[str]:
        """What is wrong, a line each."""
        found = [a.finding for a in self.answers if a.finding is not None]
        return [f.text for f in (*found, *self.findings) if not f.passed]


Rung = tuple[str, str, Callable[[], Step]]


class NoAnswer(Exception):  # noqa: N818
    """A backend did not answer in the middle of a loop."""


def ask_all(passes: Passes, backend: Backend, probes: list[Probe]) -> list[Answer]:
    """Ask a backend.

    Parameters
    ----------
    passes : mapping of str to Pass
        The contract.
    backend : Backend
        Runs cases.
    probes : list of Probe
        Questions.

    Returns
    -------
    list of Answer
        In the same order.
    """
    outcomes = backend.run(passes, [probe.case for probe in probes])
    _canary()
    return [
        examined(passes, backend.precision, probe, outcome)
        for probe, outcome in zip(probes, outcomes, strict=True)
    ]


def _canary() -> None:
    """Subnormal numbers are alive here: a library may switch them off for everybody."""
    small = np.full(1, 1e-40, np.float32)
    if not (small * np.float32(0.5)).any():
        raise RuntimeError("subnormal numbers became 0 in the oracle's own process")


def asking(passes: Passes, backend: Backend) -> Ask:
    """Ask a backend one case after the other; what it lacks, the built-in one answers.

    Parameters
    ----------
    passes : mapping of str to Pass
        The contract.
    backend : Backend
        Runs cases.

    Returns
    -------
    callable
        Gives outputs that have the right form.
    """
    own = BuiltIn(backend.precision)

    def ask(case: Case) -> Buffers:
        outcome = backend.run(passes, [case])[0]
        if outcome is None:
            answer: Buffers = getattr(own, case.pass_name)(
                **case.inputs, **case.settings
            )
            return answer
        if not isinstance(outcome, Failure):
            bad = refused(passes, case, backend.precision, outcome)
            if bad is None:
                return outcome
            outcome = bad
        raise NoAnswer(outcome.reason)

    return ask
