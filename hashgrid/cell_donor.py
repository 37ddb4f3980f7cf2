"""Vertices of the last frame that lend the paths that begin at them."""

from dataclasses import dataclass, field, replace

import numpy as np

from extensions.donors import PointDonor
from extensions.paths import Paths
from extensions.shifting import Shift
from reference.arrays import Indices, Masks
from reference.resampling.generalized import Shifted


def in_cells(shift: Shift) -> Shift:
    """How paths of cells are shifted: joined at their second point, or not at all.

    The criterion is the same.  Nothing is replayed: the numbers of a path that begins
    at a vertex are those of another pixel's path.
    """
    joined = replace(shift.criterion, last_joint=2, replays=False)
    return replace(shift, criterion=joined)


@dataclass(frozen=True, slots=True, eq=False)
class CellDonor(PointDonor):
    """Donors of paths, which are not all as long.

    Attributes
    ----------
    reach : int; largest index of a last surface point of the receivers' paths
    reach_from : (N,) int8; the same of the donors'
    """

    reach: int = field(kw_only=True)
    reach_from: Indices = field(kw_only=True)

    def shifted(self, at: Indices) -> Shifted:
        """Values of the donors' paths at the receivers.

        Parameters
        ----------
        at : (A,) int; receivers, none without a donor

        Returns
        -------
        (A, 3), (A,) float64; value, and Jacobian; 0 for paths that are too long
        """
        fits = self.reservoirs.y.end[self.rows[at]] <= self.reach
        return _those(fits, PointDonor.shifted(self, at))

    def inverse(self, samples: Paths, at: Indices) -> Shifted:
        """Values of the receivers' paths at their donors.

        Parameters
        ----------
        samples : Paths; K rows, at the receivers
        at : (A,) int; which of them, none without a donor

        Returns
        -------
        (A, 3), (A,) float64; value, and Jacobian; 0 for paths that are too long
        """
        fits = samples.end[at] <= self.reach_from[self.rows[at]]
        return _those(fits, PointDonor.inverse(self, samples, at))


def _those(fits: Masks, shifted: Shifted) -> Shifted:
    value, jacobian = shifted
    return np.where(fits[:, None], value, 0.0), np.where(fits, jacobian, 0.0)
