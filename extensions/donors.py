"""Those whose samples a pixel may take over, and how samples come from them and back.

Generalized resampling asks no more of a sample than this: what it is worth where it
comes from, what its shift is worth at the receiver, and what another sample would have
been worth at the donor.
"""

from dataclasses import dataclass
from typing import Any, Protocol

from extensions.shifting import Shift
from reference.arrays import Indices, Scalars
from reference.resampling.reservoir import Reservoirs
from reference.scene.surface import SurfacePoints
from reference.world import World

# Value, and Jacobian of the shift; 0 where it does not exist.  The value is all that
# a sample has of its own at each receiver: its f / p, (N, 3), or a record of more.
Worth = tuple[Any, Scalars]


class Donor(Protocol):
    """A frame of reservoirs, of which K receivers are offered one each."""

    @property
    def reservoirs(self) -> Reservoirs:
        """N rows, of records with a ``value`` that can be ``moved``."""

    @property
    def rows(self) -> Indices:
        """(K,) int: row that is offered to each receiver, or ``NONE``."""

    @property
    def stands(self) -> bool:
        """Whether donor and receiver are one point, and nothing is shifted."""

    def forth(self, at: Indices) -> Worth:
        """Worth of the donors' samples at the receivers ``at``."""

    def back(self, samples: Any, at: Indices) -> Worth:
        """Worth at their donors of K samples of the receivers, those ``at``."""


@dataclass(frozen=True, slots=True, eq=False)
class PointDonor:
    """Donors and receivers that each see one point.

    Attributes
    ----------
    shift : Shift
        Of paths.
    world, points : World, SurfacePoints
        Of the K receivers.
    world_from, points_from : World, SurfacePoints
        In which the N paths were made, and what their pixels saw.
    reservoirs : Reservoirs
        N rows of `extensions.paths.Paths`.
    rows : (K,) int
        Row that is offered to each pixel, or ``NONE``.
    stands : bool
        Donor and pixel are one point, and nothing is shifted.
    """

    shift: Shift
    world: World
    points: SurfacePoints
    world_from: World
    points_from: SurfacePoints
    reservoirs: Reservoirs
    rows: Indices
    stands: bool = False

    def forth(self, at: Indices) -> Worth:
        """Worth of the donors' paths at the receivers.

        Parameters
        ----------
        at : (A,) int
            Receivers, none without a donor.

        Returns
        -------
        (A, 3), (A,) float64
            Value, and Jacobian.
        """
        paths, rows = self.reservoirs.y, self.rows[at]
        return self.shift(self.world, self.points, at, paths, rows)

    def back(self, samples: Any, at: Indices) -> Worth:
        """Worth of the receivers' paths at their donors.

        Parameters
        ----------
        samples : Paths
            K rows, at the receivers.
        at : (A,) int
            Which of them, none without a donor.

        Returns
        -------
        (A, 3), (A,) float64
            Value, and Jacobian.
        """
        rows = self.rows[at]
        return self.shift(self.world_from, self.points_from, rows, samples, at)
