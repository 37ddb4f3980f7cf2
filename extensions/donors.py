"""Neighbours whose samples are whole paths from one visible point each."""

from dataclasses import dataclass
from typing import Any

from extensions.shifting import Shift
from reference.arrays import Indices
from reference.resampling.generalized import Shifted
from reference.resampling.reservoir import Reservoirs
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class PointDonor:
    """Donors and receivers that each see one point.

    Attributes
    ----------
    world, points : World, SurfacePoints; of the K receivers
    world_from, points_from : World, SurfacePoints
        In which the N paths were made, and what their pixels saw.
    reservoirs : Reservoirs; N rows of `extensions.paths.Paths`
    rows : (K,) int; row that is offered to each pixel, or ``NONE``
    same_domain : bool; donor and pixel are one point, and nothing is shifted
    """

    shift: Shift
    world: World
    points: SurfacePoints
    world_from: World
    points_from: SurfacePoints
    reservoirs: Reservoirs
    rows: Indices
    same_domain: bool = False

    def shifted(self, at: Indices) -> Shifted:
        """Values of the donors' paths at the receivers.

        Parameters
        ----------
        at : (A,) int; receivers, none without a donor

        Returns
        -------
        (A, 3), (A,) float64; value, and Jacobian
        """
        paths, rows = self.reservoirs.y, self.rows[at]
        return self.shift(self.world, self.points, at, paths, rows)

    def inverse(self, samples: Any, at: Indices) -> Shifted:
        """Values of the receivers' paths at their donors.

        Parameters
        ----------
        samples : Paths; K rows, at the receivers
        at : (A,) int; which of them, none without a donor

        Returns
        -------
        (A, 3), (A,) float64; value, and Jacobian
        """
        rows = self.rows[at]
        return self.shift(self.world_from, self.points_from, rows, samples, at)
