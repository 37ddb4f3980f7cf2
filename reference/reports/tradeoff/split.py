"""Mean squared error, split into bias and variance without a bias of its own.

With d_i = x_i − t, of runs x_1 ... x_R and the truth t, and G_ij the mean of d_i d_j
over pixels and channels: the mean of the diagonal of G is the MSE, and the mean of all
that is off the diagonal is the squared bias, since different runs are independent; each
plus the variance of the truth, which is subtracted.  What is between the two is the
variance of a run.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.intervals import Interval, bootstrap_interval
from restir_gi.reference.numerics.moments import Moments


@dataclass(frozen=True, slots=True)
class Split:
    """MSE = squared bias + variance, each with its interval.

    Attributes
    ----------
    mse, bias2, variance : Interval
        (W/(m² sr))²; the squared bias may be negative, by as much as it is not known.
    """

    mse: Interval
    bias2: Interval
    variance: Interval


def products(images: Scalars, truth: Scalars) -> Scalars:
    """G_ij = mean over pixels and channels of (x_i − t)(x_j − t).

    Parameters
    ----------
    images : (R, N, 3) float; runs
    truth : (N, 3) float64; t

    Returns
    -------
    (R, R) float64; symmetric
    """
    d = (images.astype(np.float64) - truth).reshape(len(images), -1)
    found: Scalars = d @ d.T / d.shape[1]
    return found


def split_error(images: Scalars, truth: Moments) -> Split:
    """Split the error of runs.

    Parameters
    ----------
    images : (R, N, 3) float; R independent runs, at least 3
    truth : Moments; path-traced, independent of all of them

    Returns
    -------
    Split; 95 % intervals: BCa bootstrap over runs [Efron93, chapter 14]
    """
    G = products(images, truth.mean)
    whole = float((G.sum() - np.trace(G)) / (len(G) * (len(G) - 1)))
    noise = float(np.mean(truth.standard_error() ** 2.0))

    def weights(index: Any) -> Scalars:
        """How often each run was drawn, (..., R)."""
        counts: Scalars = (index[..., None] == np.arange(len(G))).sum(axis=-2) * 1.0
        return counts

    def mse(index: Any) -> Scalars:
        c = weights(index)
        found: Scalars = c @ np.diag(G) / c.sum(axis=-1) - noise
        return found

    def bias2(index: Any) -> Scalars:
        # Of a run that was drawn twice the product with itself is no product of two.
        c = weights(index)
        pairs = c.sum(axis=-1) ** 2 - (c * c).sum(axis=-1)
        total = np.einsum("...i,ij,...j->...", c, G, c) - (c * c) @ np.diag(G)
        # One run alone, drawn every time, makes no pair and says nothing of bias.
        found: Scalars = np.where(pairs > 0, total / np.maximum(pairs, 1), whole)
        return found - noise

    def variance(index: Any) -> Scalars:
        return mse(index) - bias2(index)

    return Split(
        *(bootstrap_interval(f, len(G), corrected=True) for f in (mse, bias2, variance))
    )
