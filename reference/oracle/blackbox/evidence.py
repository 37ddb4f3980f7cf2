"""What the pictures of a renderer say of it, and what would say more.

Two kinds of evidence.  *Proven*: light is never negative, and a gambler's capital,
which cannot grow against a right renderer, has grown.  *Statistical*: the mean differs
from the truth by more standard errors than chance makes, if the variance is finite.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr, stdtrit

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.blackbox.tiles import CHANNELS, COLUMNS, PLACES
from restir_gi.reference.oracle.blackbox.truth import LEAST_SAMPLES, Truth

ALPHA = 5e-7
"""Probability that a right renderer is accused, by either kind of evidence."""

MISSED = 0.05
"""Probability that a renderer passes which is off by the tolerance."""

DARK = 0.01
"""Share of the picture's mean: darker tiles are only held to so much of it."""

ROUNDING = 2.0**-11
"""Relative: a picture in half precision whose pixels were all rounded one way."""

EXACT_WHOLE, EXACT_TILE = 20, 8
"""The errors of a truth are so many times smaller than the tolerances: what is off by
the tolerance is accused at some 7 standard errors, after many looks."""

TRUTH_DEVIATIONS = 6.0
"""Standard errors by which a truth is never off."""

FIRST_LOOK, GROWTH = 8, 1.25
"""Pictures at the first look, and how many times as many at each one after it."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """What a user lets pass, relative.

    Attributes
    ----------
    whole, tile : float; of the picture's mean, and of those of its tiles
    """

    whole: float = 0.01
    tile: float = 0.05

    def margins(self, truth: Truth) -> Scalars:
        """How far each mean may be off, (COLUMNS,) float64.

        A tile by its share of its mean over the channels, and in any case by `DARK` of
        the picture's mean; channels of the picture by as much as a tile.  Channels of
        a tile may accuse, but nothing needs to be shown of them: infinity.
        """
        mean = truth.mean[:PLACES]
        margins = np.full(COLUMNS, np.inf)
        margins[:PLACES] = np.maximum(self.tile * mean, DARK * mean[0])
        margins[0] = self.whole * mean[0]
        margins[PLACES : PLACES + len(CHANNELS)] = self.tile * mean[0]
        return margins


def is_exact(truth: Truth, tolerance: Tolerance, roughly: float = 1.0) -> bool:
    """Whether the truth's own errors are small beside what is let pass.

    Parameters
    ----------
    roughly : float; how many times larger they may be than `EXACT_WHOLE`, `EXACT_TILE`
    """
    if truth.samples < LEAST_SAMPLES:
        return False
    most = roughly * tolerance.margins(truth)[:PLACES] / EXACT_TILE
    most[0] *= EXACT_TILE / EXACT_WHOLE
    return bool((truth.standard_error[:PLACES] <= most).all())


def share_of(look: int) -> float:
    """Of a probability, what one look may use: 6 / (π k)²; all looks use it once.

    Parameters
    ----------
    look : int; k, from 1
    """
    return 6.0 / (np.pi * look) ** 2


def look_after(pictures: int) -> int:
    """How many pictures there are at the next look."""
    return max(FIRST_LOOK, int(np.ceil(pictures * GROWTH)))


@dataclass(frozen=True, slots=True, eq=False)
class PictureDifferences:
    """Means minus their truths.

    Attributes
    ----------
    count : int; n pictures
    truth, difference, error : (COLUMNS,) float64; the error is that of the difference
    own_error : (COLUMNS,) float64; the part of it that more pictures make smaller
    skewness : (COLUMNS,) float64; of a picture's means, as it was seen
    negative : bool; whether light was, so that darkness has no least
    """

    count: int
    truth: Scalars
    difference: Scalars
    error: Scalars
    own_error: Scalars
    skewness: Scalars
    negative: bool = False

    @property
    def relative(self) -> Scalars:
        """(COLUMNS,) float64; infinite where there should be no light."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found: Scalars = self.difference / self.truth
        return np.asarray(np.where(self.difference == 0, 0.0, found))


def differences(
    means: NDArray[np.float64], truth: Truth, negative: bool = False
) -> PictureDifferences:
    """Means of pictures minus their truths, with their errors.

    Parameters
    ----------
    means : (n, COLUMNS) float64; of n ≥ 2 independent pictures
    negative : bool; whether a pixel of them was

    Notes
    -----
    A tile that by luck has met no bright path yet has a low mean and a small spread at
    once.  Where noise is, the path tracer knows: the spread of a tile is taken to be
    no smaller than that of a path-traced one times the median, over the tiles that
    vary, of how much noisier than that the renderer's are.
    """
    n = len(means)
    spread = np.maximum(means.std(axis=0, ddof=1), _expected_spread(means, truth))
    own = spread / np.sqrt(n)
    return PictureDifferences(
        count=n,
        truth=truth.mean,
        difference=means.mean(axis=0) - truth.mean,
        error=np.hypot(own, truth.standard_error),
        own_error=own,
        skewness=_skewness(means, spread),
        negative=negative,
    )


def _expected_spread(means: NDArray[np.float64], truth: Truth) -> Scalars:
    """That of path-traced tiles, times how much noisier most tiles are that vary.

    Where none varies, say in black pictures, as that of one path a pixel.
    """
    found = means.std(axis=0, ddof=1)[1:PLACES]
    expected = truth.deviation[1:PLACES]
    varies = (found > 0) & (expected > 0)
    ratios = found[varies] / expected[varies]
    ratio = float(np.median(ratios)) if varies.any() else 1.0
    return np.asarray(ratio * truth.deviation)


def _skewness(means: NDArray[np.float64], spread: Scalars) -> Scalars:
    cubes = ((means - means.mean(axis=0)) ** 3).mean(axis=0)
    found = np.divide(cubes, spread**3, out=np.zeros(COLUMNS), where=spread > 0)
    return np.asarray(found)


def p_values(found: PictureDifferences) -> Scalars:
    """Probability of so large a difference of a right renderer, for each column.

    Returns
    -------
    (COLUMNS,) float64; two-sided

    Notes
    -----
    Of Student's t.  The noise of light is skewed towards brightness, for none of it is
    below 0: most means are too dark, by a little, and their spread is too small.  So
    the tail of darkness is larger by exp(γ z³ / 3 √n), with the skewness γ, as long as
    z is small beside √n / γ.  Beyond that it has the tail of Bennett's inequality:
    exp(−n v h(δ / v)), with h(u) = (1 + u) ln(1 + u) − u, v the variance and δ the
    difference in units of μ² and μ.
    """
    size = np.abs(found.difference)
    beyond = np.maximum(size - _slack(found), 0.0)
    never = np.where(beyond > 0, np.inf, 0.0)
    z = np.divide(beyond, found.error, out=never, where=found.error > 0)
    log_p = _log_t(z, found.count)
    dark = log_p + _log_skewed(found, z)
    if not found.negative:
        dark = np.minimum(dark, np.maximum(log_p, _log_bennett(found, beyond)))
    log_p = np.where(found.difference < 0, dark, log_p)
    return np.asarray(np.exp(np.minimum(log_p, 0.0)))


def _slack(found: PictureDifferences) -> Scalars:
    """What no renderer is accused of: rounding, and what is off in the dark."""
    least = DARK * found.truth[0]
    rounding = ROUNDING * found.truth
    dark = np.maximum(rounding, least)
    return np.asarray(np.where(found.truth < least, dark, rounding))


def _log_t(z: Scalars, n: int) -> Scalars:
    with np.errstate(divide="ignore"):  # the logarithm of 0 is what is meant
        return np.asarray(np.log(2 * stdtr(n - 1, -z)))


def _log_skewed(found: PictureDifferences, z: Scalars) -> Scalars:
    """γ z³ / 3 √n; 0 without skewness towards brightness."""
    # Only the renderer's own noise is skewed: the truth has many samples.
    share = np.divide(
        found.own_error, found.error, out=np.zeros(COLUMNS), where=found.error > 0
    )
    skewness = np.maximum(found.skewness, 0.0) * share**3
    return np.asarray(skewness * np.minimum(z, 1e3) ** 3 / (3 * found.count**0.5))


def _log_bennett(found: PictureDifferences, beyond: Scalars) -> Scalars:
    """Logarithm of Bennett's bound; the truth may be as low as its error lets it be."""
    error = np.sqrt(np.maximum(found.error**2 - found.own_error**2, 0.0))
    delta = np.maximum(beyond - TRUTH_DEVIATIONS * error, 0.0)
    mean, n = found.truth, found.count
    known = mean > 0
    u = np.divide(delta, mean, out=np.zeros(COLUMNS), where=known)
    v = np.divide(n * found.own_error**2, mean**2, out=np.zeros(COLUMNS), where=known)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(v > 0, u / v, np.inf)
        bound = -n * v * ((1 + ratio) * np.log1p(ratio) - ratio)
    bound = np.where(v > 0, bound, np.where(u > 0, -np.inf, 0.0))
    return np.asarray(bound + np.log(2.0))


def within(found: PictureDifferences, margins: Scalars, missed: float) -> Masks:
    """Which means are shown to be off by less than is let pass.

    Parameters
    ----------
    margins : (COLUMNS,) float64; how far they may be off
    missed : float; probability that one which is off by as much is said to be within

    Returns
    -------
    (COLUMNS,) bool
    """
    bound = -stdtrit(found.count - 1, missed)
    return np.asarray(np.abs(found.difference) + bound * found.error <= margins)


def pictures_to_decide(
    found: PictureDifferences, margins: Scalars, look: int, most: int = 10**7
) -> int | None:
    """How many pictures would decide, about, if their spread stays as it is.

    Of so many means some are off by 3 of their errors anyway; what is beyond stays.

    Parameters
    ----------
    margins : (COLUMNS,) float64; how far means may be off
    look : int; at which they did not

    Returns
    -------
    int or None; where no number of pictures would: the truth is not exact enough
    """
    size = np.maximum(np.abs(found.difference) - 3 * found.error, 0.0)
    truth_error = np.sqrt(np.maximum(found.error**2 - found.own_error**2, 0.0))
    tried = found.count
    while (tried := look_after(tried)) <= most:
        look += 1
        own = found.own_error * np.sqrt(found.count / tried)
        error = np.hypot(own, truth_error)
        # By chance a difference is about one error.
        bound = 1 - stdtrit(tried - 1, MISSED * share_of(look))
        # Half of α is for this kind of evidence, and half of that for either side.
        enough = 1 - stdtrit(tried - 1, ALPHA * share_of(look) / (4 * COLUMNS))
        is_within = bool((size + bound * error <= margins).all())
        if is_within or (size - ROUNDING * found.truth > enough * error).any():
            return tried
    return None
