"""Pixels whose targets were written down, of whatever BSDF."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.builtin.world import point_keys
from restir_gi.reference.passes.pixels import FrameReservoirs, NeighborPixels, Pixels
from restir_gi.reference.resampling.reservoir import Samples

# Number of the visible point, (Q,), place of the sample, (Q, 3), and target, (Q,).
Given = tuple[Indices, Vec3s, Scalars]


@dataclass(frozen=True, slots=True, eq=False)
class WrittenTargets:
    """Targets by visible point and sample.

    Attributes
    ----------
    keys : (Q,) uint64; rising
    values : (Q,), radiance/sr
    """

    keys: NDArray[np.uint64]
    values: Scalars

    def of(self, viewer: Indices, position: Vec3s) -> Scalars:
        """Targets of samples, (N,); 0 of what nobody has written down.

        Parameters
        ----------
        viewer : (N,) int; numbers of visible points
        position : (N, 3), m; of the samples
        """
        wanted = point_keys(viewer, position)
        place = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        known = self.keys[place] == wanted
        return np.where(known, self.values[place], self.values[place] * 0)


def written_targets(given: Iterable[Given]) -> WrittenTargets:
    """Targets in the order of their keys."""
    viewer, position, value = (
        np.concatenate(parts) for parts in zip(*given, strict=True)
    )
    keys = point_keys(viewer, position)
    order = np.argsort(keys, kind="stable")
    return WrittenTargets(keys[order], value[order])


@dataclass(frozen=True, slots=True, eq=False)
class GivenPixels(Pixels):
    """Pixels whose targets were written down."""

    targets: WrittenTargets | None = None

    def target(self, y: Samples) -> Scalars:
        """Target p̂_q(y), (K,), radiance/sr; without visibility."""
        return self.target_at(self.points.primitive, y)

    def target_at(self, viewer: Indices, y: Samples) -> Scalars:
        """Target of samples at visible points by their numbers, (K,), radiance/sr."""
        assert self.targets is not None
        return self.targets.of(viewer, y.position)


@dataclass(frozen=True, slots=True, eq=False)
class GivenFrame(FrameReservoirs):
    """Reservoirs of pixels whose targets were written down."""

    def neighbors(self, q: Pixels, rows: Indices) -> NeighborPixels:
        """Pixels of this frame beside each q; (K,) rows, or ``NONE``."""
        x = take(self.visible.surface.viewpoints, np.maximum(rows, 0))
        return GivenNeighbors(q, self, rows, x, self.at(rows))


@dataclass(frozen=True, slots=True, eq=False)
class GivenNeighbors(NeighborPixels):
    """Pixels q_n whose targets were written down."""

    def target(self, rows: Indices, y: Samples) -> Scalars:
        """Target of samples at pixels of this frame, (A,), whoever may hide them."""
        number = self.frame.visible.surface.primitive[rows]
        return cast(GivenPixels, self.q).target_at(number, y)

    def supports(self, y: Samples) -> Masks:
        """Whether samples have a target above 0 at q_n, (K,), whoever may hide them."""
        supported: Masks = self.target(np.maximum(self.rows, 0), y) > 0
        return supported


def with_targets(q: Pixels, given: Iterable[Given]) -> GivenPixels:
    """The same pixels, with targets that were written down."""
    about: dict[str, Any] = {"targets": written_targets(given)}
    return GivenPixels(q.world, q.points, replace(q.settings), q.shift, **about)
