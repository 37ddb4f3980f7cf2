"""Variants of ReSTIR GI side by side, and path tracing between their frames.

All that a figure compares runs in one process and takes turns frame by frame, so that
whatever else the machine does meanwhile slows all of them alike.  The path-traced
samples in between are the truth in the end.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images import metrics
from restir_gi.reference.methods import Job, Method, Rendering
from restir_gi.reference.numerics.arrays import Masks, Vec3s
from restir_gi.reference.numerics.intervals import Numbers
from restir_gi.reference.numerics.moments import Moments, merge
from restir_gi.reference.reports.demo.runs import CONVERGED, Runs
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.timing import in_turns, timed
from restir_gi.reference.transport.accumulate import ever_more, path_samples
from restir_gi.reference.transport.world import World

FRAMES = 32  # as in Figure 13
PATH_SEED = 1_000_003  # another than that of any run


@dataclass(frozen=True, slots=True, eq=False)
class Contender:
    """A variant of ReSTIR GI.

    Attributes
    ----------
    method : Method; one that yields once a frame, with the settings of the variant
    bounces : int; bounces of indirect light
    """

    name: str
    method: Method
    bounces: int


@dataclass(frozen=True, slots=True, eq=False)
class Contest:
    """What a contest leaves behind.

    Attributes
    ----------
    bounces : int; bounces of the truth
    batches : list of Moments; path-traced samples drawn beside each run
    truth : Moments; of all of them
    path_seconds : float; a path-traced sample of all pixels takes: the median
    runs : dict of str to Runs
        Of each contender; seconds are the median of the last frames.
    """

    world: World
    bounces: int
    batches: list[Moments]
    truth: Moments
    path_seconds: float
    runs: dict[str, Runs]

    def path_variances(self) -> Numbers:
        """Mean squared error of one path-traced sample, an estimate a batch."""
        return np.array([batch.variance().mean() for batch in self.batches])

    def errors(self, name: str, pixels: Masks | None = None) -> Numbers:
        """Mean squared error of each run, without the share of the truth's own.

        Parameters
        ----------
        pixels : (N,) bool, optional; which count

        Returns
        -------
        (runs,) float64
            They may fall below 0 where the truth is noisier than the pictures.
        """
        some = slice(None) if pixels is None else pixels
        truth, variance = self.truth.mean[some], self.truth.standard_error()[some] ** 2
        colors = self.runs[name].colors
        return np.array([metrics.mse(c[some], truth, variance) for c in colors])


def _color(contender: Contender, steps: Rendering) -> Vec3s:
    """What comes after the last step."""
    try:
        step = next(steps)
    except StopIteration as end:
        color: Vec3s = end.value["color"]
        return color
    raise ValueError(f"{contender.name} has one more step, {step}")


def compete(
    world: World,
    contenders: Sequence[Contender],
    bounces: int,
    work: Work,
    paths: int = 1,
) -> Contest:
    """Run all contenders by turns, with path tracing between their frames.

    Run i of every contender has seed i.

    Parameters
    ----------
    contenders : sequence of Contender; each runs `FRAMES` frames a run
    paths : int; path-traced samples a frame
    """
    batches: list[Moments] = []
    path_times: list[float] = []
    frame_times: dict[str, list[float]] = {c.name: [] for c in contenders}
    colors: dict[str, list[Vec3s]] = {c.name: [] for c in contenders}
    for run in range(work.runs):
        work.tick(run, work.runs, "runs")
        running = {
            c.name: c.method.render(_job(world, c, run, work)) for c in contenders
        }
        drawn, turns = paths_beside(world, bounces, run, paths, work), []
        calls = {name: steps.__next__ for name, steps in running.items()}
        for turn in in_turns(calls, FRAMES):
            turns.append(turn)
            moments, spent = timed(drawn.__next__)
            path_times.append(spent / paths)
        batches.append(moments)
        for c in contenders:
            frame_times[c.name] += [turn[c.name].seconds for turn in turns[-CONVERGED:]]
            colors[c.name].append(_color(c, running[c.name]))
    work.tick(work.runs, work.runs, "runs")
    runs = {
        c.name: Runs(
            c.method,
            _job(world, c, 0, work),
            colors[c.name],
            float(np.median(frame_times[c.name])),
            Counter(),
        )
        for c in contenders
    }
    seconds = float(np.median(path_times))
    return Contest(world, bounces, batches, merge(batches), seconds, runs)


def paths_beside(
    world: World, bounces: int, run: int, step: int, work: Work
) -> Iterator[Moments]:
    """Path tracing between the frames of a run: part of the truth in the end.

    Parameters
    ----------
    run : int; samples of different runs are independent

    Returns
    -------
    iterator of Moments; after ever more samples, without end
    """
    seed = PATH_SEED + run
    drawn = path_samples(
        world, work.schedule, light="indirect", bounces=bounces, seed=seed
    )
    return ever_more(drawn, step, work.schedule)


def _job(world: World, contender: Contender, seed: int, work: Work) -> Job:
    return Job(
        world=world,
        light="indirect",
        bounces=contender.bounces,
        seed=seed,
        counts={"frames": FRAMES, "spp": 1},
        settings=contender.method.settings,
        aovs=(),
        schedule=work.schedule,
    )
