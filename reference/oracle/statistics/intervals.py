"""Truths that were estimated, and may be wrong themselves."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr, stdtrit

Floats = NDArray[np.float64]


def truth_interval(
    mean: ArrayLike, standard_error: ArrayLike, deviations: float
) -> tuple[Floats, Floats]:
    """Interval mean ± k standard errors of an independent estimate, cut off at 0.

    Parameters
    ----------
    mean, standard_error : (columns,) float64; of the estimate of the truth
    deviations : float; k

    Returns
    -------
    ((columns,), (columns,)) float64; its ends
    """
    center = np.asarray(mean, np.float64)
    width = deviations * np.asarray(standard_error, np.float64)
    return np.maximum(center - width, 0.0), center + width


def student_deviations(deviations: float, samples: int) -> float:
    """Standard errors that are exceeded as rarely where the error was estimated too.

    Parameters
    ----------
    deviations : float; k, where the error is known
    samples : int; n ≥ 2, from which mean and error were estimated

    Returns
    -------
    float; k' ≥ k with P(t > k') = Φ(−k), of Student's t with n − 1 degrees of freedom
    """
    return float(-stdtrit(samples - 1, ndtr(-deviations)))


def outside_probability(deviations: float, truths: int) -> float:
    """Probability that one of m truths lies outside its interval, min(1, 2 m Φ(−k)).

    It is to be added to α.  It takes the estimates for normal, which the means of many
    samples of light are only nearly: this is the one part of the statement that is not
    proved.

    Parameters
    ----------
    deviations : float; k
    truths : int; m
    """
    return float(min(1.0, 2.0 * truths * ndtr(-deviations)))
