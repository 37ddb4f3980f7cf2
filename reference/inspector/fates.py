"""What became of a candidate, and why: asked again, since the passes keep no log."""

from enum import IntEnum

import numpy as np

from reference.arrays import Indices, Masks, Scalars
from reference.passes.entries import Entry
from reference.passes.receivers import Receivers
from reference.passes.shifting import shift
from reference.records import take
from reference.resampling.reservoir import Samples


class Fate(IntEnum):
    """What became of a candidate, in the order in which it is asked."""

    UNTRIED = 0
    ABSENT = 1
    EMPTY = 2
    DARK = 3
    REFUSED = 4
    EDGE_ON = 5
    HIDDEN = 6
    COMPETED = 7


WORDS = {
    Fate.UNTRIED: "not tried",
    Fate.ABSENT: "nobody: outside, not similar, or the pixel itself",
    Fate.EMPTY: "holds no light",
    Fate.DARK: "sends no light here",
    Fate.REFUSED: "its Jacobian is beyond the limit",
    Fate.EDGE_ON: "its Jacobian is 0",
    Fate.HIDDEN: "hidden from here",
    Fate.COMPETED: "competed",
}
"""Fates as they are read."""


def shifted(receivers: Receivers, entry: Entry, y: Samples) -> tuple[Scalars, Masks]:
    """How candidates came to their receivers.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    entry : Entry
        Of each.
    y : Samples
        Its samples, at the receivers.

    Returns
    -------
    (K,) float64, sr/sr; (K,) bool
        Factor on W, 1 where nothing was shifted or the settings leave it out; and
        whether the shift was not refused.

    Notes
    -----
    [Ouyang21, Eq. 11].
    """
    rows = len(entry.candidate.w)
    all_of, every = np.ones(rows), np.ones(rows, bool)
    if entry.origin is None:
        return all_of, every
    x_from, passage = entry.origin.x.position, entry.origin.donors.passage
    if passage:
        x_from = passage.beside(y, x_from)
    moved = shift(receivers.settings, x_from, receivers.points.position, y)
    return (
        all_of if moved.factor is None else moved.factor,
        every if moved.possible is None else moved.possible,
    )


def fates(entry: Entry, y: Samples, jacobian: Scalars, possible: Masks) -> Indices:
    """What became of the candidates of one place in the stream.

    Parameters
    ----------
    entry : Entry
        Of K receivers, weighted with M.
    y : Samples
        Its samples, at the receivers.
    jacobian : (K,) float64, sr/sr
        Factor on W.
    possible : (K,) bool
        The shift was not refused.

    Returns
    -------
    (K,) int
        Of `Fate`; the first reason there is.
    """
    candidate = entry.candidate
    reasons = {
        Fate.ABSENT: candidate.M <= 0,
        Fate.EMPTY: _empty(entry, y),
        Fate.DARK: candidate.p_hat <= 0,
        Fate.REFUSED: ~possible,
        Fate.EDGE_ON: jacobian <= 0,
        Fate.HIDDEN: candidate.w <= 0,
    }
    return np.select(list(reasons.values()), list(reasons), Fate.COMPETED)


def _empty(entry: Entry, y: Samples) -> Masks:
    if entry.origin is None:  # W is not to be had, but a null has no radiance
        null: Masks = y.radiance.max(axis=1) <= 0
        return null
    rows = np.maximum(entry.origin.rows, 0)
    empty: Masks = take(entry.origin.donors.reservoirs.W, rows) <= 0
    return empty
