"""Entries compete, one after the other: Algorithm 1."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.passes.entries import Entry
from reference.records import take, where
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
        The stream; entries without samples of their own share their donors.
    place : (K,) int
        In the stream.

    Returns
    -------
    Samples
        K rows.
    """
    y: Samples | None = None
    standing = [e.origin for e in entries if e.y is None and e.origin]
    if standing:
        nowhere = np.zeros_like(standing[0].rows)
        rows = [nowhere if e.y or not e.origin else e.origin.rows for e in entries]
        row = np.stack(rows)[place, np.arange(len(place))]
        y = take(standing[0].donors.reservoirs.y, row)
    for k, entry in enumerate(entries):
        if entry.y:
            y = entry.y if y is None else where(place == k, entry.y, y)
    assert y is not None
    return y
