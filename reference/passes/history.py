"""What the last frame hands on to the pixels of this one."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.numerics.records import NONE, indices, select
from restir_gi.reference.passes.pixels import FrameReservoirs, NeighborPixels, Pixels
from restir_gi.reference.resampling.reservoir import Reservoirs


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Reservoirs of the last frame, and where each pixel of this one finds its own.

    Attributes
    ----------
    temporal, spatial : FrameReservoirs; of the last frame
    pixel : (N,) int or None
        Pixel of the last frame that each pixel goes on from, or ``NONE`` where it
        starts over; ``None`` while every pixel is at its own place.
    shifted : bool
        The pixels were other points then, so that samples are shifted between them;
        false where they were the same, or are taken to be, as in the paper.
    seen : (N,) bool or None; final visibility in the last frame, where it was asked for
    """

    temporal: FrameReservoirs
    spatial: FrameReservoirs
    pixel: Indices | None = None
    shifted: bool = False
    seen: Masks | None = None

    def rows(self, rows: slice | Indices) -> slice | Indices:
        """Pixels of the last frame for those of this one, (K,), or ``NONE``."""
        return rows if self.pixel is None else self.pixel[rows]

    def confidence(self, last: FrameReservoirs, rows: slice | Indices) -> Scalars:
        """M of K pixels in the last frame, (K,); 0 where they start over."""
        there = self.rows(rows)
        if self.pixel is None:
            return last.reservoirs.M[there]
        return np.where(there != NONE, last.reservoirs.M[there], 0.0)

    def of(
        self, last: FrameReservoirs, q: Pixels, rows: slice | Indices
    ) -> Reservoirs | NeighborPixels:
        """Reservoirs of pixels, (K,): their own, or those of the points they were."""
        there = self.rows(rows)
        if self.shifted:
            return last.neighbors(q, indices(there))
        if self.pixel is None:
            return select(last.reservoirs, there)
        return last.at(indices(there))
