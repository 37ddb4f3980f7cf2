"""One question to a backend, and what its answer shows."""

from collections.abc import Callable
from dataclasses import dataclass

from restir_gi.reference.oracle.cases import Buffers, Case, Failure, refused
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.replay.judgement import Judgement


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """What an answer shows.

    Attributes
    ----------
    passed : bool; nothing is wrong with it
    text : str; one line: what is wrong, and where; empty where nothing is
    """

    passed: bool
    text: str = ""
    judgement: Judgement | None = None


Examine = Callable[[Case, Buffers, Precision], Finding]


@dataclass(frozen=True, slots=True, eq=False)
class Probe:
    """One question.

    Attributes
    ----------
    level : str; "L0" to "L4"
    """

    level: str
    case: Case
    examine: Examine


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A question and what came of it.

    Attributes
    ----------
    outputs : Buffers or None; what the backend gave, if it can be judged
    finding : Finding or None; ``None`` where the backend does not have the pass
    """

    probe: Probe
    outputs: Buffers | None
    finding: Finding | None


def examined(
    passes: Passes,
    precision: Precision,
    probe: Probe,
    outcome: Buffers | Failure | None,
) -> Answer:
    """Examine what came of a question; a failure to answer is a finding too."""
    if outcome is None:
        return Answer(probe, None, None)
    if isinstance(outcome, Failure):
        return Answer(probe, None, Finding(False, outcome.reason))
    bad = refused(passes, probe.case, precision, outcome)
    if bad is not None:
        return Answer(probe, None, Finding(False, bad.reason))
    return Answer(probe, outcome, probe.examine(probe.case, outcome, precision))
