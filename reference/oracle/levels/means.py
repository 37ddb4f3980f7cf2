"""L4: the mean over independent runs, inside a sphere that is not evenly bright.

With directions in proportion to the cosine, every estimate of a pixel is ρ times a mean
of radiances that were met: at most ρ times the largest, whatever is reused.  The truth,
ρ times the mean over the sphere, is known at every pixel.  So bets on the mean are
valid for any distribution of the estimator, and at every time.

The bound holds for weights that divide by sums of M, and for p̂ = f.  By the balance
heuristic, say, a pixel may be above it, and neither the bets nor their certificate mean
anything: there the difference of the means has to do, which rests on a finite variance
and not on a bound.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, count

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.cases import UnaskedError
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.levels.sphere import InsideSphere, points_inside, ring
from restir_gi.reference.oracle.levels.spheres import PLAIN, room
from restir_gi.reference.oracle.loop import Ask, Run, run_frames
from restir_gi.reference.oracle.statistics.betting import e_value, open_bets, place
from restir_gi.reference.oracle.statistics.certificate import (
    Certificate,
    certified_bias,
    extend,
    open_certificate,
)
from restir_gi.reference.oracle.statistics.families import average_e, bonferroni
from restir_gi.reference.oracle.statistics.power import bets_needed
from restir_gi.reference.oracle.statistics.variance import (
    RelativeMoments,
    extended,
    open_moments,
    p_values,
    standard_error,
)

ALPHA = 5e-7
"""False alarms of this level in a run; the distribution test has as many."""

TARGET = 0.005
"""Bound on |bias| of the mean at which the sampling stops."""

BANDS = ((-0.5, 1.0), (0.8, 0.7), (1.0, 0.0))
"""Up to which z the sphere has which radiance: some of it none, and the largest near
the mean, since a bet against darkness pays for their ratio."""

PIXELS, TILES, REPLICATES, FRAMES = 16, 4, 512, 3
"""Of a run, and runs of a batch.  Runs are small: many are worth more than large ones,
where the bound on the mean is what costs."""


RIGHT = Finding(True)

Batches = Callable[[int], Iterator[NDArray[np.float64]]]


@dataclass(frozen=True, slots=True)
class Mean:
    """What the runs have shown.

    Attributes
    ----------
    finding : Finding; of the bets, which rest on the bound: a proof
    by_variance : Finding; of the difference of the means: statistics
    certified : float; bound on the relative bias of the image's mean
    runs : int; independent ones
    more : str; what more time would buy; empty where the bound is small enough
    off, error : float
        Mean of the runs minus the truth, and its standard error, relative to that.
    """

    finding: Finding
    by_variance: Finding
    certified: float
    runs: int
    more: str
    off: float = 0.0
    error: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class _Banded(InsideSphere):
    """The inside of the unit sphere, shining in bands."""

    def shine(self, z: Scalars) -> Scalars:
        """Radiance of the sphere at heights."""
        limits = [limit for limit, _ in BANDS]
        radiances = np.array([radiance for _, radiance in BANDS])
        found: Scalars = radiances[np.minimum(np.searchsorted(limits, z), 2)]
        return found


def truth() -> float:
    """Mean radiance of the bands: areas on a sphere go with heights."""
    total, low = 0.0, -1.0
    for high, radiance in BANDS:
        total += (high - low) / 2 * radiance
        low = high
    return total


def mean_over_runs(
    ask: Ask,
    precision: Precision,
    remaining: Callable[[], float],
    batches: Batches | None = None,
    target: float = TARGET,
    alpha: float = ALPHA,
    first_seed: int = 1000,
    like: Run = PLAIN,
) -> Mean:
    """Run the loop over and over, from nothing each time, and bet on the mean.

    The statistics are the image's mean and those of 4 groups of pixels, whose e-values
    are averaged: an e-value under any dependence [Vovk21].

    Parameters
    ----------
    remaining : callable; seconds that are left
    batches : callable, optional
        From a seed to the replicates of its batch and of those after it, where others
        make them; the first batch is made here, so that a backend which does not
        answer is known before.
    target : float; certified bound at which to stop
    alpha : float; probability of a false alarm, over all times and statistics together
    first_seed : int; of the first batch; batches are numbered on
    like : Run
        Its weights are those of the runs; 1/M is right here too, where everybody sees
        everything.
    """
    exact = truth()
    most = max(radiance for _, radiance in BANDS) * (1 + room(precision))
    bets = open_bets(np.full(1 + TILES, exact), np.full(1 + TILES, most))
    certificate = open_certificate(exact, most)
    variance = _ByVariance(open_moments(np.full(1 + TILES, exact)), alpha)
    finding, bound, more = RIGHT, np.inf, ""
    here = (replicates(ask, precision, seed, like) for seed in count(first_seed))
    rest = batches(first_seed + 1) if batches else here
    for batch in _until_the_time_is_over(chain([next(here)], rest)):
        variance = _continued(variance, batch, room(precision))
        runs = variance.moments.count
        if finding.passed:
            for y in batch:
                bets = place(bets, y)
                certificate = extend(certificate, float(y[0]))
            e, bound = average_e(e_value(bets)), certified_bias(certificate, alpha)
            if e >= 1 / alpha:
                mean = float(bets.mean[0] * bets.bound[0])
                text = (
                    f"mean inside a sphere: {mean / exact - 1:+.3g} relative to the"
                    f" truth after {runs} runs; proved, as no pixel is above ρ times"
                    f" the largest radiance: e-value {e:.3g} against {1 / alpha:.3g}"
                )
                finding = Finding(False, text)
        more = _more(certificate, target, runs) if finding.passed else ""
        if bound <= target and finding.passed:
            more = ""
            break
        refuted = not finding.passed and _is_settled(variance, target, alpha)
        if refuted or remaining() <= 0:
            break
    off, error = (float(one[0]) for one in standard_error(variance.moments))
    return Mean(finding, variance.finding, bound, runs, more, off, error)


@dataclass(frozen=True, slots=True, eq=False)
class _ByVariance:
    """The difference of the means, asked after 1, 2, 4, 8, ... batches.

    Attributes
    ----------
    left : float
        Probability of a false alarm that is left; each time half of it is used, so
        that all times together have that of the first.
    batches : int; so far
    """

    moments: RelativeMoments
    left: float
    batches: int = 0
    finding: Finding = RIGHT


def _continued(
    v: _ByVariance, batch: NDArray[np.float64], rounding: float
) -> _ByVariance:
    """With a batch more, and asked if it is time."""
    v = replace(v, moments=extended(v.moments, batch), batches=v.batches + 1)
    if v.batches & (v.batches - 1) or not v.finding.passed:
        return v
    v = replace(v, left=v.left / 2)
    p = bonferroni(p_values(v.moments, rounding))
    if p >= v.left:
        return v
    mean, error = standard_error(v.moments)
    text = (
        f"mean inside a sphere: {mean[0]:+.3g} ± {error[0]:.2g} relative to the truth"
        f" after {v.moments.count} runs, p = {p:.2g} against {v.left:.2g} by Student's"
        " statistic: statistics that rest on a finite variance, not a proof"
    )
    return replace(v, finding=Finding(False, text))


def _is_settled(v: _ByVariance, target: float, alpha: float) -> bool:
    """Whether the difference of the means is wrong, or known as well as is wanted."""
    _, error = standard_error(v.moments)
    return not v.finding.passed or float(-ndtri(alpha / 2) * error[0]) <= target


def _until_the_time_is_over(
    batches: Iterator[NDArray[np.float64]],
) -> Iterator[NDArray[np.float64]]:
    """All batches that are whole; the first is the least that is wanted."""
    yield next(batches)
    with suppress(UnaskedError):
        yield from batches


def replicates(
    ask: Ask, precision: Precision, seed: int, like: Run = PLAIN
) -> NDArray[np.float64]:
    """Statistics of independent runs, each from nothing.

    Returns
    -------
    (REPLICATES, 1 + TILES) float64
        Means of the image and of groups of pixels, over the albedo.
    """
    # Each run has points of its own: none is left out of the test for good.
    sphere = _Banded(points_inside(PIXELS * REPLICATES, seed), 1.0)
    run = replace(like, frames=FRAMES, seed=seed)
    around = partial(_own_ring, like.around(3))
    shown = run_frames(ask, sphere, around, run, precision)[-1]
    color = shown.color.astype(float) / sphere.receivers()["albedo"]
    by_pixel = color.mean(axis=1).reshape(REPLICATES, PIXELS)
    tiles = by_pixel.reshape(REPLICATES, TILES, -1).mean(axis=2)
    return np.column_stack([by_pixel.mean(axis=1), tiles])


def _own_ring(count: int, frame: int) -> Indices:
    """Neighbours within each run."""
    within = ring(PIXELS, count, frame)
    start = np.arange(REPLICATES)[:, None, None] * PIXELS
    return (within[None] + start).reshape(REPLICATES * PIXELS, -1)


def _more(certificate: Certificate, target: float, runs: int) -> str:
    variance = float(certificate.bets.squares[0]) / max(runs - 1, 1)
    variation = float(np.sqrt(max(variance, 0.0)) / max(certificate.bets.mean[0], 1e-9))
    headroom = certificate.ceiling + 1
    needed = bets_needed(variation, -target, headroom, ALPHA)
    return f"about {needed:.0f} runs in place of {runs} would certify {target:g}"
