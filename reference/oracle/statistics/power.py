"""What more replicates would buy: sample sizes and smallest visible biases."""

import numpy as np
from scipy.special import ndtri


def replicates_needed(
    variation: float, bias: float, alpha: float, tests: int = 1, power: float = 0.99
) -> float:
    """Replicates that show a bias, n = (z₁₋α/₂ₘ + z_P)² CV² / b².

    Parameters
    ----------
    variation : float; CV, the standard deviation of a replicate over its mean
    bias : float; b, relative
    alpha : float; α of all tests together
    tests : int; m
    power : float; P, the probability that it is shown

    Returns
    -------
    float
        n of a two-sided test of fixed size, for normal means.  Below about 100 the true
        number is larger.
    """
    return _factor(alpha, tests, power) ** 2 * (variation / bias) ** 2


def smallest_detectable(
    variation: float, replicates: int, alpha: float, tests: int = 1, power: float = 0.99
) -> float:
    """Relative bias that n replicates show, b = (z₁₋α/₂ₘ + z_P) CV / √n.

    Parameters
    ----------
    replicates : int; n
    alpha : float; α of all tests together
    tests : int; m
    power : float; P

    Returns
    -------
    float; b, the inverse of `replicates_needed`
    """
    return _factor(alpha, tests, power) * variation / float(np.sqrt(replicates))


def _factor(alpha: float, tests: int, power: float) -> float:
    return float(ndtri(power) - ndtri(alpha / (2 * tests)))


def bets_needed(
    variation: float, bias: float, headroom: float, alpha: float, tests: int = 1
) -> float:
    """Replicates after which bets have rejected half of the time, roughly.

    Parameters
    ----------
    bias : float; b, relative, with its sign
    headroom : float; B / μ, the bound over the truth
    alpha : float; α of all tests together
    tests : int; m

    Returns
    -------
    float
        n = ln(2m/α) 2 CV² / b².  A bias below 0 takes at least ln(2m/α) 2 (B/μ) / |b|:
        a rare value near B could hold the energy that is missing.
    """
    size = 2 * (variation / bias) ** 2
    if bias < 0:
        size = max(size, -2 * headroom / bias)
    return float(np.log(2 * tests / alpha)) * size
