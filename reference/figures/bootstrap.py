"""Confidence intervals by resampling runs."""

import numpy as np
from numpy.typing import NDArray

from reference.figures.record import Interval

Numbers = NDArray[np.float64]

DRAWS = 4000
LEVEL = 0.95


def mean_interval(values: Numbers) -> Interval:
    """Mean of runs.

    Parameters
    ----------
    values : (R,) float64; a number a run
    """
    return ratio_interval(values, np.ones(len(values)))


def ratio_interval(above: Numbers, below: Numbers, factor: float = 1.0) -> Interval:
    """Ratio of the means of two numbers that each run yields.

    [Efron93, chapter 13].  Whole runs are resampled, never pixels or frames, which are
    correlated.  Of R normal runs the interval of a mean holds the truth with
    probability P(|t| ≤ 1.96 √((R − 1) / R)), t of R − 1 degrees of freedom: 93.5 % for
    32 runs, 89 % for 8.  A few runs are better than none, and no more than that.

    Percentiles of the bootstrap distribution.  Infinite where a mean in the denominator
    is not above 0.

    Parameters
    ----------
    above, below : (R,) float64
        Numerator and denominator; entry i of both belongs to run i, so that what is
        common to the two cancels.
    factor : float; on the ratio, taken to be exact
    """
    draw = np.random.default_rng(0).integers(len(above), size=(DRAWS, len(above)))
    tail = (1 - LEVEL) / 2
    ratios = _ratio(above[draw].mean(axis=1), below[draw].mean(axis=1), factor)
    # Of infinite entries no ratio may be interpolated.
    low, high = np.quantile(ratios, [tail, 1 - tail], method="nearest")
    value = _ratio(np.array(above.mean()), np.array(below.mean()), factor)
    return Interval(float(value), float(low), float(high))


def _ratio(above: Numbers, below: Numbers, factor: float) -> Numbers:
    known = below > 0
    return np.where(known, factor * above / np.where(known, below, 1.0), np.inf)
