"""One question to a backend, and what its answer shows."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.oracle.cases import (
    Buffers,
    Case,
    Failure,
    not_a_number,
    not_finite,
    pass_of,
    refused,
)
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.working_range import beyond_range, where_beyond


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """What an answer shows.

    Attributes
    ----------
    passed : bool; nothing is wrong with it
    text : str; one line: what is wrong, and where; empty where nothing is
    at_extremes : str
        What is wrong beyond the working range, which does not fail; or empty.
    output : str; what a backend wrote that failed to answer; or empty
    asked : tuple of str; passes of the backend that a test of several calls rests on
    """

    passed: bool
    text: str = ""
    judgement: Judgement | None = None
    at_extremes: str = ""
    output: str = ""
    asked: tuple[str, ...] = ()


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
        found = Finding(False, outcome.reason, output=outcome.output)
        return Answer(probe, None, found)
    held = _up_to_the_largest(outcome)
    bad = refused(passes, probe.case, precision, held)
    if bad is not None:
        return Answer(probe, None, Finding(False, bad.reason))
    finding = probe.examine(probe.case, _finite(passes, probe.case, held), precision)
    infinite = refused(passes, probe.case, precision, outcome)
    if infinite is not None:
        finding = replace(finding, passed=False, text=infinite.reason)
        return Answer(probe, held, finding)
    extreme = _not_finite_beyond(passes, probe.case, outcome)
    if extreme and finding.passed:
        finding = replace(finding, at_extremes=extreme)
    return Answer(probe, held, finding)


OVERFLOWING = ("radiance", "W")
"""What a renderer may store in a format that goes to infinity where float32 does not:
it is held against the replay of that format as the largest number."""


def _up_to_the_largest(outputs: Buffers) -> Buffers:
    """Outputs with the largest number of their type in place of infinity."""
    found = dict(outputs)
    for name in OVERFLOWING:
        array = found.get(name)
        if array is not None and np.asarray(array).dtype.kind == "f":
            most = np.finfo(np.asarray(array).dtype).max
            found[name] = np.where(array == np.inf, most, array)
    return found


def _finite(passes: Passes, case: Case, outputs: Buffers) -> Buffers:
    """Outputs with 0 in place of what is no number, which is told by itself."""
    found = dict(outputs)
    for field in pass_of(passes, case).outputs:
        if not_finite(found[field.name]).any():
            array = found[field.name]
            found[field.name] = np.where(np.isfinite(array), array, 0)
    return found


def _not_finite_beyond(passes: Passes, case: Case, outputs: Buffers) -> str:
    """What is no number beyond the working range, in one line; or empty."""
    one = pass_of(passes, case)
    for field in one.outputs:
        found = outputs[field.name]
        bad = not_finite(found)
        if bad.any():
            # Some rows are not looked at for other reasons than their numbers.
            out = beyond_range(one, dict(case.inputs))
            bad = bad & (False if out is None else out)
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            where = where_beyond(one, dict(case.inputs), row)
            assert case.beyond is not None
            return (
                f"{case.name}: at extremes alone: {field.name} is"
                f" {not_a_number(found[row])} where {where}, {int(bad.sum())} of"
                f" {int(case.beyond.sum())} such rows"
            )
    return ""
