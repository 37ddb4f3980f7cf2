"""Rays and triangles: what is hit first, and whether a segment is free.

The only file that knows Embree, which works in float32.  The scene is handed to it
moved and scaled into the cube [-1, 1]³, so that its rounding is the same relative to
every scene, however small or far from the origin.
"""

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.hits import Hits

ENDLESS = 1e30
"""Reach of rays that end nowhere, as a multiple of their direction."""

NOT_TRACED = -1.0
"""Reach of rays that Embree passes over, which costs less than sorting them out."""

Singles = NDArray[np.float32]


class Triangles:
    """The triangles of a scene in Embree's hands.

    Parameters
    ----------
    rows : (K,) int, optional; those that are handed over; by default all
    """

    def __init__(self, geometry: Geometry, rows: Indices | None = None) -> None:
        self._middle, self._extent = geometry.middle, geometry.extent
        self._rows = rows
        triangles = geometry.triangle if rows is None else geometry.triangle[rows]
        self._embree: EmbreeScene | None = None
        if len(triangles):
            self._embree = _commit(geometry, triangles)

    def first_hits(self, origin: Vec3s, direction: Vec3s, reach: Scalars) -> Hits:
        """First triangle along rays.

        Parameters
        ----------
        origin : (N, 3) float64, m; where the rays start
        direction : (N, 3) float64; unit vectors
        reach : (N,) float64, half extents
            How far; ``NOT_TRACED`` for rays that are left out.

        Returns
        -------
        Hits; primitive -1 and distance inf where nothing is hit, or no ray was traced
        """
        size = len(origin)
        if self._embree is None or size == 0:
            none = np.zeros(size)
            return Hits(np.full(size, -1, np.int32), none, none, np.full(size, np.inf))
        answer = self._embree.run(
            self._moved(origin),
            _rows_of_singles(direction),
            query="INTERSECT",
            dists=reach.astype(np.float32),
            output=True,
        )
        distance = answer["tfar"].astype(np.float64) * self._extent
        distance[answer["primID"] < 0] = np.inf
        u, v = answer["u"].astype(np.float64), answer["v"].astype(np.float64)
        primitive = answer["primID"]
        if self._rows is not None:
            own = self._rows[np.maximum(primitive, 0)]
            primitive = np.where(primitive < 0, -1, own).astype(np.int32)
        return Hits(primitive, u, v, distance)

    def free(self, origin: Vec3s, along: Vec3s, reach: Scalars) -> Masks:
        """Whether no triangle crosses the segments from o to o + t d.

        Parameters
        ----------
        origin : (N, 3) float64, m; where the segments start
        along : (N, 3) float64, m; direction d, of any length
        reach : (N,) float64
            Where they end, t; ``NOT_TRACED`` for segments that are left out.

        Returns
        -------
        (N,) bool; False where nothing was traced
        """
        if self._embree is None or len(origin) == 0:
            return np.asarray(reach != NOT_TRACED)
        answer = self._embree.run(
            self._moved(origin),
            _rows_of_singles(along / self._extent),
            query="OCCLUDED",
            dists=reach.astype(np.float32),
        )
        # Embree reports what it passed over as occluded.
        free: Masks = answer != 0
        return free

    def _moved(self, x: Vec3s) -> Singles:
        return _rows_of_singles((x - self._middle) / self._extent)


def _rows_of_singles(vectors: Vec3s) -> Singles:
    # A column at a time: NumPy converts and reorders at once far more slowly.
    rows = np.empty(vectors.shape, np.float32)
    for column in range(3):
        rows[:, column] = vectors[:, column]
    return rows


def _commit(geometry: Geometry, triangles: Scalars) -> EmbreeScene:
    first, edge_u, edge_v = (triangles[:, i] for i in range(3))
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
