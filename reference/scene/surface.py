"""Points on surfaces, as rays find them: what a material needs to know."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s, saturate


@dataclass(frozen=True, slots=True)
class Viewpoints:
    """N points of surfaces that only look: what visibility needs of them.

    Attributes
    ----------
    position : (N, 3) float64, m; where rays leave the surface
    primitive : (N,) int32; triangle, or sphere after the last triangle
    """

    position: Vec3s
    primitive: Indices


@dataclass(frozen=True, slots=True)
class SurfacePoints:
    """N points where rays met surfaces.

    Attributes
    ----------
    position : (N, 3) float64, m
        Where rays leave the surface: on spheres a point of it, on triangles a tiny step
        before it (:func:`restir_gi.reference.scene.origins.contact` takes it back).
    normal : (N, 3) float64; unit geometric normal on the side that the ray came from
    smooth : (N, 3) float64 or None
        Unit interpolated normal, in the hemisphere of ``normal``; ``None`` in scenes
        of flat faces.
    wo : (N, 3) float64; unit direction back along the ray
    color : (N, 3) float64; reflectance of the material here
    material : (N,) int32; row of the material table
    primitive : (N,) int32
        Triangle, or sphere after the last triangle; -1 where the ray left the scene.
    front : (N,) bool; the ray came from the front
    """

    position: Vec3s
    normal: Vec3s
    smooth: Vec3s | None
    wo: Vec3s
    color: Vec3s
    material: Indices
    primitive: Indices
    front: Masks

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.primitive)

    @property
    def hit(self) -> Masks:
        """(N,) bool: the ray met a surface."""
        met: Masks = self.primitive >= 0
        return met

    @property
    def viewpoints(self) -> Viewpoints:
        """N rows, without a copy."""
        return Viewpoints(self.position, self.primitive)

    @property
    def shading(self) -> Vec3s:
        """(N, 3): the normal about which the material scatters."""
        return self.normal if self.smooth is None else self.smooth


@dataclass(frozen=True, slots=True)
class VisiblePoints:
    """What the camera sees, a point a pixel: the G-buffer.

    Attributes
    ----------
    surface : SurfacePoints; first hits
    depth : (N,) float64, m; along the camera's axis; 0 where nothing is seen
    """

    surface: SurfacePoints
    depth: Scalars


def direction_and_distance(x_from: Vec3s, x_to: Vec3s) -> tuple[Vec3s, Scalars]:
    """Unit directions and distances from points to points.

    Parameters
    ----------
    x_from, x_to : (N, 3) float64, m; points

    Returns
    -------
    (N, 3), (N,) float64
        Zero direction where the points coincide; finite, no more, where the square of
        the distance leaves the range of the dtype.
    """
    offset = x_to - x_from
    x, y, z = offset[:, 0], offset[:, 1], offset[:, 2]
    with np.errstate(over="ignore"):
        distance = saturate(np.sqrt(x * x + y * y + z * z))
    scale = np.divide(1.0, distance, out=np.zeros_like(distance), where=distance > 0)
    return offset * scale[:, None], distance
