"""Rays: what is hit first, and whether two points see each other.

The only file that knows Embree, which works in float32.  The scene is handed to it
moved and scaled into the cube [-1, 1]³, so that its rounding is the same relative to
every scene, however small or far from the origin.  Surface points stand a step before
their triangle (:data:`reference.scene.hits.STEP`), so that rays start where they are.
"""

import threading
from collections import Counter

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from reference.arrays import Indices, Masks, Scalars, Vec3s, divide_or_zero, dot
from reference.records import take
from reference.scene.geometry import Geometry
from reference.scene.hits import STEP, Hits, contact
from reference.scene.surface import SurfacePoints

STOP = 2.0**-17
"""How far before its target a visibility ray ends; occluders closer do not count."""

BEYOND = 1e30
"""Reach of rays that end nowhere; within float32."""

FAR = 4.0
"""Rays that start further out, in half extents, are brought to the scene in float64."""


class RayCaster:
    """Closest hits and visibility in one scene; counts its rays by kind.

    Parameters
    ----------
    geometry : Geometry
        The scene.

    Attributes
    ----------
    counts : Counter of str
        Rays traced so far: 'primary', 'bounce', 'shadow', 'reuse', ...
    """

    def __init__(self, geometry: Geometry) -> None:
        self.counts: Counter[str] = Counter()
        self._lock = threading.Lock()
        self._geometry = geometry
        self._middle, self._extent = geometry.middle, geometry.extent
        self._center = (geometry.center - self._middle) / self._extent
        self._radius = geometry.radius / self._extent
        self._embree: EmbreeScene | None = None
        if geometry.triangles:
            self._embree = _commit(geometry)

    def from_camera(self, origin: Vec3s, direction: Vec3s) -> Hits:
        """First primitive along rays that start in free space.

        Parameters
        ----------
        origin : (N, 3) float64, m
            Anywhere but on a surface.
        direction : (N, 3) float64
            Unit vectors.

        Returns
        -------
        Hits
            Primitive -1 and distance inf where nothing is hit.
        """
        self._count("primary", len(origin))
        o, advance = _approach(self._normalized(origin), direction)
        hits = self._closest_triangle(o, direction)
        hits = self._closest_sphere(o, direction, hits, None)
        distance = (hits.distance + advance) * self._extent
        return Hits(hits.primitive, hits.u, hits.v, distance)

    def from_surface(self, points: SurfacePoints, direction: Vec3s, kind: str) -> Hits:
        """First primitive along rays that leave surface points.

        Parameters
        ----------
        points : SurfacePoints
            N points.
        direction : (N, 3) float64
            Unit vectors; below the surface the ray starts behind it.
        kind : str
            What the rays are counted as.

        Returns
        -------
        Hits
            Primitive -1 and distance inf where nothing is hit.
        """
        self._count(kind, len(points))
        origin = points.position
        below = dot(points.normal, direction) < 0
        if below.any():
            # To the other side: as far behind the surface as the point is before it.
            inner = contact(self._geometry, points)
            inner -= points.normal * (STEP * self._extent)
            origin = np.where(below[:, None], inner, origin)
        hits = self._closest_triangle(self._single(origin), direction)
        if len(self._radius):
            exact = self._normalized(points.position)
            hits = self._closest_sphere(exact, direction, hits, points.primitive)
        return Hits(hits.primitive, hits.u, hits.v, hits.distance * self._extent)

    def visible(
        self,
        points: SurfacePoints,
        rows: Indices,
        x_to: Vec3s,
        n_to: Vec3s,
        kind: str,
    ) -> Masks:
        """Whether surface points see other points.

        Parameters
        ----------
        points : SurfacePoints
            N points.
        rows : (K,) int
            Those that look.
        x_to : (K, 3) float64, m
            Points looked at, on their surfaces.
        n_to : (K, 3) float64
            Unit normals there, either side, or 0 for a point in free space.
        kind : str
            What the rays are counted as.

        Returns
        -------
        (K,) bool
            Nothing lies between, up to ``STOP`` of the scene before ``x_to``.
        """
        x_from = take(points.position, rows)
        toward = x_to - x_from
        side = np.where(dot(n_to, toward) > 0, -STEP, STEP) * self._extent
        offset = n_to * side[:, None]
        offset += toward
        distance = np.sqrt(dot(offset, offset))
        shorter = np.maximum(distance - STOP * self._extent, 0.0)
        share = divide_or_zero(shorter, distance)
        offset *= share[:, None]
        free = self._no_triangle(x_from, offset, 1.0, kind)
        if len(self._radius):
            free &= self._no_sphere(x_from, points.primitive[rows], toward, share)
        return free

    def escapes(
        self, points: SurfacePoints, rows: Indices, direction: Vec3s, kind: str
    ) -> Masks:
        """Whether rays from surface points leave the scene.

        Parameters
        ----------
        points : SurfacePoints
            N points.
        rows : (K,) int
            Those from which the rays start.
        direction : (K, 3) float64
            Unit vectors.
        kind : str
            What the rays are counted as.

        Returns
        -------
        (K,) bool
            Nothing lies in that direction.
        """
        x_from = take(points.position, rows)
        free = self._no_triangle(x_from, direction * self._extent, BEYOND, kind)
        if len(self._radius):
            endless = np.full(len(rows), np.inf)
            free &= self._no_sphere(x_from, points.primitive[rows], direction, endless)
        return free

    def _normalized(self, x: Vec3s) -> Vec3s:
        moved: Vec3s = (x - self._middle) / self._extent
        return moved

    def _single(self, x: Vec3s) -> Vec3s:
        # Rounded to float32 last, in one pass with the division.
        moved = x - self._middle
        single: Vec3s = np.empty(moved.shape, np.float32)
        np.divide(moved, self._extent, out=single, casting="same_kind")
        return single

    def _no_triangle(
        self, origin: Vec3s, along: Vec3s, reach: float, kind: str
    ) -> Masks:
        self._count(kind, len(origin))
        if self._embree is None or len(origin) == 0:
            return np.ones(len(origin), bool)
        single = np.empty(along.shape, np.float32)
        answer = self._embree.run(
            self._single(origin),
            np.divide(along, self._extent, out=single, casting="same_kind"),
            query="OCCLUDED",
            dists=np.full(len(origin), reach, np.float32),
        )
        free: Masks = answer != 0
        return free

    def _no_sphere(
        self, origin: Vec3s, start: Indices, along: Vec3s, reach: Scalars
    ) -> Masks:
        o, d = self._normalized(origin), along / self._extent
        free = np.ones(len(o), bool)
        for index in range(len(self._radius)):
            t = self._sphere_hit(o, d, index, start)
            free &= ~(t < reach)
        return free

    def _closest_triangle(self, o: Vec3s, d: Vec3s) -> Hits:
        size = len(o)
        if self._embree is None or size == 0:
            none = np.zeros(size)
            return Hits(np.full(size, -1, np.int32), none, none, np.full(size, np.inf))
        answer = self._embree.run(
            o.astype(np.float32, copy=False),
            d.astype(np.float32),
            query="INTERSECT",
            output=True,
        )
        distance = answer["tfar"].astype(np.float64)
        distance[answer["primID"] < 0] = np.inf
        u, v = answer["u"].astype(np.float64), answer["v"].astype(np.float64)
        return Hits(answer["primID"], u, v, distance)

    def _closest_sphere(
        self, o: Vec3s, d: Vec3s, hits: Hits, start: Indices | None
    ) -> Hits:
        primitive, distance = hits.primitive, hits.distance
        for index in range(len(self._radius)):
            t = self._sphere_hit(o, d, index, start)
            closer = t < distance
            distance = np.where(closer, t, distance)
            this = np.int32(self._geometry.triangles + index)
            primitive = np.where(closer, this, primitive)
        return Hits(primitive, hits.u, hits.v, distance)

    def _sphere_hit(
        self, o: Vec3s, d: Vec3s, index: int, start: Indices | None
    ) -> Scalars:
        near, far = _sphere_crossings(o, d, self._center[index], self._radius[index])
        if start is not None:
            # A ray that starts on this sphere crosses it at 0, rounded either way.
            on_it = start == self._geometry.triangles + index
            leaves_at_near = np.abs(near) < np.abs(far)
            near = np.where(on_it & leaves_at_near, -np.inf, near)
            far = np.where(on_it & ~leaves_at_near, -np.inf, far)
        return np.where(near > 0, near, np.where(far > 0, far, np.inf))

    def _count(self, kind: str, rays: int) -> None:
        with self._lock:
            self.counts[kind] += rays


def _commit(geometry: Geometry) -> EmbreeScene:
    first, edge_u, edge_v = (geometry.triangle[:, i] for i in range(3))
    corners = np.stack([first, first + edge_u, first + edge_v], axis=1)
    corners = (corners - geometry.middle) / geometry.extent
    vertices = np.ascontiguousarray(corners.reshape(-1, 3), np.float32)
    faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, vertices, faces)
    # Embree builds its tree at the first query, which must not happen in two threads.
    one = np.zeros((1, 3), np.float32)
    scene.run(one, one + np.float32(1.0), query="OCCLUDED")
    return scene


def _approach(o: Vec3s, d: Vec3s) -> tuple[Vec3s, Scalars]:
    outside = dot(o, o) > FAR * FAR
    advance = np.where(outside, np.maximum(-dot(o, d) - 2.0, 0.0), 0.0)
    return (o + advance[:, None] * d if outside.any() else o), advance


def _sphere_crossings(
    o: Vec3s, d: Vec3s, center: Vec3s, radius: float
) -> tuple[Scalars, Scalars]:
    relative = o - center
    a, b = dot(d, d), dot(relative, d)
    a = np.where(a > 0, a, 1.0)
    # The distance of the centre from the line: no cancellation far from the sphere.
    foot = relative - (b / a)[:, None] * d
    discriminant = (radius - np.sqrt(dot(foot, foot))) * (
        radius + np.sqrt(dot(foot, foot))
    )
    root = np.sqrt(np.maximum(discriminant, 0.0) / a)
    misses = discriminant < 0
    near, far = -b / a - root, -b / a + root
    return np.where(misses, np.inf, near), np.where(misses, np.inf, far)
