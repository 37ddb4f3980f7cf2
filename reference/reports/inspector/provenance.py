"""Who stands in a slot of a stream, and which path drew the sample there."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.records import NONE, indices
from restir_gi.reference.passes.pixels import History, NeighborPixels


@dataclass(frozen=True, slots=True, eq=False)
class PathNumbers:
    """Numbers of the paths that drew the samples of a frame's reservoirs, N rows each.

    A path's number is frame · pixels + pixel, as `FrameContext.numbers` gives it.

    Attributes
    ----------
    temporal, spatial : (N,) int64; or ``NONE`` where the reservoir is empty
    """

    temporal: Indices
    spatial: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """Who stands in a slot of a stream, for K pixels.

    Attributes
    ----------
    role : str; what it is to the pixel
    frame : int; whose reservoirs, or samples, these are
    rows : (K,) int; pixels of that frame, or ``NONE``
    numbers : (K,) int64; of the paths that drew the samples, or ``NONE``
    """

    role: str
    frame: int
    rows: Indices
    numbers: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Provenance:
    """What is known of where the candidates of a pass come from.

    Attributes
    ----------
    drawn : (N,) int64; paths of the new samples
    history : History or None; what the last frame handed on
    before : PathNumbers or None; of the last frame
    temporal : (N,) int64 or None
        Paths of this frame's temporal reservoirs; ``None`` in the pass that makes them.
    """

    frame: int
    drawn: Indices
    history: History | None
    before: PathNumbers | None
    temporal: Indices | None = None

    @property
    def pixels(self) -> int:
        """Number of pixels N."""
        return len(self.drawn)

    def own(self, pixels: Indices) -> Origin:
        """Of new samples, or of temporal reservoirs, of ``pixels``, (K,)."""
        if self.temporal is None:
            return _origin("new sample", self.frame, pixels, self.drawn)
        return _origin("own temporal reservoir", self.frame, pixels, self.temporal)

    def past(self, pixels: Indices) -> Origin:
        """Of the history of ``pixels``, (K,)."""
        assert self.history is not None
        assert self.before is not None
        rows = indices(self.history.rows(pixels))
        numbers = self.before.temporal if self.temporal is None else self.before.spatial
        return _origin("own past", self.frame - 1, rows, numbers)

    def neighbor(self, q_n: NeighborPixels) -> Origin:
        """Of neighbours."""
        if self.history and self.before and q_n.frame is self.history.temporal:
            numbers, frame = self.before.temporal, self.frame - 1
        elif self.history and self.before and q_n.frame is self.history.spatial:
            numbers, frame = self.before.spatial, self.frame - 1
        else:
            assert self.temporal is not None
            numbers, frame = self.temporal, self.frame
        return _origin("neighbour", frame, q_n.rows, numbers)


def _origin(role: str, frame: int, rows: Indices, numbers: Indices) -> Origin:
    found = np.where(rows != NONE, numbers[np.maximum(rows, 0)], NONE)
    return Origin(role, frame, rows, found)
