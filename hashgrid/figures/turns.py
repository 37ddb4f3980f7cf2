"""Frames of variants by turns, all of which count.

Where tails are heavy, a frame a run says little: the errors of many frames do.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from reference.accumulate import path_samples
from reference.arrays import Vec3s
from reference.figures.batches import merge
from reference.figures.bootstrap import Numbers
from reference.figures.contest import PATH_SEED
from reference.figures.record import Work
from reference.figures.spread import spreads
from reference.moments import Moments, add_samples, no_samples
from reference.world import World

WARM, COUNTED = 8, 8
"""Frames of a run before those that count, and these."""

PATHS = 8
"""Path-traced samples beside each counted frame."""

Renders = Callable[[int], Iterator[Vec3s]]
# From a seed to frames without end.


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """What runs by turns leave behind.

    Attributes
    ----------
    colors : dict of str to list of list of (N, 3) float64
        Counted frames of each run of each variant.
    seconds : dict of str to float; a frame takes: the median
    batches : list of Moments; path-traced samples drawn beside each run
    path_seconds : float; a path-traced sample takes: the median
    """

    colors: dict[str, list[list[Vec3s]]]
    seconds: dict[str, float]
    batches: list[Moments]
    path_seconds: float

    @property
    def truth(self) -> Moments:
        """Of all path-traced samples."""
        return merge(self.batches)

    def errors(self, name: str) -> Numbers:
        """Mean squared error of a frame, an estimate a run.

        Returns
        -------
        (R,) float64
            In the mean over the counted frames, each against those of the same number
            of other runs.
        """
        by_frame = zip(*self.colors[name], strict=True)
        found: Numbers = np.mean([spreads(frames) for frames in by_frame], axis=0)
        return found

    def path_errors(self) -> Numbers:
        """Mean squared error of one path-traced sample, an estimate a run."""
        return np.array([np.mean(b.squares) / (b.count - 1.0) for b in self.batches])

    def bias(self, name: str) -> tuple[float, float]:
        """Mean of a variant over the path-traced one, less 1, and its standard error.

        Frames of a run are taken for one number.
        """
        truth = self.truth.mean.mean()
        means = np.array([np.mean(run) for run in self.colors[name]])
        paths = np.array([b.mean.mean() for b in self.batches])
        count = len(means)
        error = np.hypot(means.std(ddof=1), paths.std(ddof=1)) / np.sqrt(count)
        return float(means.mean() / truth - 1), float(error / truth)


def by_turns(
    world: World, bounces: int, variants: Mapping[str, Renders], work: Work
) -> Turns:
    """Run all variants by turns, with path tracing between their frames.

    Parameters
    ----------
    variants : mapping of str to callable
        From the seed of a run to the colours of its frames.

    Returns
    -------
    Turns; run i of every variant has seed i
    """
    colors: dict[str, list[list[Vec3s]]] = {name: [] for name in variants}
    times: dict[str, list[float]] = {name: [] for name in variants}
    batches, path_times = [], []
    for run in range(work.runs):
        work.tick(run, work.runs, "runs")
        running = {name: make(run) for name, make in variants.items()}
        kept: dict[str, list[Vec3s]] = {name: [] for name in variants}
        paths = path_samples(
            world,
            work.schedule,
            light="indirect",
            bounces=bounces,
            seed=PATH_SEED + run,
        )
        moments = no_samples(paths.rows)
        for frame in range(WARM + COUNTED):
            for name, frames in running.items():
                start = time.perf_counter()
                color = next(frames)
                spent = time.perf_counter() - start
                if frame >= WARM:
                    kept[name].append(color)
                    times[name].append(spent)
            if frame >= WARM:
                start = time.perf_counter()
                until = moments.count + PATHS
                moments = add_samples(moments, paths.radiance, until, work.schedule)
                path_times.append((time.perf_counter() - start) / PATHS)
        batches.append(moments)
        for name in variants:
            colors[name].append(kept[name])
    work.tick(work.runs, work.runs, "runs")
    seconds = {name: float(np.median(spent)) for name, spent in times.items()}
    return Turns(colors, seconds, batches, float(np.median(path_times)))
