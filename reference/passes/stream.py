"""Entries compete, one after the other: Algorithm 1."""

import numpy as np

from reference.arrays import Indices, Masks, Scalars
from reference.passes.entries import Donors, Entry
from reference.records import NONE, take, where
from reference.resampling.reservoir import Candidates, Samples, merge


def stream(entries: list[Entry], decisions: list[Scalars]) -> Candidates:
    """Let entries compete, one after the other.

    Parameters
    ----------
    entries : list of Entry
        In the order of their places.
    decisions : list of (K,) float64
        One number in [0, 1) for each entry; that of the first decides nothing.

    Returns
    -------
    Candidates
        ``y`` is the place of the entry whose sample was kept.

    Notes
    -----
    [Ouyang21, Alg. 1 and Alg. 4, line 14].
    """
    chosen = entries[0].candidate
    for entry, u in zip(entries[1:], decisions[1:], strict=True):
        chosen = merge(chosen, entry.candidate, u)
    return chosen


def kept_samples(entries: list[Entry], place: Indices) -> Samples:
    """Samples of the entries that were chosen.

    Parameters
    ----------
    entries : list of Entry
        The stream.
    place : (K,) int
        In the stream.

    Returns
    -------
    Samples
        K rows.
    """
    y: Samples | None = None
    for part, here in [*_standing(entries, place), *_arrived(entries, place)]:
        y = part if y is None else where(here, part, y)
    assert y is not None
    return y


def _standing(entries: list[Entry], place: Indices) -> list[tuple[Samples, Masks]]:
    """One gather for all entries of the same donors, of samples as they stand there."""
    rows: dict[int, Indices] = {}
    donors: dict[int, Donors] = {}
    for k, entry in enumerate(entries):
        if entry.y is None and entry.origin:
            key = id(entry.origin.donors)
            donors[key] = entry.origin.donors
            missing = np.full(len(place), NONE)
            before = rows.get(key, missing)
            rows[key] = np.where(place == k, entry.origin.rows, before)
    return [
        (take(donors[key].reservoirs.y, np.maximum(row, 0)), row != NONE)
        for key, row in rows.items()
    ]


def _arrived(entries: list[Entry], place: Indices) -> list[tuple[Samples, Masks]]:
    return [(e.y, place == k) for k, e in enumerate(entries) if e.y is not None]
