"""What the last frame hands on to the resampling of this one."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices, Masks
from reference.passes.entries import Donors, Entry, other_entry, own_entry
from reference.passes.receivers import Receivers
from reference.records import NONE, cut, take
from reference.resampling.reservoir import Reservoirs


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Reservoirs of the last frame, and where each of K pixels finds its own.

    Attributes
    ----------
    donors : Donors
        Temporal or spatial reservoirs of the whole last frame.
    rows : slice or (K,) int
        A row of it for each pixel, or ``NONE`` where it begins anew; a slice while
        every pixel is at its own place.
    as_they_stand : bool
        Nothing is shifted: the visible points are the same in the same scene, or are
        taken to be, which is the paper's biased form.
    """

    donors: Donors
    rows: slice | Indices
    as_they_stand: bool

    @property
    def reservoirs(self) -> Reservoirs:
        """K rows as they were stored; M and W are 0 where there is none."""
        if isinstance(self.rows, slice):
            return cut(self.donors.reservoirs, self.rows)
        there = self.rows != NONE
        r = take(self.donors.reservoirs, np.where(there, self.rows, 0))
        return replace(r, W=np.where(there, r.W, 0.0), M=np.where(there, r.M, 0.0))

    @property
    def indices(self) -> Indices:
        """(K,) int: the rows one by one."""
        if isinstance(self.rows, slice):
            return np.arange(self.rows.start, self.rows.stop)
        return self.rows

    def keep(self, mask: Masks) -> "History":
        """The same for some of the pixels.

        Parameters
        ----------
        mask : (K,) bool
            Which.

        Returns
        -------
        History
            A row for each that is true.
        """
        return self if mask.all() else replace(self, rows=self.indices[mask])


def past_entry(receivers: Receivers, history: History, place: int) -> Entry:
    """Entry of what the last frame left.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    history : History
        K rows.
    place : int
        In the stream.

    Returns
    -------
    Entry
        M = 0 where a pixel begins anew.
    """
    if history.as_they_stand:
        return own_entry(receivers, history.reservoirs, place)
    return other_entry(receivers, history.donors, history.indices, place)
