"""A backend judged in one call."""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

from restir_gi.reference.oracle.backends.open import open_backend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.cases import UnaskedError
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.distributed import Reached, distributed_levels
from restir_gi.reference.oracle.golden import read_golden
from restir_gi.reference.oracle.ladder import golden_levels, ladder, statistical_levels
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import Verdict, run_ladder
from restir_gi.reference.system.errors import UsageError


def _silent(title: str) -> None:
    """Tell nobody."""


def judge(
    backend: Any,
    budget: float,
    statistics: bool = True,
    limits: Limits | None = None,
    precision: Precision = "float32",
    against: Path | None = None,
    tell: Callable[[str], None] = _silent,
    executor: Executor | None = None,
) -> Verdict:
    """Judge a backend, whatever it does.

    Raises UsageError: no such backend or folder, or they are of different precision.

    Parameters
    ----------
    backend : object or str
        An object is called in this process; a string names one, or is a command line
        with ``{directory}``.
    budget : float, s
        In which the backend is loaded and asked; what has no time then is told.
    statistics : bool; whether whole runs are among the steps
    limits : Limits, optional; of time and memory, for a backend in another process
    precision : 'float32' or 'float64'; of a program; an object says its own
    against : Path, optional; golden folder whose cases are judged in place of our own
    tell : callable; told the title of each step
    executor : Executor, optional
        Other processes, which make most of the whole runs, of a backend that is named
        by a string.
    """
    start = time.monotonic()

    def remaining() -> float:
        return start + budget - time.monotonic()

    golden = read_golden(against) if against is not None else None
    given = golden[0] if golden else precision
    passes = whole_contract()
    try:
        opened = open_backend(backend, limits or Limits(), given, remaining)
    except UnaskedError as error:
        return Verdict("UNDECIDED", [], [str(error)], [], [])
    try:
        if golden and opened.precision != golden[0]:
            raise UsageError(
                f"{against} holds {golden[0]} data, but the backend calculates in"
                f" {opened.precision}; make new data with restir golden --precision"
            )
        if golden:
            levels = golden_levels(passes, opened, golden[1])
        else:
            levels = ladder(passes, opened)
            if statistics and executor:
                reached = Reached(backend, limits or Limits(), given)
                runs = distributed_levels(reached, opened, executor, remaining)
                levels = chain(levels, runs)
            elif statistics:
                runs = statistical_levels(passes, opened, remaining)
                levels = chain(levels, runs)
        clock = time.monotonic
        verdict = run_ladder(passes, opened.precision, levels, remaining(), clock, tell)
    except BaseException:
        opened.close()
        raise
    return replace(verdict, left_running=opened.close())


def told(verdict: Verdict) -> str:
    """What is wrong, for the failure of a test.

    A line for each fault, at most three a step, and the names of the mistakes.
    """
    lines = [f"the backend is wrong ({verdict.status}):"]
    for timed in verdict.steps:
        lines += [f"  {timed.step.level} {text}" for text in timed.step.faults[:3]]
    for one in verdict.diagnoses:
        names = " or ".join(f"{h.name} ({h.mistake})" for h in one.matches)
        lines.append(f"  {one.pass_name}: {names or 'no known mistake'}")
    return "\n".join(lines)
