"""Weights in pairs: each donor is weighed against the receiver's own reservoir."""

from dataclasses import replace

import numpy as np

from extensions.offers import Offer, Target, samples_of, target_at, target_made
from reference.arrays import Scalars, divide_or_zero
from reference.resampling.mis import one_over_m
from reference.resampling.pairwise import pairwise_canonical, pairwise_donor


def in_pairs(offers: list[Offer], defensive: bool, target: Target) -> list[Offer]:
    """Offers whose candidates are weighted with m in place of M.

    Parameters
    ----------
    offers : list of Offer
        Weighted with M; the last of those that stand is the canonical one.
    defensive : bool
        The canonical sample has a share of its own.
    target : callable
        p̂ of values.

    Returns
    -------
    list of Offer
        In the same order; the sum of their w needs no division.

    Raises
    ------
    ValueError
        No donor stands: nobody covers the domain.

    Notes
    -----
    [Lin22, Eqs. 37 and 38].  A donor's sample asks two, of whom both are known; the
    canonical sample asks all: one shift back a donor.
    """
    places = [k for k, offer in enumerate(offers) if offer.donor.stands]
    if not places:
        raise ValueError("weights in pairs need a donor that stands")
    own = offers[places[-1]]
    c = own.candidates
    donors = [offer for offer in offers if offer is not own]
    M_k = [offer.candidates.M for offer in donors]
    y = samples_of(offers, np.full(len(c.M), own.place))
    p_k = [target_at(offer, y, c.p_hat, c.w > 0, target) for offer in donors]
    m = pairwise_canonical(M_k, p_k, c.M, c.p_hat, defensive)
    weighted = [_with_weight(own, m)]
    if donors:
        S = one_over_m(M_k)
        for offer, M in zip(donors, M_k, strict=True):
            p_c = offer.candidates.p_hat
            made = target_made(offer, offer.candidates.w > 0, target)
            m = pairwise_donor(M, made, c.M, p_c, S, defensive)
            weighted.append(_with_weight(offer, m))
    return sorted(weighted, key=lambda offer: offer.place)


def _with_weight(offer: Offer, m: Scalars) -> Offer:
    c = offer.candidates
    return replace(offer, candidates=replace(c, w=divide_or_zero(c.w, c.M) * m))
