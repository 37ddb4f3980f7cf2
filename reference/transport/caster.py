"""What rays from surfaces meet, and what surfaces see: triangles and spheres together.

Surface points stand a step before their triangle
(:mod:`restir_gi.reference.scene.origins`), so that rays start where they are.
"""

import threading
from collections import Counter

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s, dot
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.hits import Hits
from restir_gi.reference.scene.origins import STEP, approach, leaving
from restir_gi.reference.scene.spheres import first_sphere
from restir_gi.reference.scene.surface import SurfacePoints, Viewpoints
from restir_gi.reference.transport.pierced import PiercedTriangles
from restir_gi.reference.transport.rays import ENDLESS, NOT_TRACED, Triangles

STOP = 2.0**-17
"""How far before its target a visibility ray ends; occluders closer do not count."""


class RayCaster:
    """Closest hits and visibility in one scene; counts its rays by kind.

    Rows that are not active cost next to nothing and count as misses, or as hidden.

    Parameters
    ----------
    before : RayCaster, optional
        Of another frame of the same animation, in whose counter rays are counted on.
    occlusion : bool; whether anything may stand between two points of the surfaces

    Attributes
    ----------
    counts : Counter of str
        Rays traced so far: 'primary', 'bounce', 'shadow', 'reuse', ...; those of all
        kinds that went on through a hole of an alpha mask, once more for each hole, as
        'behind masks'.
    """

    def __init__(
        self,
        geometry: Geometry,
        before: "RayCaster | None" = None,
        occlusion: bool = True,
    ) -> None:
        self.counts: Counter[str] = before.counts if before else Counter()
        self._lock: threading.Lock = before._lock if before else threading.Lock()
        self._geometry, self._occlusion = geometry, occlusion
        self._triangles: Triangles | PiercedTriangles
        if geometry.mask is None:
            self._triangles = Triangles(geometry)
        else:
            self._triangles = PiercedTriangles(geometry, self._count_behind_masks)
        self._center = (geometry.center - geometry.middle) / geometry.extent
        self._radius = geometry.radius / geometry.extent
        self._transmits = geometry.materials.transmits

    def from_camera(self, origin: Vec3s, direction: Vec3s) -> Hits:
        """First primitive along rays that start in free space.

        Parameters
        ----------
        origin : (N, 3) float64, m; anywhere but on a surface
        direction : (N, 3) float64; unit vectors

        Returns
        -------
        Hits; primitive -1 and distance inf where nothing is hit
        """
        everyone = np.ones(len(origin), bool)
        self._count("primary", everyone)
        g = self._geometry
        near, advance = approach(self._normalized(origin), direction)
        start = near * g.extent + g.middle
        reach = np.full(len(start), ENDLESS)
        hits = self._triangles.first_hits(start, direction, reach)
        if len(self._radius):
            nowhere = np.full(len(near), -1)
            hits = self._with_spheres(hits, near, direction, nowhere, everyone)
        distance = hits.distance + advance * g.extent
        return Hits(hits.primitive, hits.u, hits.v, distance)

    def from_surface(
        self, points: SurfacePoints, direction: Vec3s, active: Masks, kind: str
    ) -> Hits:
        """First primitive along rays that leave surface points.

        Parameters
        ----------
        direction : (N, 3) float64
            Unit vectors; below the surface the ray starts behind it.
        active : (N,) bool; which rays are traced

        Returns
        -------
        Hits; primitive -1 and distance inf where nothing is hit
        """
        self._count(kind, active)
        origin = leaving(self._geometry, points, direction)
        reach = np.where(active, ENDLESS, NOT_TRACED)
        hits = self._triangles.first_hits(origin, direction, reach)
        if len(self._radius):
            exact = self._normalized(points.position)
            hits = self._with_spheres(hits, exact, direction, points.primitive, active)
        return hits

    def visible(
        self,
        points: SurfacePoints | Viewpoints,
        x_to: Vec3s,
        n_to: Vec3s,
        active: Masks,
        kind: str,
    ) -> Masks:
        """Whether surface points see other points.

        Parameters
        ----------
        x_to : (N, 3) float64, m; points looked at, on their surfaces
        n_to : (N, 3) float64
            Unit normals there, on the side looked at, or 0 for points in free space.
        active : (N,) bool; who looks

        Returns
        -------
        (N,) bool
            Nothing lies between, up to ``STOP`` of the scene before ``x_to``; without
            a ray where nothing ever does.
        """
        if not self._occlusion:
            return active.copy()
        self._count(kind, active)
        step, stop = STEP * self._geometry.extent, STOP * self._geometry.extent
        origin = points.position
        if self._transmits:
            origin = self._outset(points, x_to - origin)
        along = n_to * step
        along += x_to
        along -= origin
        distance = np.sqrt(dot(along, along))
        reach = np.where(active, 1.0 - stop / np.maximum(distance, stop), NOT_TRACED)
        free = self._triangles.free(origin, along, reach)
        if len(self._radius):
            free = free & self._no_sphere(points, x_to - points.position, reach)
        return free

    def escapes(
        self,
        points: SurfacePoints | Viewpoints,
        direction: Vec3s,
        active: Masks,
        kind: str,
    ) -> Masks:
        """Whether rays from surface points leave the scene.

        Parameters
        ----------
        direction : (N, 3) float64; unit vectors
        active : (N,) bool; which rays are traced

        Returns
        -------
        (N,) bool; nothing lies in that direction
        """
        self._count(kind, active)
        along = direction * self._geometry.extent
        reach = np.where(active, ENDLESS, NOT_TRACED)
        origin = points.position
        if self._transmits:
            origin = self._outset(points, along)
        free = self._triangles.free(origin, along, reach)
        if len(self._radius):
            free = free & self._no_sphere(points, along, reach)
        return free

    def _outset(self, points: SurfacePoints | Viewpoints, direction: Vec3s) -> Vec3s:
        """Where rays of visibility start: from points with a normal, to either side."""
        if isinstance(points, Viewpoints):
            return points.position
        return leaving(self._geometry, points, direction)

    def _normalized(self, x: Vec3s) -> Vec3s:
        moved: Vec3s = (x - self._geometry.middle) / self._geometry.extent
        return moved

    def _no_sphere(
        self, points: SurfacePoints | Viewpoints, along: Vec3s, reach: Scalars
    ) -> Masks:
        o, d = self._normalized(points.position), along / self._geometry.extent
        own = points.primitive - self._geometry.triangles
        first, _ = first_sphere(o, d, self._center, self._radius, own)
        return ~(first < reach)

    def _with_spheres(
        self, hits: Hits, o: Vec3s, d: Vec3s, start: Indices, active: Masks
    ) -> Hits:
        g = self._geometry
        first, sphere = first_sphere(
            o, d, self._center, self._radius, start - g.triangles
        )
        closer = active & (first * g.extent < hits.distance)
        primitive = np.where(closer, g.triangles + sphere, hits.primitive)
        distance = np.where(closer, first * g.extent, hits.distance)
        return Hits(primitive.astype(np.int32), hits.u, hits.v, distance)

    def _count(self, kind: str, active: Masks) -> None:
        self._add(kind, int(np.count_nonzero(active)))

    def _count_behind_masks(self, rays: int) -> None:
        if rays:
            self._add("behind masks", rays)

    def _add(self, kind: str, rays: int) -> None:
        with self._lock:
            self.counts[kind] += rays
