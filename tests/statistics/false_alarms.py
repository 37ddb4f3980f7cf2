"""How often the oracle accuses a backend that is right.

From the root of the checkout, some ten seconds a run on one core::

    python -m tests.statistics.false_alarms --runs 1000 --out alarms.jsonl
    python -m tests.statistics.false_alarms --out two.jsonl --like RTXDI Bevy

Each run has seeds of its own: rows of the kernels, designed rows, relations, frames of
all scenes, runs of the mean and of the distribution; the lattices and spheres have no
seed and are run once.  A run is written as soon as it ends, and what is written is not
run again.  ``--like`` asks foreign backends that depart in several choices at once,
all of the same rows: what explained the first verdict on each is tried first in each
run, and is searched for again where it does not explain all.
"""

import argparse
import json
from collections.abc import Iterator
from itertools import product
from math import inf
from pathlib import Path
from time import perf_counter

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.selected import SelectedBackend, selected
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
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.steps import Level, LevelStep
from restir_gi.reference.oracle.verdict import Verdict, explicable, run_ladder
from tests.foreign.backends import SEVERAL

CONTRACT = whole_contract()
UNSEEDED = ("lattices", "spheres", "of 40 frames")
"""Ends of the titles of steps that are the same for every seed."""


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
    backend: SelectedBackend, seed: int, seconds: float, known: dict[str, Diagnosis]
) -> Iterator[str]:
    """What the oracle holds against a backend in one run.

    Parameters
    ----------
    known : dict of str to Diagnosis; what explained its first verdict, of each pass
    """
    levels = [one for one in ladder(CONTRACT, backend, seed) if is_seeded(one)]
    steps = [take() for *_, take in levels]
    if not is_explained(steps, known, backend.precision):
        verdict = verdict_of(backend, iter(levels))
        if verdict.status != "PASS":
            yield told(verdict)
    if seconds == 0 or backend.lacks(*LOOP):
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
    given = parser.parse_args()
    names = given.like or [None]
    backends = {name: backend_like(name) for name in names}
    known = {name: _known_of(name, backend) for name, backend in backends.items()}
    done = _read(given.out)
    seeds = range(given.first, given.first + given.runs)
    for seed, name in product(seeds, names):
        if (name, seed) not in done:
            found = list(faults(backends[name], seed, given.seconds, known[name]))
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
