"""Many tests at once, however they depend on each other.

Tiles, channels and scenes share their paths, so nothing here assumes independence.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def average_e(e: ArrayLike, weights: ArrayLike | None = None) -> float:
    """Weighted mean Σ w e of e-values, itself an e-value under any dependence.

    Vovk and Wang 2021.  An e of its own level α needs m / α here: a mean over m
    columns costs what a Bonferroni correction costs, and less if several are large.

    Parameters
    ----------
    e : (columns,) float64; from 0 to infinity
    weights : (columns,) float64, optional
        w, chosen before the data; their sum is 1.  Equal if not given.

    Returns
    -------
    float; infinite if one e with a positive weight is

    Raises
    ------
    ValueError
        A NaN, a negative e, or weights that are none.
    """
    values = _checked(e)
    if weights is None:
        w = np.full(values.shape, 1 / max(values.size, 1))
    else:
        w = np.asarray(weights, np.float64)
    # m numbers that were rounded to a sum of 1 miss it by at most m eps.
    slack = values.size * np.finfo(np.float64).eps
    if w.shape != values.shape or np.any(w < 0) or not abs(np.sum(w) - 1) <= slack:
        raise ValueError("weights must be non-negative, one for each e, of sum 1")
    return float(np.sum(w[w > 0] * values[w > 0]))


def rejects(e: ArrayLike, alpha: float) -> NDArray[np.bool_]:
    """Whether e >= 1/α: for a claim that is true, with probability at most α.

    Parameters
    ----------
    e : (...) float64; e-values

    Returns
    -------
    (...) bool
        By Ville's inequality the rate holds for the first time that this is true,
        however often it is asked of a growing sample.
    """
    return np.asarray(_checked(e) >= 1 / alpha)


def e_benjamini_hochberg(e: ArrayLike, alpha: float) -> NDArray[np.bool_]:
    """Which columns to name: the k largest e, for the largest k with k e₍ₖ₎ / m >= 1/α.

    Wang and Ramdas 2022.  It says where, after `average_e` has said whether.

    Parameters
    ----------
    e : (columns,) float64; e-values

    Returns
    -------
    (columns,) bool
        Among the named, the expected share of innocent ones is at most α, under any
        dependence.
    """
    values = _checked(e)
    falling = np.sort(values)[::-1]
    enough = np.arange(1, values.size + 1) * (falling / values.size) >= 1 / alpha
    if not enough.any():
        return np.zeros(values.shape, bool)
    return np.asarray(values >= falling[np.flatnonzero(enough)[-1]])


def bonferroni(p: ArrayLike) -> float:
    """One p-value for m, min(1, m min p), valid under any dependence.

    Parameters
    ----------
    p : (columns,) float64; p-values

    Returns
    -------
    float; a p-value of "all m claims are true"
    """
    return float(min(1.0, np.size(p) * np.min(_checked(p))))


def p_to_e(p: ArrayLike, kappa: float = 0.05) -> Floats:
    """E-value κ p^(κ − 1) of a p-value, (...) float64; infinite where p = 0.

    Vovk and Wang 2021.  ∫₀¹ κ p^(κ − 1) dp = 1, and a p-value is at least uniform.
    With κ = 0.05, e = 1e6 takes p = 2.1e-8: where only p-values are combined,
    `bonferroni` is sharper.

    Parameters
    ----------
    p : (...) float64; from 0 to 1
    kappa : float
        κ in (0, 1), chosen before the data.  1 / ln(1 / p) gives the largest e at p:
        0.05 is made for p near 1e-9.
    """
    values = np.asarray(_checked(p))
    logs = np.log(values, out=np.full(values.shape, -np.inf), where=values > 0)
    e = np.exp(np.minimum(np.log(kappa) + (kappa - 1) * logs, 709.0))
    return np.where(values > 0, e, np.inf)


def _checked(values: ArrayLike) -> Floats:
    found = np.asarray(values, np.float64)
    # A NaN would compare as "not rejected".
    if not np.all(found >= 0):
        raise ValueError("e-values and p-values are numbers that are not negative")
    return found
