"""Mean squared errors of runs whose mean is the truth, by how far they spread."""

from collections.abc import Sequence

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.intervals import Numbers


def spreads(colors: Sequence[Vec3s]) -> Numbers:
    """Mean squared error of each run, against the mean of the others.

    Parameters
    ----------
    colors : sequence of (N, 3) float64
        R independent runs, at least 2, of an unbiased method.

    Returns
    -------
    (R,) float64
        (c_i - mean of the others)² (R - 1) / R, in the mean over pixels and channels:
        each has the variance of a run for its expectation, and none falls below 0, as
        it may against a noisy truth.
    """
    runs = np.array(colors)
    count = len(runs)
    others = (runs.sum(axis=0) - runs) / (count - 1)
    errors: Numbers = ((runs - others) ** 2).mean(axis=(1, 2)) * (count - 1) / count
    return errors
