"""What an operating point costs, and how wrong it is."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.intervals import Interval, ratio_interval
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.demo.score import relative_bias
from restir_gi.reference.reports.figures.record import Deviation
from restir_gi.reference.reports.figures.spread import spreads
from restir_gi.reference.reports.figures.tiles import tile_means
from restir_gi.reference.reports.tradeoff.points import Design
from restir_gi.reference.reports.tradeoff.split import Split, split_error
from restir_gi.reference.reports.tradeoff.trials import Trial

TILE = 8
"""Pixels of a side of the tiles by which neighbours are found to err alike."""

WORST = 1000
"""One pixel in so many is among the worst."""


@dataclass(frozen=True, slots=True)
class DesignScore:
    """A point, measured.

    Attributes
    ----------
    point : Design; method and settings
    ms : Interval; a frame on one thread; the median of the runs, and their quartiles
    rays : dict of str to float; a pixel and frame, by kind
    kept : float; bytes a pixel from frame to frame
    error : Split; MSE of a frame, its squared bias and variance
    deviation : Deviation; of the mean luminance of the picture, relative to the truth
    length : Interval, pixels
        Side of the square in which pixels err alike: √(A Var[mean of A] / Var[pixel])
        for tiles of A pixels; 1 for independent pixels, at most the side of the tile.
    lag : Interval, frames
        For how long a pixel errs alike: T Var[mean of T frames] / Var[frame]; 1 for
        independent frames, at most T, half the frames of a run.
    worst : float; share of the squared error in the worst thousandth of the pixels
    """

    point: Design
    ms: Interval
    rays: dict[str, float]
    kept: float
    error: Split
    deviation: Deviation
    length: Interval
    lag: Interval
    worst: float

    @property
    def all_rays(self) -> float:
        """Rays a pixel and frame."""
        return sum(self.rays.values())

    @property
    def bias(self) -> float:
        """Bias that is certain: root of the lower end of its square, 0 for none."""
        return float(np.sqrt(max(self.error.bias2.low, 0.0)))


def score(
    point: Design, trials: list[Trial], truth: Moments, width: int, counted: int
) -> DesignScore:
    """Measure a point by its runs.  Intervals of errors: 95 %, bootstrap over runs.

    Parameters
    ----------
    trials : list of Trial; runs of different seeds, at least 3
    truth : Moments; path-traced
    counted : int; frames in the mean of a run
    """
    colors = np.array([t.color for t in trials])
    means = [t.mean.astype(np.float64) for t in trials]
    frames = [t.color.astype(np.float64) for t in trials]
    alone = spreads(frames)
    tiles = spreads([tile_means(f, width, TILE) for f in frames])
    area = ratio_interval(tiles, alone, TILE**2)
    return DesignScore(
        point,
        _quartiles(np.array([1000 * t.seconds for t in trials])),
        _mean_rays(trials),
        trials[0].kept,
        split_error(colors, truth),
        Deviation(*relative_bias(frames, truth)),
        Interval(*(float(np.sqrt(x)) for x in (area.value, area.low, area.high))),
        ratio_interval(spreads(means), alone, counted),
        _share_of_worst(colors, truth),
    )


def _mean_rays(trials: list[Trial]) -> dict[str, float]:
    kinds = sorted({kind for t in trials for kind in t.rays})
    return {k: float(np.mean([t.rays.get(k, 0.0) for t in trials])) for k in kinds}


def _quartiles(values: Scalars) -> Interval:
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return Interval(float(middle), float(low), float(high))


def _share_of_worst(colors: Scalars, truth: Moments) -> float:
    errors = ((colors - truth.mean) ** 2).sum(axis=2)
    worst = max(1, errors.shape[1] // WORST)
    total = errors.sum()
    top = np.sort(errors, axis=1)[:, -worst:].sum()
    return float(top / total) if total > 0 else 0.0
