"""Generalized resampling: receivers take over whole samples from donors."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from extensions.donors import Donor
from extensions.offers import (
    Offer,
    Target,
    offered,
    samples_of,
    target_at,
    target_made,
)
from extensions.pairs import in_pairs
from reference.arrays import Scalars
from reference.resampling.mis import balance_heuristic, one_over_m, one_over_z
from reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    cap_confidence,
    finalize,
    merge,
)
from reference.resampling.target import luminance

Mis = Literal["1/M", "1/Z", "balance", "pairwise", "defensive"]


def resample(
    donors: Sequence[Donor],
    decisions: list[Scalars],
    mis: Mis,
    cap: float,
    target: Target = luminance,
) -> Reservoirs:
    """Choose among what the donors of each receiver offer.

    Parameters
    ----------
    donors : list of Donor
        In the order of the stream; one of them stands, so that the domain is covered.
    decisions : list of (K,)
        One number in [0, 1) for each; that of the first decides nothing.
    mis : '1/M', '1/Z', 'balance', 'pairwise' or 'defensive'
        How they share what several could have made.  1/M is biased: it counts those
        who could not have made the sample.  The last two are weights in pairs, around
        the last donor that stands.
    cap : float
        Limit of M.
    target : callable
        p̂ of values.

    Returns
    -------
    Reservoirs
        K rows; samples as they are at the receivers.

    Notes
    -----
    [Lin22, Eqs. 22 and 36 to 38].  Any dtype; nothing here knows what a sample is.
    """
    offers = [offered(donor, place, target) for place, donor in enumerate(donors)]
    if mis in ("pairwise", "defensive"):
        offers = in_pairs(offers, mis == "defensive", target)
    chosen = offers[0].candidates
    for offer, u in zip(offers[1:], decisions[1:], strict=True):
        chosen = merge(chosen, offer.candidates, u)
    y = samples_of(offers, chosen.y)
    total = _normalization(offers, chosen, y, mis, target)
    return cap_confidence(finalize(replace(chosen, y=y), total), cap)


def _normalization(
    offers: list[Offer], chosen: Candidates, y: Any, mis: Mis, target: Target
) -> Scalars:
    """Confidences of those that could have made the samples that were kept."""
    M_k = [offer.candidates.M for offer in offers]
    if mis == "1/M":
        return one_over_m(M_k)
    if mis in ("pairwise", "defensive"):
        return np.ones_like(chosen.w)
    kept = chosen.w > 0
    if mis == "1/Z":
        held = []
        for offer in offers:
            mine = kept & (chosen.y == offer.place)
            p = target_at(offer, y, chosen.p_hat, kept & ~mine, target)
            held.append(mine | (p > 0))
        return one_over_z(M_k, held)
    p_k, p_made = [], chosen.p_hat
    for offer in offers:
        mine = kept & (chosen.y == offer.place)
        made = target_made(offer, mine, target)
        p = target_at(offer, y, chosen.p_hat, kept & ~mine, target)
        p_k.append(np.where(mine, made, p))
        p_made = np.where(mine, made, p_made)
    return balance_heuristic(M_k, p_k, p_made)
