"""Candidates weighted in pairs, before they compete."""

from dataclasses import replace

import numpy as np

from reference.arrays import Masks, Scalars, divide_or_zero
from reference.passes.entries import Entry
from reference.passes.normalization import target_from
from reference.passes.receivers import Receivers
from reference.passes.stream import kept_samples
from reference.resampling.mis import one_over_m
from reference.resampling.pairwise import pairwise_canonical, pairwise_donor
from reference.resampling.reservoir import Samples


def in_pairs(receivers: Receivers, entries: list[Entry], canonical: int) -> list[Entry]:
    """Entries whose candidates are weighted with m in place of M.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    entries : list of Entry
        Weighted with M.
    canonical : int
        Place of the receivers' own entry.

    Returns
    -------
    list of Entry
        In the same order; the sum of their w needs no division.

    Notes
    -----
    Costs as many rays as 1/Z: one to the donor's sample, one from the donor to the
    canonical sample.
    """
    defensive = receivers.settings.mis == "defensive"
    own = entries[canonical].candidate
    donors = [k for k in range(len(entries)) if k != canonical]
    M_k = [entries[k].candidate.M for k in donors]
    # The canonical sample asks every donor.
    y, alive = _samples(entries, canonical), own.w > 0
    p_k = [
        _target_at(receivers, entries[k], y, own.p_hat, alive, made=False)
        for k in donors
    ]
    m = pairwise_canonical(M_k, p_k, own.M, own.p_hat, defensive)
    weighted = list(entries)
    weighted[canonical] = _with_weight(entries[canonical], m)
    # A donor's sample asks its donor, and the receiver.
    S = one_over_m(M_k)
    for k in donors:
        y, c = _samples(entries, k), entries[k].candidate
        p = _target_at(receivers, entries[k], y, c.p_hat, c.w > 0, made=True)
        m = pairwise_donor(c.M, p, own.M, c.p_hat, S, defensive)
        weighted[k] = _with_weight(entries[k], m)
    return weighted


def _samples(entries: list[Entry], place: int) -> Samples:
    rows = len(entries[place].candidate.M)
    return kept_samples(entries, np.full(rows, place))


def _with_weight(entry: Entry, m: Scalars) -> Entry:
    c = entry.candidate
    return replace(entry, candidate=replace(c, w=divide_or_zero(c.w, c.M) * m))


def _target_at(
    receivers: Receivers,
    entry: Entry,
    y: Samples,
    p_hat: Scalars,
    active: Masks,
    made: bool,
) -> Scalars:
    """Target of y at an entry's donors, in the measure of the receivers."""
    if entry.origin is None:
        return p_hat
    return target_from(receivers, entry.origin, y, active, active & made)
