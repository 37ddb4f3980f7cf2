"""Weighted reservoir sampling: Algorithm 1 of the paper.

While samples compete they are :class:`Candidates`; a closed choice is a
:class:`Reservoirs`.  The running sum w lives in the first alone: it is rebuilt from
W and M at every pass, after M was capped.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    saturate,
)
from restir_gi.reference.numerics.records import where
from restir_gi.reference.resampling.suffix import Suffix


@dataclass(frozen=True, slots=True)
class Samples:
    """Sample points x_s, N rows.

    Attributes
    ----------
    position : (N, 3), m; x_s, where a ray from a visible point met a surface
    normal : (N, 3); n_s, unit geometric normal on the side that was seen
    radiance : (N, 3), W/(m² sr)
        L_o, that leaves x_s on that side, taken to be the same in all directions;
        0 for a null: a miss, or a path that found no light.
    suffix : Suffix or None
        What finds the radiance again; ``None`` where it need not be found again.
    """

    position: Vec3s
    normal: Vec3s
    radiance: Vec3s
    suffix: Suffix | None = None


@dataclass(frozen=True, slots=True)
class Candidates:
    """Open reservoirs, N rows: samples still compete.

    Attributes
    ----------
    y : record or (N,) array; the samples, or whatever stands for them
    p_hat : (N,); target p̂ of the sample at the receiver
    w : (N,); sum of resampling weights
    M : (N,); sum of confidence weights
    """

    y: Any
    p_hat: Scalars
    w: Scalars
    M: Scalars


@dataclass(frozen=True, slots=True)
class Reservoirs:
    """Closed reservoirs, N rows: a sample with its weight, E[f(y) W] = ∫ f dω.

    Attributes
    ----------
    W : (N,), sr; unbiased contribution weight, 0 for an empty row
    M : (N,); confidence weight
    """

    y: Any
    W: Scalars
    M: Scalars


def merge(a: Candidates, b: Candidates, u: Scalars) -> Candidates:
    """Keep b's sample with probability b.w / (a.w + b.w), else a's.

    [Ouyang21, Alg. 1, lines 6 to 10].

    Parameters
    ----------
    u : (N,); uniform in [0, 1)

    Returns
    -------
    Candidates
        Weights and confidences are summed, up to the largest number.  Merging is
        associative in distribution, so that a stream of any length is a fold.
    """
    take_b = choose_second(a.w, b.w, u)
    y, p_hat = where(take_b, b.y, a.y), np.where(take_b, b.p_hat, a.p_hat)
    with np.errstate(over="ignore"):
        w = a.w + b.w
        M = a.M + b.M
    return Candidates(y=y, p_hat=p_hat, w=saturate(w), M=saturate(M))


def choose_second(w_a: Scalars, w_b: Scalars, u: Scalars) -> Masks:
    """Whether the second of two weights is drawn: u (w_a + w_b) < w_b.

    [Ouyang21, Eq. 4].

    Parameters
    ----------
    w_a, w_b : (N,); non-negative weights
    u : (N,); uniform in [0, 1)

    Returns
    -------
    (N,) bool
        Strict, so that a row of weight 0 is never taken; and a positive weight
        always is, against 0, even where u · w rounds to w.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        taken: Masks = (u * (w_a + w_b) < w_b) | ((w_a == 0) & (w_b > 0))
    return taken.astype(bool, copy=False)


def finalize(c: Candidates, normalization: Scalars) -> Reservoirs:
    """Close the reservoirs: W = w / (normalization · p̂(y)).

    [Ouyang21, Eq. 7].

    Parameters
    ----------
    normalization : (N,)
        What the sum of weights is divided by: M, Z, or the balance heuristic's; see
        :mod:`restir_gi.reference.resampling.reservoir`.

    Returns
    -------
    Reservoirs
        W = 0 where p̂ = 0 or nothing could be kept; at most the largest number of its
        dtype, which a subnormal p̂ beside a large w would exceed.
    """
    # Two divisions: the product may underflow where the quotient does not.
    with np.errstate(over="ignore"):
        W = divide_or_zero(divide_or_zero(c.w, c.p_hat), normalization)
    return Reservoirs(y=c.y, W=saturate(W), M=c.M)


def initial_candidates(
    y: Any, p_hat: Scalars, pdf: Scalars, M: Scalars | None = None
) -> Candidates:
    """Fresh samples: w = M p̂ / p.

    [Ouyang21, Eq. 5].

    Parameters
    ----------
    p_hat : (N,); target of each
    pdf : (N,), 1/sr; source density of each
    M : (N,), optional
        1 where a sample was drawn, nulls included, and 0 elsewhere; by default 1.

    Returns
    -------
    Candidates; w = 0 where p̂, p or M is, at most the largest number
    """
    with np.errstate(over="ignore", invalid="ignore"):
        w = divide_or_zero(p_hat, pdf)
        w = w if M is None else w * M
    M = np.ones_like(w) if M is None else M
    return Candidates(y=y, p_hat=p_hat, w=saturate(w), M=M)


def reused_candidates(
    r: Reservoirs, p_hat: Scalars, jacobian: Scalars | None = None
) -> Candidates:
    """Closed reservoirs compete again: w = p̂(T(y)) · W · M · |∂T/∂y|.

    [Ouyang21, Alg. 1, line 12].  The weight is *multiplied* by the Jacobian: Algorithm
    4, line 11, prints a division, which is right for a density.

    Parameters
    ----------
    r : Reservoirs; neighbours; M already capped
    p_hat : (N,); target of their samples at the receiver, 0 where it cannot use them
    jacobian : (N,) or None, sr/sr
        |∂ω_to / ∂ω_from|; ``None`` where neighbour and receiver are one point.

    Returns
    -------
    Candidates; M counts where w = 0 too; w is at most the largest number
    """
    with np.errstate(over="ignore", invalid="ignore"):
        w = p_hat * r.W * r.M
        if jacobian is not None:
            w = w * jacobian
    w = saturate(w)
    return Candidates(y=r.y, p_hat=p_hat, w=w, M=r.M)


def cap_confidence(r: Reservoirs, cap: float) -> Reservoirs:
    """Limit trust in the past: M becomes min(M, cap).

    Parameters
    ----------
    r : Reservoirs; N rows
    cap : float; at least 1; inf for no limit

    Returns
    -------
    Reservoirs; W is unchanged: the cap is on confidence, not on the estimate
    """
    return Reservoirs(y=r.y, W=r.W, M=np.minimum(r.M, cap))


# ------------------------------------------ what the sum of weights is divided by
#
# A stream of reservoirs k with confidences M_k put sample z, made by reservoir s, into
# the receiver.  Each weight below is Σ_k M_k c_k(z) / c_s(z) for another c_k; the
# estimate is unbiased if c_k is 0 exactly where k cannot make z.


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
