"""Bets against the claim that bounded variables have a given mean.

Two gamblers a column start with a capital of 1: K⁺ bets on "brighter than the truth",
K⁻ on "darker".  If the claim is true, neither capital has an expectation above 1 at any
time, so 1/α is reached with probability at most α, however skewed the variables are and
however often one looks.  A column is a tile, a channel or a scene.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restir_gi.reference.numerics.arrays import divide_or_zero

Floats = NDArray[np.float64]

LARGEST_LOG = 709.0  # exp of it is still a float64


@dataclass(frozen=True, slots=True, eq=False)
class Bets:
    """Capital and memory of the two gamblers of each column.

    Attributes
    ----------
    bound : (columns,) float64; B: the variables lie in [0, B]
    proven : (columns,) bool; whether B is proved; else B is a guess, see `e_value`
    lowest, highest : (columns,) float64, in units of B
        Ends of the interval of the truth; equal where it is exact.
    log_brighter, log_darker : (columns,) float64; logarithms of the capitals
    count : (columns,) int64; variables seen
    mean : (columns,) float64, in units of B
        Their mean, after those above B were taken for B.
    squares : (columns,) float64, in units of B²; sum of squared deviations from it
    reach : float; share of the largest bet up to which is bet
    """

    bound: Floats
    proven: NDArray[np.bool_]
    lowest: Floats
    highest: Floats
    log_brighter: Floats
    log_darker: Floats
    count: NDArray[np.int64]
    mean: Floats
    squares: Floats
    reach: float = 0.5


def open_bets(truth: ArrayLike, bound: ArrayLike, proven: ArrayLike = True) -> Bets:
    """Capitals of 1 against exact truths μ, before the first variable.

    Parameters
    ----------
    truth : (columns,) float64, or a number; μ
    bound : (columns,) float64, or a number
        B >= μ.  A backend that rounds needs a bound with its rounding added.
    proven : (columns,) bool, or a bool; whether a correct backend can never exceed B
    """
    return interval_bets(truth, truth, bound, proven)


def interval_bets(
    lowest: ArrayLike,
    highest: ArrayLike,
    bound: ArrayLike,
    proven: ArrayLike = True,
    reach: float = 0.5,
) -> Bets:
    """Capitals of 1 against truths that are only known to lie in an interval.

    No bet gains from a mean on the near side of its end, so the test holds for every
    truth in the interval at once.  The probability that the truth lies outside,
    `intervals.outside_probability`, adds to the rate of false alarms.

    Parameters
    ----------
    lowest, highest : (columns,) float64, or numbers
        Ends, as from `intervals.truth_interval`.
    bound : (columns,) float64, or a number; B, not below the lowest end
    proven : (columns,) bool, or a bool; as in `open_bets`
    reach : float
        Share of the largest bet up to which is bet, below 1, where one replicate may
        lose everything.

    Returns
    -------
    Bets; K⁺ plays against the upper end, K⁻ against the lower

    Raises
    ------
    ValueError
        Ends that are no interval of [0, B].
    """
    ends = np.broadcast_arrays(*np.atleast_1d(lowest, highest, bound, proven))
    low, high, B = (np.array(end, np.float64) for end in ends[:3])
    if not np.all((low >= 0) & (low <= high) & (low <= B) & np.isfinite(B)):
        raise ValueError("a truth must be an interval that meets [0, bound]")
    low, high = divide_or_zero(low, B), divide_or_zero(np.minimum(high, B), B)
    zeros, none = np.zeros(B.shape), np.zeros(B.shape, np.int64)
    proved = np.array(ends[3], bool)
    return Bets(B, proved, low, high, zeros, zeros, none, zeros, zeros, reach)


def place(bets: Bets, y: ArrayLike) -> Bets:
    """Bets after one more replicate.

    Parameters
    ----------
    bets : Bets; of the replicates before
    y : (columns,) float64, or a number
        One independent replicate: a whole run under its own seed.

    Returns
    -------
    Bets
        K⁺ is infinite for good in a column that is refuted: by a NaN, an infinite or a
        negative value, a value above a proven bound, or any light where the truth is 0.

    Notes
    -----
    K⁺ ← K⁺ (1 + l (y − μ)) and K⁻ ← K⁻ (1 − l (y − μ)), of Waudby-Smith and Ramdas
    2024.  Each l depends on the past alone: it is (m − μ) / (v + (m − μ)²), its sign
    turned for K⁻, between 0 and r / μ or r / (B − μ), so that no factor is below 1 − r,
    with the reach r.
    The mean m and the variance v of the past start from μ and μ² as if these were one
    replicate more.  Where B = μ, K⁻ has nothing to bet on and stays 1.

    A value above a guessed bound counts as B for K⁺: E min(Y, B) <= E Y keeps its odds
    fair.  K⁻ only meant anything as long as Y <= B, and becomes 0 for good.
    """
    y = np.broadcast_to(np.asarray(y, np.float64), bets.bound.shape)
    sound = np.isfinite(y) & (y >= 0)
    above = sound & (y > bets.bound)
    refuted = ~sound | (above & bets.proven) | ((bets.highest == 0) & (y != 0))
    x = divide_or_zero(np.minimum(np.where(sound, y, 0.0), bets.bound), bets.bound)
    brighter, darker = _bets_from_the_past(bets)
    log_bright = bets.log_brighter + np.log1p(brighter * (x - bets.highest))
    log_dark = bets.log_darker + np.log1p(-darker * (x - bets.lowest))
    count, deviation = bets.count + 1, x - bets.mean
    mean = bets.mean + deviation / count
    return replace(
        bets,
        log_brighter=np.where(refuted, np.inf, log_bright),
        log_darker=np.where(above & ~bets.proven, -np.inf, log_dark),
        count=count,
        mean=mean,
        squares=bets.squares + deviation * (x - mean),
    )


def _bets_from_the_past(bets: Bets) -> tuple[Floats, Floats]:
    prior, n = (bets.lowest + bets.highest) / 2, bets.count
    mean = (prior + n * bets.mean) / (n + 1)
    variance = (prior**2 + bets.squares) / (n + 1)
    bright, dark = mean - bets.highest, bets.lowest - mean
    # Any light at all refutes a truth of 0, so what is bet there does not matter.
    limit = bets.reach / np.maximum(bets.highest, np.finfo(np.float64).tiny)
    reach = np.full(n.shape, bets.reach)
    return (
        _bet(bright, variance, limit),
        _bet(dark, variance, divide_or_zero(reach, 1 - bets.lowest)),
    )


def _bet(gain: Floats, variance: Floats, most: Floats) -> Floats:
    best: Floats = divide_or_zero(gain, variance + gain**2)
    return np.clip(best, 0.0, most)


def e_value(bets: Bets) -> Floats:
    """Evidence e against each column: E e <= 1 at any time if the claim is true.

    Nothing can prove "too dark" under a guessed bound: the energy that is missing may
    sit in a rare value above B that was not met yet.  To stop K⁻ at the first such
    value does not help, for it has won until then; so it does not count at all.

    Returns
    -------
    (columns,) float64
        (K⁺ + K⁻) / 2 where the bound is proven, else K⁺.  Infinite if and only if
        refuted: what is more than exp(`LARGEST_LOG`) is given as that.
    """
    both = np.logaddexp(bets.log_brighter, bets.log_darker) - np.log(2.0)
    log_e = np.where(bets.proven, both, bets.log_brighter)
    return np.where(log_e < np.inf, np.exp(np.minimum(log_e, LARGEST_LOG)), np.inf)
