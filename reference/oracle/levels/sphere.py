"""The inside of a sphere, in place of a scene."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s

ALBEDO = np.array([0.75, 0.5, 0.25])
"""Exact in any precision."""


@dataclass(frozen=True, slots=True, eq=False)
class InsideSphere:
    """The inside of the unit sphere, seen at N points.

    Attributes
    ----------
    position : (N, 3); visible points
    lit_below : float or (N,); the sphere shines with 1 where z is at most that
    """

    position: Vec3s
    lit_below: float | Scalars

    def receivers(self) -> dict[str, NDArray[Any]]:
        """Buffers of the visible points."""
        albedo = np.tile(ALBEDO, (len(self.position), 1))
        return {
            "visible_position": self.position,
            "visible_normal": -self.position,
            "albedo": albedo,
        }

    def trace(self, direction: Vec3s, frame: int) -> dict[str, NDArray[Any]]:
        """Where rays from the visible points meet the sphere.

        Parameters
        ----------
        direction : (N, 3); unit vectors
        frame : int; not used: nothing else is drawn
        """
        chord = -2 * (self.position * direction).sum(axis=1)
        met = self.position + chord[:, None] * direction
        met /= np.linalg.norm(met, axis=1)[:, None]
        radiance = self.shine(met[:, 2])[:, None] * np.ones(3)
        return {"position": met, "normal": -met, "radiance": radiance}

    def shine(self, z: Scalars) -> Scalars:
        """Radiance of the sphere at heights, (N,); 1 or 0.

        Parameters
        ----------
        z : (N,); from -1 to 1, where a ray of each point meets it
        """
        return np.where(z <= self.lit_below, 1.0, 0.0)

    def sees(self, viewer: Indices, position: Vec3s, normal: Vec3s) -> Masks:
        """Whether visible points see sample points: all do.

        Parameters
        ----------
        viewer : (N,) int; rows
        position, normal : (N, 3), m and 1; sample points

        Returns
        -------
        (N,) bool; True
        """
        return np.ones(len(viewer), bool)


def points_inside(rows: int, seed: int) -> Vec3s:
    """Points of the unit sphere, (N, 3) float64; independent and uniform.

    Parameters
    ----------
    seed : int; of the random numbers
    """
    v = np.random.default_rng(seed).normal(size=(rows, 3))
    unit: Vec3s = v / np.linalg.norm(v, axis=1)[:, None]
    return unit


def ring(rows: int, count: int, frame: int) -> Indices:
    """Neighbours on a ring, others in each frame, (N, K) int; none is the row itself.

    Parameters
    ----------
    rows : int; N
    count : int; K
    frame : int; from 0
    """
    row = np.arange(rows)
    steps = [1 + (7 * k + 3 * frame) % (rows - 1) for k in range(count)]
    return np.stack([(row + step) % rows for step in steps], axis=1)
