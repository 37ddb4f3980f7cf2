"""Moments of independent batches, put together."""

from collections.abc import Sequence

import numpy as np

from reference.intervals import Numbers
from reference.moments import Moments


def merge(batches: Sequence[Moments]) -> Moments:
    """Moments of all samples of several batches.

    Parameters
    ----------
    batches : sequence of Moments
        At least one; of different samples of the same rows.

    Returns
    -------
    Moments
        As if one batch had held all samples, but for rounding.

    Notes
    -----
    Σ (x − μ)² over both = the two sums + (μ_a − μ_b)² n_a n_b / (n_a + n_b)
    [Chan83].
    """
    merged = batches[0]
    for batch in batches[1:]:
        count = merged.count + batch.count
        step = batch.mean - merged.mean
        mean = merged.mean + step * (batch.count / count)
        between = step**2 * (merged.count * batch.count / count)
        merged = Moments(count, mean, merged.squares + batch.squares + between)
    return merged


def path_errors(batches: Sequence[Moments]) -> Numbers:
    """Mean squared error of one path-traced sample, an estimate a batch.

    Parameters
    ----------
    batches : sequence of Moments
        B, each of at least two samples.

    Returns
    -------
    (B,) float64
        Variance of a sample, in the mean over pixels and channels.
    """
    return np.array([np.mean(b.squares) / (b.count - 1.0) for b in batches])
