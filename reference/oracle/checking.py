"""A backend judged in one call."""

import time
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

from restir_gi.reference.oracle.backends.open import open_backend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.backends.selected import (
    EVERYTHING,
    SelectedBackend,
    Selection,
)
from restir_gi.reference.oracle.cases import UnaskedError
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.declaration.declared import (
    NOTHING_DECLARED,
    Declaration,
)
from restir_gi.reference.oracle.declaration.read import read_declaration, with_names
from restir_gi.reference.oracle.distributed import Reached, distributed_levels
from restir_gi.reference.oracle.golden import read_golden
from restir_gi.reference.oracle.ladder import (
    golden_levels,
    ladder,
    quick_levels,
    statistical_levels,
)
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.parts import SEED, whole_contract
from restir_gi.reference.oracle.verdict import Verdict, run_ladder
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown


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
    seed: int = SEED,
    selection: Selection = EVERYTHING,
    require: Collection[str] = (),
    extremes: bool = False,
    declared: Collection[str] = (),
    declaration: Path | str | Mapping[str, Any] | None = None,
    accept: Collection[str] = (),
    quick: bool = False,
) -> Verdict:
    """Judge a backend, whatever it does.

    Raises UsageError: no such backend, folder, pass or case, or they are of different
    precision, or what is declared cannot be.

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
    seed : int; of all rows that are random; with another one nobody can tune to them
    selection : Selection; which passes are asked, or which one case
    require : collection of str; passes that must be judged, else it fails
    extremes : bool; fail also for what is wrong beyond the working range alone
    declared : collection of str
        Names of choices that the backend makes on purpose, such as visibility in the
        final shading alone: as the names in a declaration.
    declaration : path or mapping, optional
        What the backend has and which choices it makes; in place of the attribute
        ``declaration`` of an object.
    accept : collection of str
        Names of declared choices whose bias does not fail.
    quick : bool
        Ask the cheapest steps alone.  Where nothing is wrong in them the status is
        QUICK: that is no verdict of the whole.
    """
    start = time.monotonic()

    def remaining() -> float:
        return start + budget - time.monotonic()

    passes = whole_contract()
    _refuse_unknown(passes, selection, require)
    said = None if declaration is None else read_declaration(declaration)
    with_names(said or NOTHING_DECLARED, declared, ())
    not_asked: list[str] = []
    golden = read_golden(against) if against is not None else None
    given = golden[0] if golden else precision
    names = tuple(passes)
    try:
        reached = open_backend(backend, limits or Limits(), given, remaining, names)
    except UnaskedError as error:
        return _with_missing(Verdict("UNDECIDED", [], [str(error)], [], []), require)
    try:
        said = with_names(said or _own_declaration(reached), declared, accept)
        selection = selection.both(said.selection)
        _refuse_unknown(passes, selection, require)
    except BaseException:
        reached.close()
        raise
    opened = SelectedBackend(reached, selection)
    try:
        if golden and opened.precision != golden[0]:
            raise UsageError(
                f"{against} holds {golden[0]} data, but the backend calculates in"
                f" {opened.precision}; make new data with restir golden --precision"
            )
        if golden:
            levels = golden_levels(passes, opened, _chosen(golden[1], selection))
        else:
            levels = ladder(passes, opened, seed, frames=not quick)
            if quick:
                levels = quick_levels(levels, not_asked)
            elif statistics and executor:
                away = Reached(backend, limits or Limits(), given, selection)
                runs = distributed_levels(away, opened, executor, remaining)
                levels = chain(levels, runs)
            elif statistics and selection.case is None:
                runs = statistical_levels(passes, opened, remaining)
                levels = chain(levels, runs)
        clock = time.monotonic
        left = remaining()
        verdict = run_ladder(
            passes, opened.precision, levels, left, clock, tell, said, extremes
        )
    except BaseException:
        opened.close()
        raise
    verdict = replace(verdict, left_running=opened.close(), not_asked=not_asked)
    if quick:
        not_asked.append("L4 whole runs")
        if verdict.status == "PASS":
            verdict = replace(verdict, status="QUICK")
    if selection.case is not None:
        verdict = _of_one_case(verdict, selection.case)
    return _with_missing(_with_offer(verdict, passes, opened), require)


def _own_declaration(backend: Any) -> Declaration:
    """What a backend that was reached says of itself, if it does."""
    given = getattr(backend, "declaration", None)
    return NOTHING_DECLARED if given is None else read_declaration(given)


def selection_of(
    only: Collection[str], skip: Collection[str], case: str | None = None
) -> Selection:
    """Which cases are asked.

    Raises UsageError: a pass is to be asked and left out.
    """
    both = sorted({*only} & {*skip})
    if both:
        raise UsageError(f"{both[0]} is to be asked alone and left out; take one away")
    return Selection(frozenset(only), frozenset(skip), case)


def _refuse_unknown(
    passes: Passes, selection: Selection, require: Collection[str]
) -> None:
    for name in (*require, *selection.only, *selection.skip):
        if name not in passes:
            raise UsageError(unknown("pass", name, passes))
    out = [name for name in require if not selection.holds(name)]
    if out:
        raise UsageError(f"{out[0]} is required and left out; take one away")


def _of_one_case(verdict: Verdict, name: str) -> Verdict:
    """What one case has shown.

    Raises UsageError: no case is called so.
    """
    steps = [timed.step for timed in verdict.steps]
    found = [a for step in steps for a in step.answers if a.probe.case.name == name]
    if not found and not verdict.left and not verdict.unasked:
        raise UsageError(
            f"no case is called {name!r}; the report of a check names those that failed"
        )
    absent = [a.probe.case.pass_name for a in found if a.finding is None]
    return replace(verdict, absent=absent)


def _chosen(probes: list[Probe], selection: Selection) -> list[Probe]:
    """Questions of a golden folder that are asked."""
    if selection.case is None:
        return [p for p in probes if selection.holds(p.case.pass_name)]
    names = [probe.case.name for probe in probes]
    if selection.case not in names:
        raise UsageError(unknown("case", selection.case, names))
    return [probe for probe in probes if probe.case.name == selection.case]


def _with_offer(verdict: Verdict, passes: Passes, backend: SelectedBackend) -> Verdict:
    """Names that look like a pass, and what is absent though no case was made of it.

    A backend that has such names alone is wrong: it was meant to be judged.
    """
    asked = [name for name in passes if backend.selection.holds(name)]
    none = backend.offer is not None and backend.selection.case is None
    absent = [
        name
        for name in asked
        if name in verdict.absent or (none and backend.lacks(name))
    ]
    near = [
        f"{name} is no pass of the contract; did you mean {like}?"
        for name, like in (backend.offer.near if backend.offer else ())
        if like in asked
    ]
    verdict = replace(verdict, absent=absent, near=near)
    if near and not verdict.judged:
        return replace(verdict, status="FAIL")
    return verdict


def _with_missing(verdict: Verdict, require: Collection[str]) -> Verdict:
    """Required passes of which nothing is known; the verdict fails if there are any."""
    missing = [
        f"{name} is required, and "
        + (
            "the backend does not have it"
            if name in verdict.absent
            else "no step that was taken judged it"
        )
        for name in require
        if name not in verdict.judged
    ]
    if not missing:
        return verdict
    return replace(verdict, status="FAIL", missing=missing)


def unjudged(verdict: Verdict) -> list[str]:
    """Why a verdict that is not FAIL still says too little to be a success.

    Nothing was judged, or the time was over before level L3 was done; a line each.
    """
    early = [title for title in verdict.left if not title.startswith("L4")]
    lines = [f"no time was left for {title}" for title in early]
    for timed in verdict.steps:
        if timed.step.level != "L4":
            lines += timed.step.unasked
    if not verdict.judged and not lines:
        return ["nothing was judged: the backend has no pass of the contract"]
    return lines


def _how(verdict: Verdict) -> str:
    wrong = verdict.wrong or verdict.missing or verdict.near
    return "biased by design" if verdict.unaccepted and not wrong else "wrong"


def told(verdict: Verdict) -> str:
    """What is wrong, for the failure of a test.

    A line for each fault, at most three a step, and the names of the mistakes.
    """
    lines = [f"the backend is {_how(verdict)} ({verdict.status}):"]
    lines += [f"  {line}" for line in (*verdict.missing, *verdict.near)]
    lines += [f"  {one.text}" for one in verdict.biases if not one.accepted]
    if verdict.unaccepted:
        lines.append(f"  {verdict.to_accept}")
    untrue = ("otherwise", "unknown", "not asked")
    lines += [f"  {one.text}" for one in verdict.followed if one.state in untrue]
    if not verdict.wrong:
        return "\n".join(lines)
    for timed in verdict.steps:
        lines += [f"  {timed.step.level} {text}" for text in timed.step.faults[:3]]
    for one in verdict.diagnoses:
        lines.append(f"  {one.pass_name}: {one.text}")
    return "\n".join(lines)
