"""Runs of a method: one seed each, and the time that a step takes."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.methods import Job, Layers, Method
from restir_gi.reference.methods.path import PATH
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.reports.timing import timed

CONVERGED = 8  # last steps of a run, whose median time counts
TRIAL = 33  # samples by which the time of one is measured


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Independent runs of one method.

    Attributes
    ----------
    job : Job; of the first run
    colors : list of (N, 3) float64; the picture of each run
    seconds : float
        That one picture takes: the median of the last frames of each run, or, where
        samples are averaged, of all samples together.
    rays : Counter of str; traced by the first run
    """

    method: Method
    job: Job
    colors: list[Vec3s]
    seconds: float
    rays: Counter[str]


def runs_of_frames(method: Method, job: Job, count: int) -> Runs:
    """Run a method that reuses samples over frames, and time its last frames.

    Parameters
    ----------
    job : Job; of the first run; the others have the next seeds

    Returns
    -------
    Runs; seconds are those of one frame at the end of a run
    """
    colors, times, rays = [], [], Counter[str]()
    for run in range(count):
        before = Counter(job.world.caster.counts)
        layers, steps = timed_run(method, replace(job, seed=job.seed + run))
        colors.append(layers["color"])
        times += steps[-CONVERGED:]
        rays = rays or job.world.caster.counts - before
    return Runs(method, job, colors, float(np.median(times)), rays)


def runs_of_paths(job: Job, seconds: float, count: int) -> Runs:
    """Trace paths for a given time, of as many whole samples as fit best, at least one.

    Parameters
    ----------
    job : Job; of the first run, with any number of samples
    """
    trials = [
        timed_run(PATH, replace(job, counts={"spp": TRIAL}))[1] for _ in range(count)
    ]
    # The first step is one sample and the camera rays.
    a_sample = float(np.median([sum(steps[1:]) for steps in trials])) / (TRIAL - 1)
    job = replace(job, counts={"spp": max(1, round(seconds / a_sample))})
    runs = runs_of_frames(PATH, job, count)
    return replace(runs, seconds=job.counts["spp"] * a_sample)


def timed_run(method: Method, job: Job) -> tuple[Layers, list[float]]:
    """Render, with a clock.  The result, and the time of each step."""
    steps, seconds = method.render(job), list[float]()
    while True:
        try:
            seconds.append(timed(steps.__next__).seconds)
        except StopIteration as end:
            layers: Layers = end.value
            return layers, seconds
