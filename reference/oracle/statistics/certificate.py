"""How large a bias can still be, after what was seen: a bound for every time.

The bets of :mod:`restir_gi.reference.oracle.statistics.betting` are placed against many
candidates for the mean at once, μ (1 + b) for each b of a grid.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restir_gi.reference.oracle.statistics.betting import Bets, open_bets, place

Floats = NDArray[np.float64]

DECADES = 4  # the smallest bias of the grid is 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """Bets of one statistic against every candidate.

    Attributes
    ----------
    biases : (columns,) float64; b of the candidates, rising
    ceiling : float; B / μ − 1, the largest bias that the bound leaves
    bets : Bets; a column a candidate
    peak_brighter, peak_darker : (columns,) float64
        The largest log K⁺ and log K⁻ so far: what was rejected once stays rejected.
    """

    biases: Floats
    ceiling: float
    bets: Bets
    peak_brighter: Floats
    peak_darker: Floats


def bias_grid(steps: int = 32) -> Floats:
    """Relative biases from −1 to 1: equal steps of log |b| down to 1e-4, and 0.

    Parameters
    ----------
    steps : int
        Candidates a decade on either side.  A certificate is too large by one step
        at most: 7.5 % of itself at 32.

    Returns
    -------
    (8 steps + 3,) float64; rising
    """
    sizes = 10.0 ** np.linspace(-DECADES, 0, DECADES * steps + 1)
    return np.concatenate([-sizes[::-1], np.zeros(1), sizes])


def open_certificate(
    truth: float, bound: float, biases: ArrayLike | None = None
) -> Certificate:
    """Certificate before the first replicate.

    Parameters
    ----------
    truth : float; μ > 0
    bound : float; B >= μ, proven: a guess would certify nothing from above
    biases : (columns,) float64, optional
        Rising, not below −1; `bias_grid` if not given.

    Returns
    -------
    Certificate; without the candidates at B or above, which the bound refutes

    Raises
    ------
    ValueError
        Not 0 < truth <= bound.
    """
    if not 0 < truth <= bound:
        raise ValueError("a relative bias needs 0 < truth <= bound")
    grid = bias_grid() if biases is None else np.asarray(biases, np.float64)
    grid = grid[truth * (1 + grid) < bound]
    bets = open_bets(truth * (1 + grid), bound)
    return Certificate(
        grid, bound / truth - 1, bets, bets.log_brighter, bets.log_darker
    )


def extend(certificate: Certificate, y: float) -> Certificate:
    """Certificate after one more replicate.

    Parameters
    ----------
    certificate : Certificate; of the replicates before
    y : float; the statistic of one independent replicate
    """
    bets = place(certificate.bets, y)
    return replace(
        certificate,
        bets=bets,
        peak_brighter=np.maximum(certificate.peak_brighter, bets.log_brighter),
        peak_darker=np.maximum(certificate.peak_darker, bets.log_darker),
    )


def certified_interval(certificate: Certificate, alpha: float) -> tuple[float, float]:
    """Ends of an interval that holds the bias, always, with probability 1 − α.

    Returns
    -------
    (float, float)
        Ends of −1 and B / μ − 1 before anything is known; −∞ and ∞ once a replicate
        was not in [0, B].

    Notes
    -----
    The lower end is the largest candidate up to which K⁺ has rejected every one, at
    2/α; the upper end the smallest from which on K⁻ has.  This holds between the
    candidates too.  Let the bias be b and c the first candidate not below it, which no
    data have chosen.  A lower end at b or above it says that c is rejected by K⁺; but
    every mean up to μ (1 + c) leaves K⁺ no expected gain, so that happens with
    probability α/2 at most, over all times together.  Likewise above.  Biases outside
    of the grid are covered by its last candidates.
    """
    beyond_dark = certificate.biases > -1
    if np.isposinf(certificate.peak_brighter[beyond_dark]).any():
        return -np.inf, np.inf
    limit = np.log(2 / alpha)
    below = np.minimum.accumulate(certificate.peak_brighter >= limit)
    above = np.minimum.accumulate(certificate.peak_darker[::-1] >= limit)[::-1]
    low = float(np.max(certificate.biases[below], initial=-1.0))
    high = float(np.min(certificate.biases[above], initial=certificate.ceiling))
    return low, high


def certified_bias(certificate: Certificate, alpha: float) -> float:
    """Bound on |b|, the larger end of `certified_interval`.

    The probability that it is ever below the bias is at most α: sampling may stop when
    it is small enough.

    The smallest candidate that is rejected with all beyond it, so one step of the grid
    more than the largest |b| that is still possible; at least 1e-4.
    """
    low, high = certified_interval(certificate, alpha)
    return max(abs(low), abs(high))
