"""Pairwise MIS weights: each neighbour is weighed against the receiver's own reservoir.

The balance heuristic asks everybody about every sample.  Here a neighbour's sample asks
two, the neighbour k and the receiver's own, canonical reservoir c; only the sample of c
asks all.  With S = Σ M_k over the neighbours, and all at one sample y in the measure of
the receiver,

    neighbour's share      a_k = S p_k / (S p_k + M_c p_c)
    canonical's share  1 - a_k

and a neighbour's pair counts with M_k / S.  The defensive form hands c the share
M_c / T of every sample beforehand, T = M_c + S, and the pairs M_k / T.

The weights m stand *in* the resampling weight, w = m · p̂(T(y)) · W · |∂T/∂y|, in place
of M: nothing divides the sum of weights afterwards, and the reservoir is closed with a
normalization of 1.
"""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, divide_or_zero, plus
from restir_gi.reference.resampling.reservoir import one_over_m


def pairwise_neighbor(
    M_k: Scalars,
    p_k: Scalars,
    M_c: Scalars,
    p_c: Scalars,
    S: Scalars,
    defensive: bool,
) -> Scalars:
    """Weight m_k of a neighbour's own sample: (M_k / S) · S p_k / (S p_k + M_c p_c).

    Of [Lin22], written out in the text of the module.  To be multiplied with
    p̂ W |∂T/∂y| in place of M; the sum of weights is then not divided.  One ray: whether
    the receiver sees the sample.

    Parameters
    ----------
    M_k : (N,); confidence of the neighbour, 0 where there is none
    p_k : (N,), radiance/sr
        Target of its sample at the neighbour times |∂ω_k / ∂ω_receiver|; 0 outside of
        D_k.
    M_c : (N,); confidence of the canonical reservoir
    p_c : (N,), radiance/sr; target of the neighbour's sample at the receiver
    S : (N,); sum of the confidences of all neighbours, *without* M_c
    defensive : bool; M_k / (S + M_c) in place of M_k / S

    Returns
    -------
    (N,); from 0 to 1; 0 without a neighbour, and where both targets are 0
    """
    total = plus(S, M_c) if defensive else S
    return divide_or_zero(M_k * _share(S, p_k, M_c, p_c), total)


def pairwise_canonical(
    M_k: list[Scalars],
    p_k: list[Scalars],
    M_c: Scalars,
    p_c: Scalars,
    defensive: bool,
) -> Scalars:
    """Weight m_c of the canonical sample: Σ_k (M_k / S) · M_c p_c / (S p_k + M_c p_c).

    Parameters
    ----------
    M_k : list of (N,)
        Confidences of all neighbours, nulls included; 0 where a slot is empty.
    p_k : list of (N,), radiance/sr
        Target of the *canonical* sample at each neighbour times |∂ω_k / ∂ω_receiver|; 0
        outside of D_k.
    M_c : (N,); confidence of the canonical reservoir
    p_c : (N,), radiance/sr; target of its sample at the receiver
    defensive : bool
        M_c / (S + M_c) plus the sum with M_k / (S + M_c) in place of M_k / S.

    Returns
    -------
    (N,); from 0 to 1; 1 without neighbours

    Notes
    -----
    Of [Lin22], written out in the text of the module.  With the m_k of those that can
    make a sample it sums to 1, for every sample of the receiver's domain, as long as
    M_c > 0: a neighbour outside of whose domain the sample lies leaves all of its M_k
    to the canonical reservoir, which must be there to take it.  One ray a neighbour:
    whether it sees the canonical sample.
    """
    one = M_c * 0 + 1
    if not M_k:
        return one
    S = one_over_m(M_k)
    shares = [M * _share(M_c, p_c, S, p) for M, p in zip(M_k, p_k, strict=True)]
    if defensive:
        return divide_or_zero(plus(one_over_m(shares), M_c), plus(S, M_c))
    return np.where(S > 0, divide_or_zero(one_over_m(shares), S), one)


def _share(M_a: Scalars, p_a: Scalars, M_b: Scalars, p_b: Scalars) -> Scalars:
    # Targets in units of the larger one: M p may overflow, and the sum underflow.
    unit = np.maximum(p_a, p_b)
    a, b = M_a * divide_or_zero(p_a, unit), M_b * divide_or_zero(p_b, unit)
    return divide_or_zero(a, plus(a, b))
