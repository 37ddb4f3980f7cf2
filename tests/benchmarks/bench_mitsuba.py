"""Indirect light to the same error: ReSTIR GI here beside Mitsuba 3, LLVM variant.

    python -m tests.benchmarks.bench_mitsuba [--size N] [--samples N] [SCENE ...]

One and two bounces, both on all threads, through pixel centres, in turns.  Prints for
each scene the time to the same relMSE from a cold start (a new process, until the frame
after `FRAMES` others) and for a frame of the steady state, with the ratio of both.
Mitsuba's error falls as one over its samples; its seconds are those of the samples that
it takes to the error of ours.  The truth is Mitsuba's, and its own variance is
subtracted.
"""

import argparse
import json
import platform
import statistics
import subprocess
import sys
import time

import numpy as np

from reference.version import project_version
from tests.benchmarks.mitsuba_side import LAUNCH, opened
from tests.benchmarks.our_side import THREADS, Runner

FRAMES, WARM, SEEDS, ROUNDS = 8, 24, 3, 5
SCENES = ("cornell-box", "bumpy-box", "grazing-light", "door-ajar", "veach-ajar")


def squares(a: np.ndarray, truth: np.ndarray) -> float:
    """Mean square over the mean square of the truth and a hundredth of its mean's."""
    scale = truth**2 + 0.01 * truth.mean() ** 2
    return float(np.mean(a / scale))


def errors(name: str, size: int, bounces: int, samples: int):
    """Error of a frame after FRAMES and after WARM, and of one sample of theirs."""
    mitsuba = opened(name, size, bounces)
    launches = np.array(
        [mitsuba.estimate(LAUNCH, 1000 + k) for k in range(max(8, samples // LAUNCH))]
    )
    truth = launches.mean(axis=0)
    variance = launches.var(axis=0, ddof=1)
    one = squares(variance * LAUNCH, truth)
    off = squares(variance / len(launches), truth)
    cold, warm, means = [], [], []
    for seed in range(SEEDS):
        runner = Runner(name, size, bounces, seed)
        for number in range(WARM + 1):
            color = runner.step()
            means.append(color.mean())
            if number in (FRAMES, WARM):
                error = squares((color - truth) ** 2, truth) - off
                (cold if number == FRAMES else warm).append(error)
    return {
        "ours, cold": statistics.mean(cold),
        "ours": statistics.mean(warm),
        "theirs, a sample": one,
        "mean, ours over theirs": float(np.mean(means) / truth.mean()),
    }


def timed(function, *arguments) -> float:
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def steady(name: str, size: int, bounces: int) -> tuple[float, float]:
    """Seconds of a frame of ours, and of a sample of theirs; medians of turns."""
    mitsuba, runner = opened(name, size, bounces), Runner(name, size, bounces, 0)
    for _ in range(WARM):
        runner.step()
    mitsuba.estimate(LAUNCH, 0)
    turns = [
        (timed(runner.step), timed(mitsuba.estimate, LAUNCH, k + 1) / LAUNCH)
        for k in range(ROUNDS)
    ]
    a, b = (statistics.median(column) for column in zip(*turns, strict=True))
    return a, b


def started(module: str, *arguments: object) -> float:
    """Seconds of a process of its own, less those that it says were for translation."""
    words = [sys.executable, "-m", f"tests.benchmarks.{module}", *map(str, arguments)]
    start = time.perf_counter()
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    spent = time.perf_counter() - start
    return spent - float(done.stdout or 0)


def cold(name: str, size: int, bounces: int, samples: float) -> tuple[float, float]:
    """Seconds from nothing to the error after FRAMES, ours and theirs; medians."""
    about = name, size, bounces
    turns = [
        (
            started("our_side", *about, FRAMES + 1),
            started("mitsuba_side", *about, max(1, round(samples))),
        )
        for _ in range(ROUNDS)
    ]
    a, b = (statistics.median(column) for column in zip(*turns, strict=True))
    return a, b


def compared(name: str, size: int, bounces: int, samples: int) -> dict[str, object]:
    error = errors(name, size, bounces, samples)
    frame, sample = steady(name, size, bounces)
    needed = max(1.0, error["theirs, a sample"] / error["ours"])
    needed_cold = max(1.0, error["theirs, a sample"] / error["ours, cold"])
    a, b = cold(name, size, bounces, needed_cold)
    return {
        "scene": name,
        "bounces": bounces,
        "relMSE": error["ours"],
        "frame, s": frame,
        "Mitsuba, samples": needed,
        "Mitsuba, s": needed * sample,
        "steady ratio": needed * sample / frame,
        "cold relMSE": error["ours, cold"],
        "cold, s": a,
        "cold Mitsuba, s": b,
        "cold ratio": b / a,
        "M paths/s": size * size / sample / 1e6,
        "mean, ours over theirs": error["mean, ours over theirs"],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--samples", type=int, default=2048)
    asked = parser.parse_args()
    print(f"{project_version()}, {platform.processor() or platform.machine()},"
          f" {THREADS} threads, {asked.size} x {asked.size}")  # fmt: skip
    for name in asked.scenes:
        for bounces in (1, 2):
            row = compared(name, asked.size, bounces, asked.samples)
            print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
