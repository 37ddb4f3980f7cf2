"""Closed surfaces: which parts of a mesh are closed, and what lies within."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    cross,
    dot,
)
from restir_gi.reference.scene.checks.space import (
    crossings,
    distance_to_triangles,
    inside,
    outside,
)


@dataclass(frozen=True, slots=True, eq=False)
class Shell:
    """A closed surface of triangles: each edge occurs an even number of times.

    Attributes
    ----------
    corners : (T, 3, 3) float64, m; in the world
    faces : (T,) int; faces of the mesh that it is a part of
    outward : bool; neighbouring faces agree on their front, and it is the outside
    """

    corners: Scalars
    faces: Indices
    outward: bool

    def holds(self, x: Vec3s) -> bool:
        """Whether a point is certainly inside.

        Parameters
        ----------
        x : (3,) float64, m; the point

        Returns
        -------
        bool; False also where rounding leaves it open
        """
        return self._is_near(x[None])[0] and inside(x, self.corners)

    def excludes_point(self, x: Vec3s) -> bool:
        """Whether a point is certainly outside.

        Parameters
        ----------
        x : (3,) float64, m; the point

        Returns
        -------
        bool; False also where rounding leaves it open
        """
        return not self._is_near(x[None])[0] or outside(x, self.corners)

    def excludes_triangles(self, corners: Scalars) -> bool:
        """Whether no part of some triangles is inside.

        Parameters
        ----------
        corners : (K, 3, 3) float64, m; triangles

        Returns
        -------
        bool; False also where rounding leaves it open
        """
        some = corners[self._is_near(corners.min(axis=1), corners.max(axis=1))]
        if not all(self.excludes_point(x) for x in some.reshape(-1, 3)):
            return False
        # All corners are outside: what reaches inside must cross the surface.
        pairs = ((some, self.corners), (self.corners, some))
        return not any(
            crossings(a, b - a, others).any()
            for triangles, others in pairs
            if len(others)
            for triangle in triangles
            for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)
        )

    def excludes_sphere(self, center: Vec3s, radius: float) -> bool:
        """Whether no part of the surface of a sphere is inside.

        Parameters
        ----------
        center : (3,) float64, m; of the sphere
        radius : float, m

        Returns
        -------
        bool; False also where rounding leaves it open
        """
        offset = self.corners.reshape(-1, 3) - center
        if (dot(offset, offset) < radius**2).all():
            return True  # the shell is within the ball, away from its surface
        apart = distance_to_triangles(center, self.corners).min() >= radius
        return bool(apart) and self.excludes_point(center)

    def _is_near(self, low: Vec3s, high: Vec3s | None = None) -> Masks:
        high = low if high is None else high
        mine = self.corners.min(axis=(0, 1)), self.corners.max(axis=(0, 1))
        overlap: Masks = ((low <= mine[1]) & (high >= mine[0])).all(axis=1)
        return overlap


def closed_shells(faces: Indices, vertices: Vec3s, corners: Scalars) -> Iterator[Shell]:
    """Connected parts of a mesh that are closed.

    Parameters
    ----------
    faces : (F, 3) int; of the mesh
    vertices : (V, 3) float64; in its own frame, where equal corners have equal bits
    corners : (F, 3, 3) float64, m; its triangles in the world
    """
    # Vertices at one place are one vertex (+ 0.0 turns -0 into 0).
    _, same = np.unique(vertices + 0.0, axis=0, return_inverse=True)
    welded = same.reshape(-1)[faces]
    edges = np.stack([welded, np.roll(welded, -1, axis=1)], axis=-1)
    start, end = edges.reshape(-1, 2).T
    size = len(vertices)
    graph = coo_array((np.ones(len(start), bool), (start, end)), shape=(size, size))
    part_of_vertex = connected_components(graph, directed=False)[1]
    part = part_of_vertex[welded[:, 0]]
    for number in np.unique(part):
        own = np.flatnonzero(part == number)
        undirected = np.sort(edges[own].reshape(-1, 2), axis=1)
        _, times = np.unique(undirected, axis=0, return_counts=True)
        if (times % 2 == 0).all():
            outward = _fronts_outward(edges[own].reshape(-1, 2), corners[own])
            yield Shell(corners[own], own, outward)


def _fronts_outward(edges: Indices, corners: Scalars) -> bool:
    # Fronts agree where each edge is walked as often one way as the other.
    ways = np.sort(edges[:, 0] * (edges.max() + 1) + edges[:, 1])
    back = np.sort(edges[:, 1] * (edges.max() + 1) + edges[:, 0])
    a, b, c = (corners[:, i] - corners[0, 0] for i in range(3))
    return bool(np.array_equal(ways, back) and dot(a, cross(b, c)).sum() > 0)
