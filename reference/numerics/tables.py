"""Tables of weights to draw from: running sums, and how they are searched."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars


def sample_table(cumulative: Scalars, u: Scalars) -> tuple[Indices, Scalars]:
    """Index drawn in proportion to the weights of a table, and u used again.

    Parameters
    ----------
    cumulative : (K,) float
        Running sum of weights, the last one 1 (see :func:`cumulate`).
    u : (N,) float; in [0, 1)

    Returns
    -------
    (N,) int, (N,) float
        Index, never one of weight 0, and the place of u within its interval, in
        [0, 1): a uniform number independent of the index.
    """
    index = np.searchsorted(cumulative, u, side="right")
    index = np.minimum(index, len(cumulative) - 1)
    upper = cumulative[index]
    lower = np.where(index > 0, cumulative[np.maximum(index - 1, 0)], 0.0)
    remainder = (u - lower) / (upper - lower)
    return index, np.minimum(remainder, 1.0 - 2.0**-53)


def guide_of(cumulative: Scalars) -> Indices:
    """Where a search in a table begins: what stands at even steps of u.

    Parameters
    ----------
    cumulative : (K,) float; running sum of weights, the last one 1

    Returns
    -------
    (G,) int64
        For g / G the number of entries up to it; G is a power of two above 4 K, so that
        u G is exact.
    """
    size = 4 << len(cumulative).bit_length()
    found = np.searchsorted(cumulative, np.arange(size) / size, side="right")
    guide: Indices = found.astype(np.int64)
    return guide


def index_in_table(cumulative: Scalars, guide: Indices, u: Scalars) -> Indices:
    """Index drawn in proportion to the weights of a table, in constant time.

    The method of guide tables: a step in the mean, where bisection takes log₂ K.

    Parameters
    ----------
    cumulative : (K,) float; running sum of weights, the last one 1
    guide : (G,) int; of it
    u : (N,) float; in [0, 1)

    Returns
    -------
    (N,) int; that of :func:`sample_table`
    """
    index = guide[(u * len(guide)).astype(np.int64)]
    short = np.flatnonzero(cumulative[index] <= u)
    while len(short):
        index[short] += 1
        short = short[cumulative[index[short]] <= u[short]]
    return index


def cumulate(weights: Scalars) -> Scalars:
    """Running sum of weights, scaled to end at exactly 1.

    Parameters
    ----------
    weights : (K,) float; non-negative, not all 0

    Returns
    -------
    (K,) float; non-decreasing; from the last positive weight on it is 1

    Raises
    ------
    ValueError
        No weight is positive, or one is negative or not finite.
    """
    sums = np.cumsum(weights)
    # Not weights.sum(): it rounds otherwise, so that the running sum could pass 1.
    total = sums[-1:].sum()
    if not (np.isfinite(total) and total > 0 and np.all(weights >= 0)):
        raise ValueError("weights must be finite, non-negative and not all 0")
    cumulative: Scalars = sums / total
    cumulative[np.flatnonzero(weights)[-1] :] = 1.0
    return cumulative
