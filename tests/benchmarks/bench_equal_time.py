"""Mean squared error against the path tracer's in equal time, as in Figure 13.

    python -m tests.benchmarks.bench_equal_time [SCENE] [SIZE] [RUNS] [KEY=VALUE ...]

A frame of ReSTIR GI takes the time of n path-traced samples a pixel, whose error is
the error of one over n.  The picture is the 32nd frame, and the time is that of one
frame in the steady state, as in the paper; beside it stands the stricter reading, the
mean of all 32 frames against a path tracer given the time of all 32.  Settings of
ReSTIR GI are the paper's but for what KEY=VALUE changes, as with ``--set``.
"""

import sys

import numpy as np

from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.intervals import Numbers, ratio_interval
from restir_gi.reference.numerics.moments import add_samples, no_samples
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.timing import timed
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import BIASED, UNBIASED
from restir_gi.reference.transport.accumulate import ever_more, path_samples
from restir_gi.reference.transport.world import build_world
from tests.benchmarks.scenes import sized

FRAMES, LAST, PATHS, SAMPLES = 32, 8, 8, 3000
SCHEDULE = Schedule()


def main(name: str, size: int, runs: int, changes: list[str]) -> None:
    world = build_world(sized(find_scene(name), size, size))
    paths = path_samples(world, SCHEDULE, light="indirect", bounces=1, seed=1 << 20)
    none = no_samples(paths.rows)
    truth = add_samples(none, paths.radiance, SAMPLES, SCHEDULE)
    of_truth = (truth.standard_error() ** 2).mean()
    of_one = truth.variance().mean()
    print(f"{name} {size} x {size}: truth of {SAMPLES} samples a pixel, {runs} runs")
    for label, start_from in (("unbiased", UNBIASED), ("biased", BIASED)):
        settings = with_values(start_from, changes)
        drawn = ever_more(paths, PATHS, SCHEDULE)
        of_last, of_mean, frame_times, run_times, path_times = [], [], [], [], []
        for seed in range(runs):
            frames = render_frames(world, settings, 1, seed, SCHEDULE)
            laps = [timed(frames.__next__) for _ in range(FRAMES)]
            path_times.append(timed(drawn.__next__).seconds / PATHS)
            seconds = [lap.seconds for lap in laps]
            frame_times.append(float(np.median(seconds[-LAST:])))
            run_times.append(sum(seconds))
            colors = [lap.result.color for lap in laps]
            mean = np.mean(colors, axis=0)
            of_last.append(((colors[-1] - truth.mean) ** 2).mean() - of_truth)
            of_mean.append(((mean - truth.mean) ** 2).mean() - of_truth)
        path_time = float(np.median(path_times))
        for what, errors, times in (
            ("frame 32", of_last, frame_times),
            ("mean of 32", of_mean, run_times),
        ):
            taken = float(np.median(times)) / path_time
            print_ratio(f"{label:9} {what}", np.array(errors), of_one, taken)


def print_ratio(label: str, errors: Numbers, of_one: float, taken: float) -> None:
    smaller = ratio_interval(np.full(len(errors), of_one / taken), errors)
    print(
        f"{label:20} the time of {taken:5.1f} path-traced samples; error"
        f" {smaller.value:5.1f} x smaller [{smaller.low:.1f}, {smaller.high:.1f}]",
        flush=True,
    )


if __name__ == "__main__":
    scene = sys.argv[1] if len(sys.argv) > 1 else "door-ajar"
    size = int(sys.argv[2]) if len(sys.argv) > 2 else 128
    main(scene, size, int(sys.argv[3]) if len(sys.argv) > 3 else 8, sys.argv[4:])
