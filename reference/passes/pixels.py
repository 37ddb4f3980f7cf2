"""Pixels q, neighbours q_n and history on real surfaces."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.numerics.records import NONE, indices, select, take
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.resampling.target import supports, target, target_if_drawn
from restir_gi.reference.scene.surface import SurfacePoints, Viewpoints, VisiblePoints
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.world import World


def reconnection(x_from: Vec3s, x_to: Vec3s, y: Samples) -> Scalars:
    """Jacobian of Equation 11, (K,) sr/sr, for samples.

    Parameters
    ----------
    x_from, x_to : (K, 3), m; visible points
    """
    return reconnection_jacobian(x_from, x_to, y.position, y.normal)


@dataclass(frozen=True, slots=True, eq=False)
class Pixels:
    """Pixels q that resample, K rows.

    Attributes
    ----------
    points : SurfacePoints; x_v, their visible points
    settings : Settings; source density and target
    shift : callable
        From x_from, x_to, (K, 3) in m, and samples to the Jacobian of their
        reconnection, (K,), 0 where it is refused.
    refuses : callable or None
        From the same arguments to whether the reconnection is refused for its Jacobian,
        (K,) bool, so that Z can leave out whoever would not have been heard.
    """

    world: World
    points: SurfacePoints
    settings: Settings
    shift: Callable[[Vec3s, Vec3s, Samples], Scalars] = reconnection
    refuses: Callable[[Vec3s, Vec3s, Samples], Masks] | None = None

    def target(self, y: Samples) -> Scalars:
        """Target p̂_q(y), (K,), radiance/sr; without visibility."""
        return target(self.settings.target, self.world.materials, self.points, y)

    def sees(self, y: Samples, asked: Masks) -> Masks:
        """Whether x_v sees y, (K,) bool: a ray each; false where not asked."""
        return sees(self.world, self.points, y, asked)


def sees(
    world: World, points: SurfacePoints | Viewpoints, y: Samples, asked: Masks
) -> Masks:
    """Whether visible points see sample points, (K,) bool; false where not asked."""
    return world.caster.visible(points, y.position, y.normal, asked, "reuse")


@dataclass(frozen=True, slots=True, eq=False)
class FrameReservoirs:
    """Reservoirs of a whole frame, and the visible points that they belong to.

    Attributes
    ----------
    visible : VisiblePoints; G-buffer of their frame, N rows
    """

    world: World
    visible: VisiblePoints
    reservoirs: Reservoirs

    def at(self, rows: Indices) -> Reservoirs:
        """Reservoirs of pixels, (K,); of ``NONE``, M and W are 0."""
        there = rows != NONE
        r = take(self.reservoirs, np.maximum(rows, 0))
        return replace(r, W=np.where(there, r.W, 0.0), M=np.where(there, r.M, 0.0))

    def neighbors(self, q: Pixels, rows: Indices) -> "NeighborPixels":
        """Pixels of this frame beside each q; (K,) rows, or ``NONE``."""
        x = take(self.visible.surface.viewpoints, np.maximum(rows, 0))
        return NeighborPixels(q, self, rows, x, self.at(rows))


@dataclass(frozen=True, slots=True, eq=False)
class NeighborPixels:
    """Pixels q_n, one for each of K pixels q.

    Attributes
    ----------
    frame : FrameReservoirs; whose pixels these are
    rows : (K,) int; which of them, or ``NONE``
    x : Viewpoints; their visible points
    reservoirs : Reservoirs; R_n, K rows
    """

    q: Pixels
    frame: FrameReservoirs
    rows: Indices
    x: Viewpoints
    reservoirs: Reservoirs

    def jacobian(self) -> Scalars:
        """|∂ω_q / ∂ω_n| of their samples, Equation 11; (K,), sr/sr."""
        return self.q.shift(self.x.position, self.q.points.position, self.reservoirs.y)

    def could_make(self, y: Samples, asked: Masks) -> Masks:
        """Whether y lies in the domain of q_n, (K,) bool; false where not asked.

        There it is drawn with a density above 0, has a target above 0, which alone says
        nothing with the target of Equation 10, and is seen.
        """
        asked = asked & (self.rows != NONE)
        y, x_q = self.before(y, asked)
        possible = asked & self.supports(y)
        if self.q.refuses is not None:
            possible &= ~self.q.refuses(self.x.position, x_q, y)
        return sees(self.frame.world, self.x, y, possible)

    def before(self, y: Samples, asked: Masks) -> tuple[Samples, Vec3s]:
        """Samples at q as they were in the frame of q_n, (K,), and x_v of q."""
        return y, self.q.points.position

    def target(self, rows: Indices, y: Samples) -> Scalars:
        """Target of samples at pixels of this frame, 0 where they draw none of them.

        Parameters
        ----------
        rows : (A,) int; the pixels

        Returns
        -------
        (A,), radiance/sr; whoever may hide them
        """
        s, points = self.q.settings, take(self.frame.visible.surface, rows)
        table = self.frame.world.materials
        return target_if_drawn(s.source, s.target, table, points, y)

    def supports(self, y: Samples) -> Masks:
        """Whether q_n draws y, (K,), with a target above 0, whoever may hide it."""
        s, frame, rows = self.q.settings, self.frame, np.maximum(self.rows, 0)
        table, surface = frame.world.materials, frame.visible.surface
        return supports(s.source, s.target, table, surface, rows, y)


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
