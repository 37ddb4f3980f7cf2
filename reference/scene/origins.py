"""Where rays start: a step before their surface, or at the edge of the scene."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, dot
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.surface import SurfacePoints

STEP = 2.0**-19
"""How far before its triangle a point stands, in half extents of the scene.

Embree holds vertices in float32, rounded by 2⁻²⁴ in each of three coordinates, and its
intersection adds a few roundings more.  2⁻¹⁹ is 32 of them.
"""


FAR = 4.0
"""Rays that start further out, in half extents, are brought to the scene in float64."""


def step_before(
    geometry: Geometry, primitive: Indices, normal: Vec3s, wo: Vec3s
) -> Vec3s:
    """Offset from a point on a surface to where its rays start.

    Parameters
    ----------
    primitive : (N,) int32; what was hit; rays are exact on spheres and need no step
    normal, wo : (N, 3) float64
        Unit normal on the side that was seen, and direction back along the ray.

    Returns
    -------
    (N, 3) float64, m
        Add it to go before the surface, subtract it to return to the surface.
    """
    step = STEP * geometry.extent
    offset: Vec3s = (normal + wo) * step
    if len(geometry.radius):
        offset = np.where((primitive < geometry.triangles)[:, None], offset, 0.0)
    return offset


def contact(geometry: Geometry, points: SurfacePoints) -> Vec3s:
    """Points on the surfaces themselves, without the step.

    Returns (N, 3) float64, m; where the rays met the surface.
    """
    offset = step_before(geometry, points.primitive, points.normal, points.wo)
    touched: Vec3s = points.position - offset
    return touched


def leaving(geometry: Geometry, points: SurfacePoints, direction: Vec3s) -> Vec3s:
    """Origins of rays that leave surface points, to either side.

    Parameters
    ----------
    direction : (N, 3) float64; unit vectors

    Returns
    -------
    (N, 3) float64, m
        The points themselves; for rays into the surface, as far behind it.
    """
    below = dot(points.normal, direction) < 0
    if not below.any():
        return points.position
    behind = contact(geometry, points) - points.normal * (STEP * geometry.extent)
    return np.where(below[:, None], behind, points.position)


def approach(o: Vec3s, d: Vec3s) -> tuple[Vec3s, Scalars]:
    """Bring origins that are far away to the edge of the scene, in float64.

    Parameters
    ----------
    o : (N, 3) float64, half extents from the middle of the scene; origins
    d : (N, 3) float64; unit directions

    Returns
    -------
    (N, 3), (N,) float64; origins, and how far they were advanced
    """
    outside = dot(o, o) > FAR * FAR
    if not outside.any():
        return o, np.zeros(len(o))
    advance = np.where(outside, np.maximum(-dot(o, d) - 2.0, 0.0), 0.0)
    return o + advance[:, None] * d, advance
