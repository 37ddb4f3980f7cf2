"""Rays: what is hit first, and whether two points see each other.

The only file that knows Embree, which works in float32.  The scene is handed to it
moved and scaled into the cube [-1, 1]³, so that its rounding is the same relative to
every scene, however small or far from the origin.  Surface points stand a step before
their triangle (:mod:`reference.scene.origins`), so that rays start where they are.
"""

import threading
from collections import Counter

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from reference.arrays import Indices, Masks, Scalars, Vec3s, divide_or_zero, dot
from reference.records import take
from reference.scene.geometry import Geometry
from reference.scene.hits import Hits
from reference.scene.origins import STEP, approach, leaving
from reference.scene.spheres import first_sphere
from reference.scene.surface import SurfacePoints

STOP = 2.0**-17
"""How far before its target a visibility ray ends; occluders closer do not count."""

BEYOND = 1e30
"""Reach of rays that end nowhere."""


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
        near, advance = approach(self._normalized(origin), direction)
        hits = self._closest_triangle(near, direction)
        if len(self._radius):
            nowhere = np.full(len(near), -1)
            hits = self._with_spheres(hits, near, direction, nowhere)
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
        origin = leaving(self._geometry, points, direction)
        hits = self._closest_triangle(self._single(origin), direction)
        if len(self._radius):
            exact = self._normalized(points.position)
            hits = self._with_spheres(hits, exact, direction, points.primitive)
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
        own = start - self._geometry.triangles
        first, _ = first_sphere(o, d, self._center, self._radius, own)
        return ~(first < reach)

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

    def _with_spheres(self, hits: Hits, o: Vec3s, d: Vec3s, start: Indices) -> Hits:
        own = start - self._geometry.triangles
        first, sphere = first_sphere(o, d, self._center, self._radius, own)
        closer = first < hits.distance
        primitive = np.where(closer, self._geometry.triangles + sphere, hits.primitive)
        distance = np.where(closer, first, hits.distance)
        return Hits(primitive.astype(np.int32), hits.u, hits.v, distance)

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
