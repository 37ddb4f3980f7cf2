"""Kill ``restir reference`` and ``restir tradeoff`` at random moments, over and over.

    python -m tests.extremes.kills --count 50 --seed 1

prints for each kill when it came and how many processes were left, and in the end
whether the results of the command that went on are those of one that was never killed,
to the last bit, and each ray was counted once.  The exit code is 1 where anything is
not as it should be.
"""

import argparse
import io
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.oracle.backends.descendants import end_marked, marked

ROOT = Path(__file__).parents[2]
GRACE = 10.0  # seconds within which the processes of a killed command are gone


@dataclass(frozen=True)
class KilledCommand:
    """What is killed.

    Attributes
    ----------
    name : str
        Of the command.
    words : tuple of str
        Its arguments but for --out.
    out : str
        Name of what it writes.
    result : callable
        From the path of what it wrote to what must be the same.
    """

    name: str
    words: tuple[str, ...]
    out: str
    result: Callable[[Path], dict[str, object]]


def picture(path: Path) -> dict[str, object]:
    """Bits of the layers, and the rays that were counted."""
    image = read_exr(path)
    layers = {name: layer.tobytes() for name, layer in image.layers.items()}
    rays = {k: v for k, v in image.metadata.items() if k.startswith("rays.")}
    return {**layers, **rays}


def runs(folder: Path) -> dict[str, object]:
    """Bits of all runs, and their rays; the time that a run took is its own."""
    found: dict[str, object] = {}
    for path in sorted(folder.glob("runs/*/*.npz")):
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as file:
            name = path.relative_to(folder).as_posix()
            for layer in ("color", "mean", "tiles"):
                found[f"{name} {layer}"] = file[layer].tobytes()
            words = str(file["words"])
            found[f"{name} rays"] = words[words.index('"rays"') :]
    return found


COMMANDS = (
    KilledCommand(
        "reference",
        ("cornell-box", "--size", "24x24", "--spp", "300", "--checkpoint", "0"),
        "truth.exr",
        picture,
    ),
    KilledCommand(
        "tradeoff",
        (
            *("cornell-box", "--size", "16x16", "--runs", "6", "--frames", "4"),
            *("--spp", "16", "--design", "0", "--sweep", "radius=0.1,0.2"),
            *("--processes", "2"),
        ),
        "results",
        runs,
    ),
)


@contextmanager
def started(
    command: KilledCommand, folder: Path
) -> Iterator[tuple[str, subprocess.Popen]]:
    """A run of a command, and the mark that all its processes bear."""
    mark = f"RESTIR_KILLS_{os.getpid()}_{time.monotonic_ns()}"
    words = [sys.executable, "-m", "restir_gi.reference", command.name, *command.words]
    words += ["--out", str(folder / command.out)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = {**os.environ, mark: "1"}
    run = subprocess.Popen(words, cwd=ROOT, env=environment, **quiet)
    try:
        yield mark, run
    finally:
        end_marked(mark)
        run.wait()


def left_of(mark: str) -> int:
    """Processes that are still there when the grace is over."""
    end = time.monotonic() + GRACE
    while (found := marked(mark)) and time.monotonic() < end:
        time.sleep(0.02)
    return len(found)


def whole(command: KilledCommand, folder: Path) -> dict[str, object]:
    """The result of a command that nobody kills."""
    with started(command, folder) as (_, run):
        if run.wait() != 0:
            raise RuntimeError(f"restir {command.name} ended with {run.returncode}")
    return command.result(folder / command.out)


def killed(
    command: KilledCommand, count: int, rng: random.Random, tell: Callable[[str], None]
) -> bool:
    """Kill a command so often, and hold what comes of it against one left alone."""
    with tempfile.TemporaryDirectory() as place:
        start = time.monotonic()
        truth = whole(command, Path(place))
        seconds = time.monotonic() - start
    left, bad, done, kills = 0, 0, 0, 0
    while kills < count:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            ended = False
            while kills < count and not ended:
                after = rng.uniform(0.0, seconds)
                with started(command, folder) as (mark, run):
                    try:
                        ended = run.wait(after) == 0
                        continue
                    except subprocess.TimeoutExpired:
                        run.kill()
                        run.wait()
                    kills += 1
                    here = left_of(mark)
                left += here
                tell(f"{command.name} {kills}: after {after:.2f} s, {here} left")
            found = whole(command, folder)
            done += 1
            differ = [n for n in {*truth, *found} if truth.get(n) != found.get(n)]
            if stale := [p.name for p in folder.rglob("*.part")]:
                differ.append(f"stale {stale}")
            bad += bool(differ)
            if differ:
                tell(f"{command.name}: {', '.join(sorted(differ)[:5])} differ")
    tell(
        f"{command.name}: {kills} kills, {left} processes left; {done - bad} of {done}"
        " results that went on are the same to the last bit, rays counted once"
    )
    return left == 0 and bad == 0


def main(words: list[str] | None = None) -> int:
    """Kill, and say how it went."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=50, help="kills of each command")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=[c.name for c in COMMANDS])
    given = parser.parse_args(words)
    rng = random.Random(given.seed)
    chosen = [c for c in COMMANDS if given.only in (None, c.name)]

    def tell(line: str) -> None:
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()

    fine = [killed(command, given.count, rng, tell) for command in chosen]
    return 0 if all(fine) else 1


if __name__ == "__main__":
    sys.exit(main())
