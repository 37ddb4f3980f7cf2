"""How often the oracle accuses a backend that is right.

From the root of the checkout, some ten seconds a run on one core::

    python -m tests.statistics.false_alarms --runs 1000 --out alarms.jsonl

Each run has seeds of its own: rows of the kernels, frames of all scenes, runs of the
mean and of the distribution; the lattices and spheres have no seed and are run once.  A
run is written as soon as it ends, and what is written is not run again.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.ladder import ladder, scene_probes
from restir_gi.reference.oracle.levels.distribution import SCENES as DISTRIBUTION_SCENES
from restir_gi.reference.oracle.levels.distribution import same_distribution
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.means import mean_over_runs
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.prepared_frame import SCENES
from restir_gi.reference.oracle.steps import asked

CONTRACT = whole_contract()


def faults(seed: int, seconds: float) -> Iterator[str]:
    """What the oracle holds against the built-in backend in one run."""
    backend = InsideBackend(BuiltIn("float32"))
    probes = kernel_probes("float32", seed)
    for scene in SCENES:
        probes += scene_probes(scene, "float32", seed)
    yield from asked("", "", CONTRACT, backend, probes).faults

    def ask(case: Case) -> Buffers:
        outcome = backend.run(CONTRACT, [case])[0]
        assert isinstance(outcome, dict)
        return outcome

    if seconds == 0:
        return
    end = perf_counter() + seconds
    mean = mean_over_runs(
        ask, "float32", lambda: end - perf_counter(), first_seed=10**6 + 1000 * seed
    )
    distributions = [
        same_distribution(ask, "float32", s, seed=1000 + seed).finding
        for s in DISTRIBUTION_SCENES
    ]
    yield from (f.text for f in (mean.finding, *distributions) if not f.passed)


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
    given = parser.parse_args()
    done = _read(given.out)
    if not done:
        backend = InsideBackend(BuiltIn("float32"))
        for _, title, take in ladder(CONTRACT, backend):
            print(title, take().faults or "nothing", flush=True)
    for seed in range(given.first, given.first + given.runs):
        if seed not in done:
            found = list(faults(seed, given.seconds))
            with given.out.open("a") as file:
                file.write(json.dumps({"seed": seed, "faults": found}) + "\n")
    found = _read(given.out)
    alarms = {seed: texts for seed, texts in found.items() if texts}
    print(f"{len(alarms)} of {len(found)} runs had an alarm")
    for seed, texts in alarms.items():
        print(seed, *texts, sep="\n  ")


def _read(path: Path) -> dict[int, list[str]]:
    if not path.exists():
        return {}
    runs = [json.loads(line) for line in path.read_text().splitlines()]
    return {run["seed"]: run["faults"] for run in runs}


if __name__ == "__main__":
    main()
