"""Frames of variants by turns, all of which count.

Where tails are heavy, a frame a run says little: the errors of many frames do.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from restir_gi.figures.contest import paths_beside
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.intervals import Numbers
from restir_gi.reference.numerics.moments import Moments, merge
from restir_gi.reference.reports.demo.score import relative_bias
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.spread import spreads
from restir_gi.reference.reports.timing import in_turns, timed
from restir_gi.reference.transport.world import World

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
        return np.array([batch.variance().mean() for batch in self.batches])

    def bias(self, name: str) -> tuple[float, float]:
        """Bias of the mean luminance, and its standard error.

        Frames of a run are taken for one number.
        """
        means = [np.mean(run, axis=0) for run in self.colors[name]]
        return relative_bias(means, self.truth)


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
    colors: dict[str, list[list[Vec3s]]] = {
        name: [[] for _ in range(work.runs)] for name in variants
    }
    times: dict[str, list[float]] = {name: [] for name in variants}
    batches, path_times = [], []
    for run in range(work.runs):
        work.tick(run, work.runs, "runs")
        running = {name: make(run).__next__ for name, make in variants.items()}
        drawn = paths_beside(world, bounces, run, PATHS, work)
        for frame, turn in enumerate(in_turns(running, WARM + COUNTED)):
            if frame < WARM:
                continue
            for name, lap in turn.items():
                colors[name][run].append(lap.result)
                times[name].append(lap.seconds)
            moments, spent = timed(drawn.__next__)
            path_times.append(spent / PATHS)
        batches.append(moments)
    work.tick(work.runs, work.runs, "runs")
    seconds = {name: float(np.median(spent)) for name, spent in times.items()}
    return Turns(colors, seconds, batches, float(np.median(path_times)))
