"""Every table and every figure of the documentation, made anew.

    python -m tests.benchmarks OUT [--quick] [NAME ...]

Takes some hours; ``--quick`` makes all but the costs small, in half an hour.  Each goes
into a folder or a file of its own, and ``index.md`` tells the machine, the version, and
how long each took.  What is there is not made again: an interrupted run goes on.
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

from restir_gi.reference.scene.catalogue.registry import CATALOGUE
from restir_gi.reference.system.machine import machine

PYTHON = sys.executable
RESTIR = [PYTHON, "-m", "restir_gi.reference"]


def bench(name: str, *words: str) -> list[str]:
    return [PYTHON, "-m", f"tests.benchmarks.bench_{name}", *words]


def parts(out: Path, quick: bool) -> dict[str, list[str]]:
    """Commands by name; those that print, print into ``NAME.txt``."""
    few = ["--size", "32", "--runs", "4"] if quick else []
    sweep = ["--size", "24x24", "--runs", "4", "--design", "3"] if quick else []
    found = {
        "figures": [*RESTIR, "figures", "--out", str(out / "figures"), *few],
        "tradeoff": [
            *RESTIR, "tradeoff", "cornell-box", "--out", str(out / "tradeoff"), *sweep,
        ],
    }  # fmt: skip
    frames = "8" if quick else "32"
    for scene in CATALOGUE:
        found[f"plan-{scene}"] = [*RESTIR, "plan", scene, "--frames", frames]
    found["cost"] = bench("cost")
    runs, size = ("4", "24") if quick else ("40", "48")
    found["options"] = bench("options", "cornell-box", runs, size)
    found["equal-time"] = bench(
        "equal_time", "door-ajar", *(["32", "3"] if quick else [])
    )
    found["reconstruction"] = bench("reconstruction")
    small = ["--size", "48", "--samples", "128"] if quick else []
    found["mitsuba"] = bench("mitsuba", *small)
    if "RESTIR_SCENES" in os.environ:
        scene = Path(os.environ["RESTIR_SCENES"]) / "veach-ajar/simple/scene.xml"
        words = [str(scene), "--out", str(out / "gradients"), *few]
        found["gradients"] = bench("gradients", *words)
    return found


def made(name: str, command: list[str], out: Path) -> str:
    """Run one, unless it was run; a line of the index."""
    printed = out / f"{name}.txt"
    if printed.exists():
        return f"| {name} | made before | {printed.name} |"
    start, unfinished = time.monotonic(), printed.with_suffix(".part")
    with unfinished.open("w") as stream:
        done = subprocess.run(command, stdout=stream, check=False)
    if done.returncode:
        return f"| {name} | failed: {' '.join(command)} | {unfinished.name} |"
    unfinished.rename(printed)
    return f"| {name} | {time.monotonic() - start:.0f} s | {printed.name} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_intermixed_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    known = parts(asked.out, asked.quick)
    lines = [f"* {key}: {value}" for key, value in machine().items()]
    lines += ["", "| what | took | printed |", "|---|---|---|"]
    for name in asked.names or known:
        lines.append(made(name, known[name], asked.out))
        print(lines[-1], flush=True)
        (asked.out / "index.md").write_text("\n".join(lines) + "\n")
    return int(any("| failed" in line for line in lines))


if __name__ == "__main__":
    sys.exit(main())
