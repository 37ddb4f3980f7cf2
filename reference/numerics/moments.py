"""Mean and standard error of many samples, by the running sums of Welford."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.schedule import Schedule, in_bands


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """What n samples a row leave behind.

    Attributes
    ----------
    count : int; n
    mean : (N, 3) float64; their mean
    squares : (N, 3) float64; sum of squared deviations from it
    """

    count: int
    mean: Vec3s
    squares: Vec3s

    def variance(self) -> Vec3s:
        """Variance of a sample, squares / (n − 1), (N, 3) float64; unbiased."""
        found: Vec3s = self.squares / (self.count - 1.0)
        return found

    def standard_error(self) -> Vec3s:
        """Standard error of the mean, √(squares / (n (n − 1))).

        Returns
        -------
        (N, 3) float64
            0 also where no sample has found any light yet: rare light is not there
            until it is met.
        """
        if self.count < 2:
            raise ValueError("a standard error needs two samples")
        error: Vec3s = np.sqrt(self.squares / (self.count * (self.count - 1.0)))
        return error


@dataclass(frozen=True, slots=True)
class _Part:
    mean: Vec3s
    squares: Vec3s


def no_samples(rows: int) -> Moments:
    """Moments of no sample at all.

    Parameters
    ----------
    rows : int; N
    """
    return Moments(0, np.zeros((rows, 3)), np.zeros((rows, 3)))


def add_samples(
    moments: Moments,
    sample: Callable[[slice, int], Vec3s],
    stop: int,
    schedule: Schedule,
) -> Moments:
    """Moments after samples ``moments.count`` to ``stop`` − 1 were added [Welford62].

    Parameters
    ----------
    moments : Moments; of the samples before
    sample : callable
        Takes a slice of K rows and the number of a sample, gives its (K, 3) values.
    stop : int; samples in the result

    Returns
    -------
    Moments
        One sample is added after the other, in order: bit-identical however the
        samples are cut into calls and the rows into bands.
    """

    def advance(rows: slice) -> _Part:
        mean, squares = moments.mean[rows], moments.squares[rows]
        for number in range(moments.count, stop):
            x = sample(rows, number)
            deviation = x - mean
            mean = mean + deviation / (number + 1.0)
            squares = squares + deviation * (x - mean)
        return _Part(mean, squares)

    part = in_bands(schedule, len(moments.mean), advance)
    return Moments(stop, part.mean, part.squares)


def merge(batches: Sequence[Moments]) -> Moments:
    """Moments of all samples of several batches.

    Σ (x − μ)² over both = the two sums + (μ_a − μ_b)² n_a n_b / (n_a + n_b)
    [Chan83].

    Parameters
    ----------
    batches : sequence of Moments; at least one; of different samples of the same rows

    Returns
    -------
    Moments; as if one batch had held all samples, but for rounding
    """
    merged = batches[0]
    for batch in batches[1:]:
        count = merged.count + batch.count
        step = batch.mean - merged.mean
        mean = merged.mean + step * (batch.count / count)
        between = step**2 * (merged.count * batch.count / count)
        merged = Moments(count, mean, merged.squares + batch.squares + between)
    return merged
