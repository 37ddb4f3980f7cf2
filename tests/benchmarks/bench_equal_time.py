"""Mean squared error against the path tracer's in equal time, as in Figure 13.

    python -m tests.benchmarks.bench_equal_time [SCENE] [SIZE] [RUNS] [KEY=VALUE ...]

A frame of ReSTIR GI takes the time of n path-traced samples a pixel, whose error is
the error of one over n.  The picture is the 32nd frame, and the time is that of one
frame in the steady state, as in the paper; beside it stands the stricter reading, the
mean of all 32 frames against a path tracer given the time of all 32.  Settings of
ReSTIR GI are the paper's but for what KEY=VALUE changes, as with ``--set``.
"""

import statistics
import sys
import time
from dataclasses import replace

import numpy as np

from reference.passes.gbuffer import visible_points
from reference.path_tracer import camera_radiance
from reference.records import cut
from reference.restir_gi import render_frames
from reference.rng import KeyedUniforms, Stream
from reference.scene.camera import pixel_centers
from reference.scene.catalogue.registry import find_scene
from reference.schedule import Schedule, in_bands
from reference.setting_values import with_values
from reference.settings import BIASED, UNBIASED
from reference.world import build_world

FRAMES = 32
SCHEDULE = Schedule()


def main(name: str, size: int, runs: int, changes: list[str]) -> None:
    samples = 3000
    scene = find_scene(name)
    camera = replace(scene.camera, width=size, height=size)
    world = build_world(replace(scene, camera=camera))
    x, y = pixel_centers(size, size)
    visible = visible_points(world, x, y)
    count = size * size

    def path_trace(frame: int) -> np.ndarray:
        def band(r: slice) -> np.ndarray:
            pixel = np.arange(r.start, r.stop, dtype=np.uint32)
            u = KeyedUniforms(pixel, frame, 1 << 20, Stream.PATH)
            return camera_radiance(world, cut(visible.surface, r), "indirect", 1, u)

        return in_bands(SCHEDULE, count, band)

    total, squares = np.zeros((count, 3)), np.zeros((count, 3))
    for frame in range(samples):
        color = path_trace(frame)
        total += color
        squares += color**2
    truth = total / samples
    variance = squares / samples - truth**2
    of_one, of_truth = variance.mean(), variance.mean() / samples
    print(f"{name} {size} x {size}: truth of {samples} samples a pixel, {runs} runs")
    for label, start_from in (("unbiased", UNBIASED), ("biased", BIASED)):
        settings = with_values(start_from, changes)
        errors, mean_errors, frame_times, run_times, path_times = [], [], [], [], []
        for seed in range(runs):
            mean, seconds = np.zeros((count, 3)), []
            frames = render_frames(world, settings, 1, seed, SCHEDULE)
            for _ in range(FRAMES):
                start = time.perf_counter()
                frame = next(frames)
                seconds.append(time.perf_counter() - start)
                mean += frame.color / FRAMES
            start = time.perf_counter()
            for i in range(8):
                path_trace(samples + i)
            path_times.append((time.perf_counter() - start) / 8)
            frame_times.append(statistics.median(seconds[-8:]))
            run_times.append(sum(seconds))
            errors.append(((frame.color - truth) ** 2).mean() - of_truth)
            mean_errors.append(((mean - truth) ** 2).mean() - of_truth)
        path_time = statistics.median(path_times)
        print_ratio(f"{label:9} frame 32", errors, of_one, frame_times, path_time)
        print_ratio(f"{label:9} mean of 32", mean_errors, of_one, run_times, path_time)


def print_ratio(
    label: str,
    errors: list[float],
    of_one: float,
    seconds: list[float],
    path_time: float,
) -> None:
    taken = statistics.median(seconds)
    equal = of_one * path_time / taken
    rng = np.random.default_rng(0)
    draws = rng.choice(errors, (2000, len(errors))).mean(axis=1)
    low, high = equal / np.quantile(draws, [0.975, 0.025])
    print(
        f"{label:20} {taken * 1e3:7.1f} ms = {taken / path_time:5.1f} path-traced"
        f" samples; error {equal / np.mean(errors):5.1f} x smaller"
        f" [{low:.1f}, {high:.1f}]",
        flush=True,
    )


if __name__ == "__main__":
    scene = sys.argv[1] if len(sys.argv) > 1 else "door-ajar"
    size = int(sys.argv[2]) if len(sys.argv) > 2 else 128
    main(scene, size, int(sys.argv[3]) if len(sys.argv) > 3 else 8, sys.argv[4:])
