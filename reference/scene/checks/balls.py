"""The inside of a sphere, asked the same questions as a shell of triangles."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.scene.checks.space import distance_to_triangles


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """The inside of a sphere.

    Attributes
    ----------
    center : (3,) float64, m; of the sphere
    radius : float, m
    outward : bool; its front is the outside
    """

    center: Vec3s
    radius: float
    outward: bool

    def holds(self, x: Vec3s) -> bool:
        """Whether a point is inside; False on the surface.

        Parameters
        ----------
        x : (3,) float64, m; the point
        """
        return bool(np.linalg.norm(x - self.center) < self.radius)

    def excludes_point(self, x: Vec3s) -> bool:
        """Whether a point is outside; True on the surface.

        Parameters
        ----------
        x : (3,) float64, m; the point
        """
        return not self.holds(x)

    def excludes_triangles(self, corners: Scalars) -> bool:
        """Whether no part of some triangles is inside.

        Parameters
        ----------
        corners : (K, 3, 3) float64, m; triangles
        """
        return bool((distance_to_triangles(self.center, corners) >= self.radius).all())

    def excludes_sphere(self, center: Vec3s, radius: float) -> bool:
        """Whether no part of the surface of another sphere is inside.

        Parameters
        ----------
        center : (3,) float64, m; of the other sphere
        radius : float, m; of the other sphere

        Returns
        -------
        bool; True also where the other sphere encloses this one
        """
        apart = float(np.linalg.norm(center - self.center))
        return abs(apart - radius) >= self.radius
