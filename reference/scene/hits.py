"""From hits to surface points: where, with which normal, of which colour."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    dot,
    normalize,
    zero_vectors,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.geometry import (
    Geometry,
    inside,
    on_triangles,
    texture_coordinates,
)
from restir_gi.reference.scene.origins import step_before
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.scene.textures import Bitmap, Checker, read


@dataclass(frozen=True, slots=True)
class Hits:
    """Where rays met primitives, N rows.

    Attributes
    ----------
    primitive : (N,) int32; triangle, or sphere after the last triangle; -1 for a miss
    u, v : (N,) float64
        Barycentric coordinates of the second and third vertex, on triangles.
    distance : (N,) float64, m; along the ray; inf for a miss
    """

    primitive: Indices
    u: Scalars
    v: Scalars
    distance: Scalars


def surface_points(
    geometry: Geometry, hits: Hits, origin: Vec3s, direction: Vec3s
) -> SurfacePoints:
    """Points, normals and materials where rays met the scene.

    Parameters
    ----------
    origin, direction : (N, 3) float64; the rays; unit directions

    Returns
    -------
    SurfacePoints
        Positions from the barycentric coordinates, in float64, a ``STEP`` before the
        triangle; on spheres, exactly on the sphere.
    """
    primitive = hits.primitive
    hit = primitive >= 0
    on_sphere = primitive >= geometry.triangles
    points = _on_triangles(geometry, hits)
    if on_sphere.any():
        rows = np.flatnonzero(on_sphere)
        sphere = primitive[rows] - geometry.triangles
        ray = origin[rows] + hits.distance[rows, None] * direction[rows]
        outward = normalize(ray - geometry.center[sphere])
        radius = geometry.radius[sphere][:, None]
        points[0][rows] = geometry.center[sphere] + radius * outward
        points[1][rows] = np.where(geometry.inward[sphere][:, None], -outward, outward)
    position, normal = points
    front = dot(normal, direction) < 0
    facing = np.where(front, 1.0, -1.0)[:, None]
    material = np.where(hit, geometry.material[primitive], 0).astype(np.int32)
    color = _colors(geometry, hits, material, hit, normal)
    smooth = None
    if geometry.smooth is not None:
        smooth = _smooth_normals(geometry, hits, on_sphere, normal) * facing
        # Interpolation may turn a normal below its own face; the face then decides.
        above = dot(smooth, normal) * facing[:, 0] > 0
        smooth = np.where(above[:, None], smooth, normal * facing)
    # Where Embree found a point, rays leave from a step before it: along the normal,
    # and back along the ray that came.  That ray has just shown the way to be free, so
    # the step stays before every other surface that touches the point, as in a corner.
    normal *= facing
    wo = -direction
    position = position + step_before(geometry, primitive, normal, wo)
    return SurfacePoints(
        position=position,
        normal=normal,
        smooth=smooth,
        wo=wo,
        color=color,
        material=material,
        primitive=primitive,
        front=front & hit,
    )


def _on_triangles(geometry: Geometry, hits: Hits) -> tuple[Vec3s, Vec3s]:
    size = len(hits.primitive)
    if geometry.triangles == 0:
        return zero_vectors(size), zero_vectors(size)
    is_triangle = (hits.primitive >= 0) & (hits.primitive < geometry.triangles)
    rows = np.where(is_triangle, hits.primitive, 0)
    u, v = inside(geometry, rows, hits.u, hits.v)
    position, normal = on_triangles(geometry, rows, u, v)
    if not is_triangle.all():
        position[~is_triangle], normal[~is_triangle] = 0.0, 0.0
    return position, normal


def _barycentric(corners: Scalars, hits: Hits, rows: Indices) -> Scalars:
    u, v = hits.u[rows, None], hits.v[rows, None]
    blended: Scalars = (
        (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
    )
    return blended


def _smooth_normals(
    geometry: Geometry, hits: Hits, on_sphere: Masks, normal: Vec3s
) -> Vec3s:
    smooth = normal.copy()
    rows = np.flatnonzero((hits.primitive >= 0) & ~on_sphere)
    if geometry.smooth is not None and len(rows):
        corners = geometry.smooth[hits.primitive[rows]]
        smooth[rows] = normalize(_barycentric(corners, hits, rows))
    return smooth


def _colors(
    geometry: Geometry, hits: Hits, material: Indices, hit: Masks, normal: Vec3s
) -> Vec3s:
    table = geometry.materials
    color = take(table.color, material)
    if not hit.all():
        color[~hit] = 0.0
    for index, texture in enumerate(table.textures):
        if not isinstance(texture, Bitmap | Checker):
            continue
        rows = np.flatnonzero(hit & (material == index))
        if len(rows):
            uv = _texture_coordinates(geometry, take(hits, rows), normal[rows])
            color[rows] = read(texture, uv)
    if geometry.color is not None:
        rows = np.flatnonzero(hit & (hits.primitive < geometry.triangles))
        corners = geometry.color[hits.primitive[rows]]
        color[rows] *= _barycentric(corners, hits, rows)
    return color


def _texture_coordinates(geometry: Geometry, hits: Hits, normal: Vec3s) -> Scalars:
    outward = normal
    if len(geometry.radius):
        sphere = np.maximum(hits.primitive - geometry.triangles, 0)
        outward = np.where(geometry.inward[sphere][:, None], -normal, normal)
    return texture_coordinates(geometry, hits.primitive, hits.u, hits.v, outward)
