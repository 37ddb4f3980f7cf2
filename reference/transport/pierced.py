"""Rays and triangles with holes: alpha masks.

Embree keeps the triangles that have a mask apart from all others.  A ray meets the
others once; among the masked ones it goes on behind each hole.
"""

from collections.abc import Callable

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    length,
)
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.hits import Hits
from restir_gi.reference.scene.masks import is_solid
from restir_gi.reference.scene.origins import STEP
from restir_gi.reference.transport.rays import NOT_TRACED, Triangles


class PiercedTriangles:
    """Triangles of a scene, some of which have holes.

    A ray goes on a ``STEP`` behind a hole.  So masked surfaces that are closer together
    than that count as one, and the search ends: each turn takes every ray further by a
    ``STEP``, which float32 resolves, and no triangle reaches beyond the scene.  Other
    surfaces are never stepped over, wherever they touch a masked one.

    Parameters
    ----------
    count : callable; told how many rays go on behind a hole, each time
    """

    def __init__(self, geometry: Geometry, count: Callable[[int], None]) -> None:
        assert geometry.mask is not None
        self._geometry, self._count = geometry, count
        self._whole = Triangles(geometry, np.flatnonzero(geometry.mask < 0))
        self._masked = Triangles(geometry, np.flatnonzero(geometry.mask >= 0))

    def first_hits(self, origin: Vec3s, direction: Vec3s, reach: Scalars) -> Hits:
        """First triangle along rays, never in a hole; see `Triangles.first_hits`.

        Parameters
        ----------
        origin : (N, 3) float64, m; where the rays start
        direction : (N, 3) float64; unit vectors
        reach : (N,) float64, half extents
            How far; ``NOT_TRACED`` for rays that are left out.
        """
        whole = self._whole.first_hits(origin, direction, reach)
        until = np.minimum(reach, whole.distance / self._geometry.extent)
        masked = self._first_solid(origin, direction, until)
        closer = masked.distance < whole.distance
        return Hits(
            *(
                np.where(closer, getattr(masked, name), getattr(whole, name))
                for name in ("primitive", "u", "v", "distance")
            )
        )

    def free(self, origin: Vec3s, along: Vec3s, reach: Scalars) -> Masks:
        """Whether no triangle crosses segments; see `Triangles.free`.

        Parameters
        ----------
        origin : (N, 3) float64, m; where the segments start
        along : (N, 3) float64, m; direction d, of any length
        reach : (N,) float64
            Where they end, t; ``NOT_TRACED`` for segments that are left out.

        Returns
        -------
        (N,) bool; True through holes
        """
        free = self._whole.free(origin, along, reach)
        size = length(along)
        direction = divide_or_zero(along, size[:, None])
        far = np.where(free, reach * (size / self._geometry.extent), NOT_TRACED)
        return free & (self._first_solid(origin, direction, far).primitive < 0)

    def _first_solid(self, origin: Vec3s, direction: Vec3s, reach: Scalars) -> Hits:
        """First masked triangle along rays that is solid where they meet it."""
        size, extent = len(origin), self._geometry.extent
        primitive, distance = np.full(size, -1, np.int32), np.full(size, np.inf)
        u, v = np.zeros(size), np.zeros(size)
        rows = np.flatnonzero(reach > 0)
        passed = np.zeros(len(rows))
        while len(rows):
            start = origin[rows] + passed[:, None] * direction[rows]
            left = reach[rows] - passed / extent
            left = np.where(left > 0, left, NOT_TRACED)
            met = self._masked.first_hits(start, direction[rows], left)
            solid = is_solid(self._geometry, met.primitive, met.u, met.v)
            here = np.flatnonzero(solid & (met.primitive >= 0))
            at = rows[here]
            primitive[at], u[at], v[at] = met.primitive[here], met.u[here], met.v[here]
            distance[at] = passed[here] + met.distance[here]
            behind = np.flatnonzero(~solid)
            rows = rows[behind]
            passed = passed[behind] + met.distance[behind] + STEP * extent
            self._count(len(rows))
        return Hits(primitive, u, v, distance)
