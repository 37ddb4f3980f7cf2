"""A mean against its truth where no bound of the variables is known.

By Student's statistic, which rests on a finite variance.  For independent variables its
tail beyond z is that of Student's t times a factor that the skewness γ leaves, about
exp(|γ| z³ / 3√n): the p-values here are multiplied by it, with γ as it was seen.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class RelativeMoments:
    """Sums of powers of y / μ − 1 over independent replicates y, a column a statistic.

    Attributes
    ----------
    truth : (columns,) float64; μ > 0
    count : int; n
    first, second, third : (columns,) float64
    """

    truth: Floats
    count: int
    first: Floats
    second: Floats
    third: Floats


def open_moments(truth: Floats) -> RelativeMoments:
    """Sums before the first replicate.

    Parameters
    ----------
    truth : (columns,) float64; μ > 0
    """
    zeros = np.zeros_like(truth)
    return RelativeMoments(truth, 0, zeros, zeros, zeros)


def extended(moments: RelativeMoments, y: Floats) -> RelativeMoments:
    """Sums after more replicates, (R, columns)."""
    d = y / moments.truth - 1
    return RelativeMoments(
        moments.truth,
        moments.count + len(d),
        moments.first + d.sum(axis=0),
        moments.second + (d**2).sum(axis=0),
        moments.third + (d**3).sum(axis=0),
    )


def standard_error(moments: RelativeMoments) -> tuple[Floats, Floats]:
    """Mean of y / μ − 1 and its standard error, (columns,) each."""
    mean = moments.first / moments.count
    squares = np.maximum(moments.second - moments.count * mean**2, 0.0)
    return mean, np.sqrt(squares / (moments.count * (moments.count - 1)))


def p_values(moments: RelativeMoments, room: float) -> Floats:
    """Probability of so large a deviation if the means are within `room` of the truth.

    Parameters
    ----------
    room : float; relative, of the rounding of the replicates

    Returns
    -------
    (columns,) float64; two-sided; of a column that never varies 0 or 1
    """
    n = moments.count
    mean, error = standard_error(moments)
    beyond = np.maximum(np.abs(mean) - room, 0.0)
    z = np.divide(beyond, error, out=np.where(beyond > 0, np.inf, 0.0), where=error > 0)
    log_factor = np.abs(_skewness(moments)) * np.minimum(z, 1e3) ** 3 / (3 * n**0.5)
    with np.errstate(divide="ignore"):  # the logarithm of 0 is what is meant
        log_p = np.log(2 * stdtr(n - 1, -z)) + log_factor
    return np.asarray(np.exp(np.minimum(log_p, 0.0)))


def _skewness(moments: RelativeMoments) -> Floats:
    n = moments.count
    m, second, third = (
        total / n for total in (moments.first, moments.second, moments.third)
    )
    variance = np.maximum(second - m**2, 0.0)
    cubed = third - 3 * m * second + 2 * m**3
    return np.divide(cubed, variance**1.5, out=np.zeros_like(m), where=variance > 0)
