"""Pairs whose samples other pairs take over."""

from dataclasses import dataclass
from typing import Any

from gradient_domain.paired_domain import PLUS, PairValue
from gradient_domain.pairs import Pairs
from gradient_domain.shifts import OuterShift
from reference.arrays import Indices, Scalars
from reference.records import take
from reference.resampling.reservoir import Reservoirs


@dataclass(frozen=True, slots=True, eq=False)
class PairDonor:
    """Donors and receivers that are pairs of pixels.

    Attributes
    ----------
    forward, backward : OuterShift; from the donors to the K receivers, and back
    pairs : Pairs; K receivers
    pairs_from : Pairs; P donors
    reservoirs : Reservoirs; P rows of `PairedPaths`
    rows : (K,) int; row that is offered to each receiver, or ``NONE``
    dx, dy : (K,) float64, pixels
        How far places move from the donor to the receiver, if x_1 moves.
    sign, sign_from : int; of the receivers' reservoirs, and of the donors'
    same_domain : bool
        Donor and receiver are one pair of one image, and nothing is shifted.
    """

    forward: OuterShift
    backward: OuterShift
    pairs: Pairs
    pairs_from: Pairs
    reservoirs: Reservoirs
    rows: Indices
    dx: Scalars
    dy: Scalars
    sign: int = PLUS
    sign_from: int = PLUS
    same_domain: bool = False

    def shifted(self, at: Indices) -> tuple[PairValue, Scalars]:
        """Worth of the donors' samples at the receivers.

        Parameters
        ----------
        at : (A,) int; receivers, none without a donor

        Returns
        -------
        PairValue, (A,) float64; as of `OuterShift`
        """
        samples = take(self.reservoirs.y, self.rows[at])
        there = take(self.pairs, at)
        return self.forward(samples, there, self.dx[at], self.dy[at], self.sign)

    def inverse(self, samples: Any, at: Indices) -> tuple[PairValue, Scalars]:
        """Worth of the receivers' samples at their donors.

        Parameters
        ----------
        samples : PairedPaths; K rows, at the receivers
        at : (A,) int; which of them, none without a donor

        Returns
        -------
        PairValue, (A,) float64
            As of `OuterShift`, for what the donors' reservoirs stand for.
        """
        some, there = take(samples, at), take(self.pairs_from, self.rows[at])
        return self.backward(some, there, -self.dx[at], -self.dy[at], self.sign_from)
