"""Initial samples of pairs: the new paths of both pixels, each with its offset path."""

from dataclasses import replace

import numpy as np

from gradient_domain.paired_domain import PairedPaths, target
from gradient_domain.pairs import Pairs
from gradient_domain.shifts import InnerShift
from reference.arrays import Scalars
from reference.records import scatter, take
from reference.resampling.generalized import Target
from reference.resampling.reservoir import Candidates, Reservoirs, finalize, merge


def paired(
    inner: InnerShift, paths: Reservoirs, pairs: Pairs, k: int, sign: int
) -> Reservoirs:
    """Paths of pixels as samples of pairs.

    Parameters
    ----------
    k : int; whose paths: 0 those of the first pixels, 1 of the second

    Returns
    -------
    Reservoirs; of `PairedPaths`, K rows; a pixel's path is a sample of up to four pairs
    """
    rows = pairs.first if k == 0 else pairs.second
    own, size = take(paths, rows), len(pairs)
    ks, signs = np.full(size, k, np.int8), np.full(size, sign, np.int8)
    at = np.flatnonzero(own.W > 0)
    base = take(own.y, at)
    few = inner(base, base.value, ks[at], take(pairs, at), signs[at])
    offset, factor = scatter(at, few.offset, size), scatter(at, few.inner, size)
    return Reservoirs(PairedPaths(ks, own.y, offset, factor, signs), own.W, own.M)


def choose_pair(
    both: list[Reservoirs], sign: int, u: Scalars, target: Target = target
) -> Reservoirs:
    """One of two samples of each pair, by what it is worth to a reservoir.

    [Wang25, section 4.4].  Samples of other k are of other parts of the domain, so that
    each has the weight m = 1.

    Parameters
    ----------
    both : list of Reservoirs; of `PairedPaths`, for k = 0 and 1
    sign : int; of the reservoir; those of both signs share their samples
    u : (K,) float64; in [0, 1)

    Returns
    -------
    Reservoirs; K rows; M = 1
    """
    first, second = (_competing(r, sign, target) for r in both)
    kept = merge(first, second, u)
    one = np.ones_like(kept.w)
    return finalize(replace(kept, M=one), one)


def _competing(r: Reservoirs, sign: int, target: Target) -> Candidates:
    y = replace(r.y, sign=np.full(len(r.M), sign, np.int8))
    p_hat = target(y.value)
    return Candidates(y, p_hat, p_hat * r.W, r.M)
