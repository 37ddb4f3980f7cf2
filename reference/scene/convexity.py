"""Whether anything can stand between two points of a scene's surfaces."""

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars, dot, triangle_normal
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere

MOST_TRIANGLES = 2000
"""Beyond so many, a scene is taken to have obstacles."""

FLAT = 2.0**-30
"""How far out of a plane a vertex may be, in extents of the scene: well below what a
ray resolves, well above the rounding of float64."""


def first_obstacle(scene: Scene) -> Mesh | Sphere | None:
    """A shape that may stand between two points; ``None`` if certainly none does.

    Points of surfaces, point and spot lights.

    Parameters
    ----------
    scene : Scene; validated

    Returns
    -------
    Mesh, Sphere or None
        ``None`` for a single sphere, and for triangles that all lie on the surface of
        their convex hull: a segment between two of them runs inside the hull, or
        within one of its faces.  Point and spot lights have to be inside, too.
    """
    lights = np.array([lamp.position for lamp in scene.lamps]).reshape(-1, 3)
    if scene.spheres:
        first = scene.spheres[0]
        alone = len(scene.spheres) == 1 and not scene.meshes
        away = np.linalg.norm(lights - np.asarray(first.center), axis=1)
        inside = bool((away < first.radius).all())
        return None if alone and inside else first
    parts = [world_corners(mesh) for mesh in scene.meshes]
    corners = np.concatenate(parts)
    if len(corners) > MOST_TRIANGLES:
        return max(scene.meshes, key=lambda mesh: len(mesh.faces))
    vertices = np.unique(corners.reshape(-1, 3), axis=0)
    for mesh, part in zip(scene.meshes, parts, strict=True):
        if not _supports(part, np.concatenate([vertices, lights])).all():
            return mesh
    return None


def _supports(corners: Scalars, vertices: Scalars) -> Masks:
    """Whether all vertices lie on one side of each triangle's plane."""
    a, b, c = (corners[:, k] for k in range(3))
    normal = triangle_normal(b - a, c - a)
    height = normal @ vertices.T - dot(normal, corners[:, 0])[:, None]
    flat = FLAT * float(np.ptp(vertices, axis=0).max())
    above, below = (height <= flat).all(axis=1), (height >= -flat).all(axis=1)
    return np.asarray(above | below)
