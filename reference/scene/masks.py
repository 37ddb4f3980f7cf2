"""Alpha masks: where meshes have holes."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    zero_vectors,
)
from restir_gi.reference.scene.geometry import (
    Geometry,
    barycentric,
    texture_coordinates,
)
from restir_gi.reference.scene.textures import read


def is_solid(geometry: Geometry, primitive: Indices, u: Scalars, v: Scalars) -> Masks:
    """Whether there is a surface at points of primitives, or a hole.

    Parameters
    ----------
    primitive : (N,) int; triangles and spheres; -1 for none
    u, v : (N,) float64
        Barycentric coordinates of the second and third vertex, on triangles.

    Returns
    -------
    (N,) bool; True wherever there is no mask
    """
    solid = np.ones(len(primitive), bool)
    if geometry.mask is None:
        return solid
    triangle = (primitive >= 0) & (primitive < geometry.triangles)
    mask = np.where(triangle, geometry.mask[np.where(triangle, primitive, 0)], -1)
    for index, alpha in enumerate(geometry.masks):
        rows = np.flatnonzero(mask == index)
        if len(rows):
            place = primitive[rows], u[rows], v[rows]
            uv = texture_coordinates(geometry, *place, zero_vectors(len(rows)))
            opacity = read(alpha.opacity, uv).mean(axis=1)
            solid[rows] = opacity >= alpha.cutoff
    return solid


def is_solid_at(geometry: Geometry, primitive: Indices, x: Vec3s) -> Masks:
    """Whether there is a surface at points in space, or a hole.

    Parameters
    ----------
    primitive : (N,) int; triangles and spheres
    x : (N, 3) float64, m; points on them, to rounding

    Returns
    -------
    (N,) bool; True wherever there is no mask
    """
    u, v = np.zeros(len(x)), np.zeros(len(x))
    rows = np.flatnonzero(primitive < geometry.triangles)
    u[rows], v[rows] = barycentric(geometry, primitive[rows], x[rows])
    return is_solid(geometry, primitive, u, v)
