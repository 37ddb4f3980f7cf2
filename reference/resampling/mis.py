"""What the sum of weights is divided by: 1/M, 1/Z and the balance heuristic.

A stream of reservoirs k with confidences M_k put sample z, made by reservoir s, into
the receiver.  Each weight below is Σ_k M_k c_k(z) / c_s(z) for another c_k; the
estimate is unbiased if c_k is 0 exactly where k cannot make z.
"""

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars, divide_or_zero, saturate


def one_over_m(M_k: list[Scalars]) -> Scalars:
    """Sum Σ M_k of all confidences: c_k = 1, the paper's biased form.

    [Ouyang21, Eq. 7].

    Parameters
    ----------
    M_k : list of (N,); confidences of all reservoirs in the stream, nulls included

    Returns
    -------
    (N,); too large where some k could not have made z: the result is too dark
    """
    return _sum(M_k)


def one_over_z(M_k: list[Scalars], holds_k: list[Masks]) -> Scalars:
    """Sum Z of the confidences of those that could have made z: c_k = [z ∈ D_k].

    [Ouyang21, Alg. 4, lines 16 to 19], with the capped M_k that were streamed.

    Parameters
    ----------
    M_k : list of (N,); confidences of all reservoirs in the stream, nulls included
    holds_k : list of (N,) bool
        Whether the domain D_k holds z: above k's horizon, on the lit side of the
        sample point, and visible from k.

    Returns
    -------
    (N,); at least the confidence of the reservoir that made z
    """
    terms = [np.where(holds, M, M * 0) for M, holds in zip(M_k, holds_k, strict=True)]
    return _sum(terms)


def balance_heuristic(
    M_k: list[Scalars], p_k: list[Scalars], p_made: Scalars
) -> Scalars:
    """Generalized balance heuristic: Σ M_k p_k(z) / p_s(z).

    [Lin22, Eq. 36].  The weight is applied once, to the sample that was kept.

    Parameters
    ----------
    M_k : list of (N,); confidences of all reservoirs in the stream, nulls included
    p_k : list of (N,), radiance/sr
        Target of z at k times |∂ω_k / ∂ω_receiver|; 0 outside of D_k.
    p_made : (N,), radiance/sr; the same for the reservoir s that made z

    Returns
    -------
    (N,); 0 where nothing was kept
    """
    with np.errstate(over="ignore"):
        terms = [saturate(M * p) for M, p in zip(M_k, p_k, strict=True)]
        return saturate(divide_or_zero(_sum(terms), p_made))


def _sum(terms: list[Scalars]) -> Scalars:
    with np.errstate(over="ignore"):
        return saturate(sum(terms[1:], terms[0]))
