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
import os
import platform
import statistics
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from reference.passes.gbuffer import visible_points
from reference.restir_gi import next_frame
from reference.scene.camera import pixel_centers
from reference.scene.catalogue.registry import find_scene
from reference.scene.loaders.load import load_scene
from reference.scene.scene import Scene
from reference.scene.validation import validate
from reference.schedule import Schedule
from reference.settings import UNBIASED
from reference.version import project_version
from reference.world import build_world
from tests.benchmarks.bench_cost import bumpy_box

FRAMES, WARM, SEEDS, ROUNDS = 8, 24, 3, 5
THREADS = os.cpu_count() or 1
LAUNCH = 16
"""Samples a pixel in a launch of Mitsuba's."""

SCENES = ("cornell-box", "bumpy-box", "grazing-light", "door-ajar", "veach-ajar")


def real_scene() -> Path:
    return Path(os.environ["RESTIR_SCENES"]) / "veach-ajar" / "simple" / "scene.xml"


def ours(name: str, size: int) -> Scene:
    if name == "veach-ajar":
        scene = load_scene(real_scene())
    else:
        scene = bumpy_box() if name == "bumpy-box" else find_scene(name)
    return validate(
        replace(scene, camera=replace(scene.camera, width=size, height=size))
    )


def theirs(name: str, size: int, bounces: int):
    from tests.benchmarks.mitsuba_side import Indirect, from_file, translated

    if name == "veach-ajar":
        return Indirect(from_file(real_scene(), size, size), bounces)
    return Indirect(translated(ours(name, size)), bounces)


class Runner:
    """Frames of ReSTIR GI, one after the other."""

    def __init__(self, name: str, size: int, bounces: int, seed: int) -> None:
        self.world = build_world(ours(name, size))
        self.visible = visible_points(self.world, *pixel_centers(size, size))
        self.bounces, self.seed, self.last = bounces, seed, None

    def step(self) -> np.ndarray:
        """Indirect light of the next frame."""
        schedule = Schedule(threads=THREADS)
        self.last = next_frame(
            self.world, UNBIASED, self.bounces, self.seed, schedule, self.visible,
            self.last,
        )  # fmt: skip
        return self.last.color


def squares(a: np.ndarray, truth: np.ndarray) -> float:
    """Mean square over the mean square of the truth and a hundredth of its mean's."""
    scale = truth**2 + 0.01 * truth.mean() ** 2
    return float(np.mean(a / scale))


def errors(name: str, size: int, bounces: int, samples: int):
    """Error of a frame after FRAMES and after WARM, and of one sample of theirs."""
    mitsuba = theirs(name, size, bounces)
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
    mitsuba, runner = theirs(name, size, bounces), Runner(name, size, bounces, 0)
    for _ in range(WARM):
        runner.step()
    mitsuba.estimate(LAUNCH, 0)
    turns = [
        (timed(runner.step), timed(mitsuba.estimate, LAUNCH, k + 1) / LAUNCH)
        for k in range(ROUNDS)
    ]
    a, b = (statistics.median(column) for column in zip(*turns, strict=True))
    return a, b


def started(*arguments: object) -> float:
    """Seconds of a process of its own."""
    command = [
        sys.executable,
        "-m",
        "tests.benchmarks.bench_mitsuba",
        *map(str, arguments),
    ]
    return timed(lambda: subprocess.run(command, check=True))


def cold(name: str, size: int, bounces: int, samples: float) -> tuple[float, float]:
    """Seconds from nothing to the error after FRAMES, ours and theirs; medians of 3."""
    launches = max(1, round(samples / LAUNCH))
    turns = [
        (
            started("--ours", name, size, bounces),
            started("--theirs", name, size, bounces, launches),
        )
        for _ in range(3)
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
    if sys.argv[1:2] == ["--ours"]:
        name, size, bounces = sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
        runner = Runner(name, size, bounces, 0)
        for _ in range(FRAMES + 1):
            runner.step()
        return
    if sys.argv[1:2] == ["--theirs"]:
        name, (size, bounces, launches) = sys.argv[2], map(int, sys.argv[3:6])
        theirs(name, size, bounces).many(launches * LAUNCH, 0, LAUNCH)
        return
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
