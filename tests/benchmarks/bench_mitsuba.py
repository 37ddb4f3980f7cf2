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
from dataclasses import astuple
from functools import partial

import numpy as np

from restir_gi.reference.numerics.intervals import bootstrap_interval
from restir_gi.reference.reports.timing import in_turns, seconds_in_turns, timed
from restir_gi.reference.system.version import project_version
from tests.benchmarks.mitsuba_side import LAUNCH, opened
from tests.benchmarks.our_side import THREADS, Runner

FRAMES, WARM, SEEDS, TURNS, COLD_TURNS = 8, 24, 4, 9, 3
GROUPS = 8  # of launches, each of which estimates the variance of a sample
SCENES = ("cornell-box", "bumpy-box", "grazing-light", "door-ajar", "veach-ajar")


def squares(a: np.ndarray, truth: np.ndarray) -> float:
    """Mean square over the mean square of the truth and a hundredth of its mean's."""
    scale = truth**2 + 0.01 * truth.mean() ** 2
    return float(np.mean(a / scale))


def errors(name: str, size: int, bounces: int, samples: int):
    """Error of frames FRAMES and WARM of each seed, and of one sample of theirs."""
    mitsuba = opened(name, size, bounces)
    count = max(GROUPS * 4, samples // LAUNCH)
    launches = np.array([mitsuba.estimate(LAUNCH, 1000 + k) for k in range(count)])
    truth = launches.mean(axis=0)
    one = [
        squares(group.var(axis=0, ddof=1) * LAUNCH, truth)
        for group in np.array_split(launches, GROUPS)
    ]
    off = squares(launches.var(axis=0, ddof=1) / count, truth)
    cold, warm, means = [], [], []
    for seed in range(SEEDS):
        runner = Runner(name, size, bounces, seed)
        for number in range(WARM + 1):
            color = runner.step()
            means.append(color.mean())
            if number in (FRAMES, WARM):
                error = squares((color - truth) ** 2, truth) - off
                (cold if number == FRAMES else warm).append(error)
    return cold, warm, one, float(np.mean(means) / truth.mean())


def steady(name: str, size: int, bounces: int) -> list[list[float]]:
    """Seconds of frames of ours, of a sample of theirs, and of one of their picture."""
    mitsuba, runner = opened(name, size, bounces), Runner(name, size, bounces, 0)
    for _ in range(WARM):
        runner.step()
    mitsuba.estimate(LAUNCH, 0)
    mitsuba.render(LAUNCH, 0)
    calls = {
        "frame": runner.step,
        "sample": partial(mitsuba.estimate, LAUNCH, 1),
        "picture": partial(mitsuba.render, LAUNCH, 1),
    }
    frames, *launches = seconds_in_turns(calls, TURNS).values()
    return [frames, *([seconds / LAUNCH for seconds in turn] for turn in launches)]


def started(module: str, *arguments: object) -> float:
    """Seconds of a process of its own, less those that it says were for translation."""
    words = [sys.executable, "-m", f"tests.benchmarks.{module}", *map(str, arguments)]
    run = partial(subprocess.run, words, check=True, capture_output=True, text=True)
    done, spent = timed(run)
    return spent - float(done.stdout or 0)


def cold(name: str, size: int, bounces: int, samples: float) -> list[list[float]]:
    """Seconds from nothing to the error after FRAMES, ours and theirs, in turns."""
    about = name, size, bounces
    calls = {
        "ours": partial(started, "our_side", *about, FRAMES + 1),
        "theirs": partial(started, "mitsuba_side", *about, max(1, round(samples))),
    }
    turns = list(in_turns(calls, COLD_TURNS))
    return [[turn[name].result for turn in turns] for name in calls]


def ahead(one: list[float], warm: list[float], times: list[float]) -> list[float]:
    """Samples to our error times the ratio of seconds: value, and 95 % by bootstrap.

    Resampled are our seeds, groups of their launches, and turns.
    """
    errors, others, ratios = map(np.array, (one, warm, times))

    def faster(launch, seed, turn):
        needed = errors[launch].mean(axis=-1) / others[seed].mean(axis=-1)
        return np.maximum(needed, 1.0) * np.median(ratios[turn], axis=-1)

    return list(astuple(bootstrap_interval(faster, len(one), len(warm), len(times))))


def compared(name: str, size: int, bounces: int, samples: int) -> dict[str, object]:
    cold_errors, warm, one, mean = errors(name, size, bounces, samples)
    ours, theirs, whole = steady(name, size, bounces)
    needed = max(1.0, statistics.mean(one) / statistics.mean(cold_errors))
    from_nothing = cold(name, size, bounces, needed)
    turns = [b / a for a, b in zip(*from_nothing, strict=True)]
    ratios = [b / a for a, b in zip(ours, theirs, strict=True)]
    return {
        "scene": name,
        "bounces": bounces,
        "relMSE": statistics.mean(warm),
        "frame, s": statistics.median(ours),
        "Mitsuba, samples": statistics.mean(one) / statistics.mean(warm),
        "Mitsuba, M paths/s": size * size / statistics.median(theirs) / 1e6,
        "their picture of all light, M paths/s": size
        * size
        / statistics.median(whole)
        / 1e6,
        "ahead": ahead(one, warm, ratios),
        "cold relMSE": statistics.mean(cold_errors),
        "cold, s": statistics.median(from_nothing[0]),
        "cold Mitsuba, samples": needed,
        "cold Mitsuba, s": statistics.median(from_nothing[1]),
        "cold ahead": [statistics.median(turns), min(turns), max(turns)],
        "mean, ours over theirs": mean,
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
