"""How often the oracle accuses a backend that is right.

From the root of the checkout, some ten seconds a run on one core::

    python -m tests.statistics.false_alarms --runs 1000 --out alarms.jsonl
    python -m tests.statistics.false_alarms --out two.jsonl --like RTXDI Bevy
    python -m tests.statistics.false_alarms --out part.jsonl --part "hash grid"

Each run has seeds of its own: rows of the kernels, designed rows, relations, frames of
all scenes, runs of the mean and of the distribution; the lattices and spheres have no
seed and are run once.  A run is written as soon as it ends, and what is written is not
run again.  ``--like`` asks foreign backends that depart in several choices at once,
all of the same rows: what explained the first verdict on each is tried first in each
run, and is searched for again where it does not explain all.  ``--part`` asks the
passes of one part of the contract alone, those of declared settings too; with
``--like hand`` those that the tests have written by hand.
"""

import argparse
import json
from collections.abc import Iterator
from functools import partial
from itertools import product
from math import inf
from pathlib import Path
from time import perf_counter
from types import SimpleNamespace

import numpy as np

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.selected import (
    SelectedBackend,
    Selection,
    selected,
)
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.checking import told
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis
from restir_gi.reference.oracle.diagnosis.hypothesis import combined
from restir_gi.reference.oracle.diagnosis.subsets import explained, whole
from restir_gi.reference.oracle.ladder import LOOP, ladder
from restir_gi.reference.oracle.levels.distribution import SCENES as DISTRIBUTION_SCENES
from restir_gi.reference.oracle.levels.distribution import same_distribution
from restir_gi.reference.oracle.levels.means import mean_over_runs
from restir_gi.reference.oracle.parts import Part, parts, whole_contract
from restir_gi.reference.oracle.steps import Level, LevelStep, asked
from restir_gi.reference.oracle.verdict import Verdict, explicable, run_ladder
from tests.foreign.backends import SEVERAL
from tests.mutants.hash_grid_by_hand import HashGridByHand
from tests.mutants.pairs_by_hand import by_hand as pairs_by_hand

CONTRACT = whole_contract()
UNSEEDED = ("lattices", "spheres", "of 40 frames")
"""Ends of the titles of steps that are the same for every seed."""


def of_part(part: Part, backend: SelectedBackend, seed: int) -> list[Level]:
    """One step: all that a part asks with a seed."""
    precision = backend.precision
    probes = [*part.probes(precision, seed), *part.more(precision, seed)]
    ask = partial(asked, "L0", part.title, CONTRACT, backend, probes)
    return [("L0", part.title, ask)]


def is_seeded(level: Level) -> bool:
    """Whether a step asks other rows for another seed."""
    return not level[1].endswith(UNSEEDED)


def verdict_of(backend: SelectedBackend, levels: Iterator[Level]) -> Verdict:
    """What some steps say."""
    about = CONTRACT, backend.precision, levels, inf
    return run_ladder(*about, clock=perf_counter, tell=lambda _: None)


def is_explained(
    steps: list[LevelStep], known: dict[str, Diagnosis], precision: Precision
) -> bool:
    """Whether what explained an earlier verdict explains these steps as well.

    Then the verdict is PASS without a search: some innocent set reproduces every row.
    """
    kinds = {kind for diagnosis in known.values() for kind in diagnosis.kinds}
    bound = [f for step in steps if step.binds(kinds) for f in step.findings]
    answers = [answer for step in steps for answer in step.answers]
    wrong = [a for a in answers if a.finding and not a.finding.passed]
    names = {a.probe.case.pass_name for a in wrong}
    if any(not f.passed for f in bound) or not all(map(explicable, wrong)):
        return False
    if not names <= set(known):
        return False
    of_pass = {n: [a for a in answers if a.probe.case.pass_name == n] for n in names}
    return all(
        any(
            all(
                explained(whole(a.probe.case, a.outputs), combined(one), precision)
                for a in of_pass[name]
                if a.outputs is not None
            )
            for one in (e.hypotheses for e in known[name].explanations if e.innocent)
        )
        for name in names
    )


def faults(
    backend: SelectedBackend,
    seed: int,
    seconds: float,
    known: dict[str, Diagnosis],
    part: Part | None = None,
) -> Iterator[str]:
    """What the oracle holds against a backend in one run.

    Parameters
    ----------
    part : Part, optional; that is asked alone
    known : dict of str to Diagnosis; what explained its first verdict, of each pass
    """
    whole = ladder(CONTRACT, backend, seed)
    levels = of_part(part, backend, seed) if part else [*filter(is_seeded, whole)]
    steps = [take() for *_, take in levels]
    if not is_explained(steps, known, backend.precision):
        verdict = verdict_of(backend, iter(levels))
        if verdict.status != "PASS":
            yield told(verdict)
    if part or seconds == 0 or backend.lacks(*LOOP):
        return

    def ask(case: Case) -> Buffers:
        outcome = backend.run(CONTRACT, [case])[0]
        assert isinstance(outcome, dict)
        return outcome

    end = perf_counter() + seconds
    mean = mean_over_runs(
        ask, "float32", lambda: end - perf_counter(), first_seed=10**6 + 1000 * seed
    )
    distributions = [
        same_distribution(ask, "float32", s, seed=1000 + seed).finding
        for s in DISTRIBUTION_SCENES
    ]
    yield from (f.text for f in (mean.finding, *distributions) if not f.passed)


def backend_like(words: str | None) -> SelectedBackend:
    """The foreign backend whose name ends so; none: the built-in one."""
    if words is None:
        return selected(InsideBackend(BuiltIn("float32")))
    (found,) = (one for one in SEVERAL if one.name.endswith(words))
    return selected(InsideBackend(found.backend))


BY_HAND = {
    "hash grid": HashGridByHand("float32"),
    "differences of pixels": lambda name, **given: pairs_by_hand(
        Case(
            "",
            name,
            settings={n: v for n, v in given.items() if not isinstance(v, np.ndarray)},
            inputs={n: v for n, v in given.items() if isinstance(v, np.ndarray)},
        )
    ),
}
"""Parts that the tests have written by hand, from pass and arguments to outputs."""


def backend_of(part: Part, words: str | None) -> SelectedBackend:
    """The built-in backend of a part's passes, or the one by hand."""
    names = [one.name for one in part.passes]
    own = BuiltIn("float32")
    passes = {name: getattr(own, name) for name in names}
    if words is not None:
        passes = {name: partial(BY_HAND[part.title], name) for name in names}
    settings = [(one.name, s) for one in part.passes for s in one.settings]
    more = frozenset((name, s.name, word) for name, s in settings for word in s.more)
    inside = InsideBackend(SimpleNamespace(**passes))
    return SelectedBackend(inside, Selection(more=more))


def main() -> None:
    """Run, and tell how many runs had an alarm."""
    parser = argparse.ArgumentParser(description="Count the oracle's false alarms.")
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument(
        "--seconds",
        type=float,
        default=1.0,
        help="for the bets, which are valid at every time; 0 for no whole runs",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.jsonl")
    parser.add_argument(
        "--like", nargs="+", metavar="WORDS", help="that foreign backends' names end in"
    )
    parser.add_argument(
        "--part", metavar="TITLE", help="of the contract, which is asked alone"
    )
    given = parser.parse_args()
    names = given.like or [None]
    part = next((p for p in parts() if p.title == given.part), None)
    if given.part and part is None:
        parser.error(f"--part: known are {', '.join(p.title for p in parts())}")
    backends = {n: backend_of(part, n) if part else backend_like(n) for n in names}
    known = {
        name: {} if part else _known_of(name, backend)
        for name, backend in backends.items()
    }
    done = _read(given.out)
    seeds = range(given.first, given.first + given.runs)
    for seed, name in product(seeds, names):
        if (name, seed) not in done:
            found = list(faults(backends[name], seed, given.seconds, known[name], part))
            with given.out.open("a") as file:
                run = {"like": name, "seed": seed, "faults": found}
                file.write(json.dumps(run) + "\n")
    runs = _read(given.out)
    for name in names:
        of_name = {s: texts for (n, s), texts in runs.items() if n == name}
        alarms = {seed: texts for seed, texts in of_name.items() if texts}
        print(f"{name}: {len(alarms)} of {len(of_name)} runs had an alarm")
        for seed, texts in alarms.items():
            print(seed, *texts, sep="\n  ")


def _known_of(name: str | None, backend: SelectedBackend) -> dict[str, Diagnosis]:
    """What explains the verdict with the seed of the oracle itself."""
    first = verdict_of(backend, ladder(CONTRACT, backend))
    print(f"{name}: all steps, with their own seed: {first.status}", flush=True)
    return {one.pass_name: one for one in first.departures}


def _read(path: Path) -> dict[tuple[str | None, int], list[str]]:
    if not path.exists():
        return {}
    runs = [json.loads(line) for line in path.read_text().splitlines()]
    return {(run["like"], run["seed"]): run["faults"] for run in runs}


if __name__ == "__main__":
    main()
