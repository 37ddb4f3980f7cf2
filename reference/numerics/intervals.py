"""Numbers with their 95 % confidence intervals: by resampling runs, or by signs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr, ndtr, ndtri

Numbers = NDArray[np.float64]
Statistic = Callable[..., Numbers]

DRAWS = 4000
LEVEL = 0.95


@dataclass(frozen=True, slots=True)
class Interval:
    """A number with its 95 % confidence interval."""

    value: float
    low: float
    high: float


def bootstrap_interval(
    statistic: Statistic, *runs: int, corrected: bool = False
) -> Interval:
    """A number that runs yield together, and how far it scatters.

    The statistic of all runs, and percentiles of its bootstrap distribution.

    Parameters
    ----------
    statistic : callable
        From one (..., R) array of indices for each kind of runs to (...) numbers.
    *runs : int; how many there are of each kind; kinds are resampled independently
    corrected : bool
        Correct the percentiles for the bias of the median and for a spread that
        changes with the number (BCa); where these have no finite estimate, as for runs
        that are all alike, they are left as they are.

    Notes
    -----
    [Efron93, chapters 13 and 14].  Whole runs are resampled, never pixels or frames,
    which are correlated.  Of R normal runs the percentile interval of a mean holds the
    truth with probability P(|t| ≤ 1.96 √((R − 1) / R)), t of R − 1 degrees of freedom:
    93.5 % for 32 runs, 89 % for 8.  A few runs are better than none, and no more than
    that.
    """
    rng = np.random.default_rng(0)
    drawn = statistic(*(rng.integers(n, size=(DRAWS, n)) for n in runs))
    value = float(statistic(*map(np.arange, runs)))
    levels = np.array([(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    if corrected:
        levels = _corrected(levels, drawn, value, _acceleration(statistic, runs))
    # Of infinite entries no number may be interpolated.
    low, high = np.quantile(drawn, levels, method="nearest")
    return Interval(value, float(low), float(high))


def _corrected(
    levels: Numbers, drawn: Numbers, value: float, acceleration: float
) -> Numbers:
    """[Efron93, Eq. 14.10]."""
    # Half of the draws that equal the estimate count as below it.
    below = 0.5 * float(np.mean(drawn < value) + np.mean(drawn <= value))
    if not (0 < below < 1 and np.isfinite(acceleration)):
        return levels
    bias = ndtri(below)
    moved = bias + ndtri(levels)
    found: Numbers = ndtr(bias + moved / (1 - acceleration * moved))
    return found


def _acceleration(statistic: Statistic, runs: Sequence[int]) -> float:
    """[Efron93, Eq. 14.15], by leaving out one run after the other."""
    second = third = 0.0
    whole = [np.arange(n) for n in runs]
    for kind, n in enumerate(runs):
        others = np.array([np.delete(whole[kind], k) for k in range(n)])
        without = statistic(*whole[:kind], others, *whole[kind + 1 :])
        off = (n - 1) / n * (without.mean() - without)
        second += float(np.sum(off**2))
        third += float(np.sum(off**3))
    return third / (6 * second**1.5) if second > 0 else np.nan


def mean_interval(values: Numbers) -> Interval:
    """Mean of runs.

    Parameters
    ----------
    values : (R,) float64; a number a run
    """
    return ratio_interval(values, np.ones(len(values)))


def ratio_interval(above: Numbers, below: Numbers, factor: float = 1.0) -> Interval:
    """Ratio of the means of two numbers that each run yields.

    See `bootstrap_interval`.  Infinite where a mean in the denominator is not above 0.

    Parameters
    ----------
    above, below : (R,) float64
        Numerator and denominator; entry i of both belongs to run i, so that what is
        common to the two cancels.
    factor : float; on the ratio, taken to be exact
    """

    def ratio(index: NDArray[np.int64]) -> Numbers:
        a, b = above[index].mean(axis=-1), below[index].mean(axis=-1)
        known = b > 0
        return np.where(known, factor * a / np.where(known, b, 1.0), np.inf)

    return bootstrap_interval(ratio, len(above))


def median_interval(values: Sequence[float]) -> Interval:
    """Median of independent numbers, with the interval of the sign test.

    It holds whatever the distribution.  Of fewer than 6 numbers no two hold the median
    at 95 %: then the ends are those of all.

    Parameters
    ----------
    values : sequence of float; at least one
    """
    ordered, count = np.sort(values), len(values)
    # The k-th number is above the median with probability P(Bin(n, 1/2) < k).
    too_high = bdtr(np.arange(count), count, 0.5)
    k = max(0, int(np.sum(too_high <= (1 - LEVEL) / 2)) - 1)
    return Interval(
        float(np.median(ordered)), float(ordered[k]), float(ordered[-1 - k])
    )
