"""Distances to triangles and crossings of them, in float64 and without a tree."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    cross,
    divide_or_zero,
    dot,
)


def distance_to_triangles(x: Vec3s, corners: Scalars) -> Scalars:
    """Distances from one point to triangles.

    Parameters
    ----------
    x : (3,) float64, m; the point
    corners : (T, 3, 3) float64, m; triangles with area

    Returns
    -------
    (T,) float64, m
        To the nearest point of each: above the inside the height over the plane, else
        the distance to the nearest edge.
    """
    nearest = np.full(len(corners), np.inf)
    above = np.ones(len(corners), bool)
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for i in range(3):
        a, b = corners[:, i], corners[:, (i + 1) % 3]
        edge, offset = b - a, x - a
        along = np.clip(divide_or_zero(dot(offset, edge), dot(edge, edge)), 0.0, 1.0)
        foot = offset - along[:, None] * edge
        nearest = np.minimum(nearest, np.sqrt(dot(foot, foot)))
        above &= dot(cross(edge, offset), normal) >= 0
    height = np.abs(dot(x - corners[:, 0], normal))
    height = divide_or_zero(height, np.sqrt(dot(normal, normal)))
    return np.where(above, height, nearest)


def crossings(start: Vec3s, along: Vec3s, corners: Scalars) -> Masks:
    """Which triangles the segment from ``start`` to ``start + along`` crosses.

    Parameters
    ----------
    start, along : (3,) float64, m; the segment; make it longer than the scene for a ray
    corners : (T, 3, 3) float64, m; triangles

    Returns
    -------
    (T,) bool
        By the signs of the volumes between the segment and the three edges; edges
        themselves may count either way.
    """
    a, b, c = (corners[:, i] - start for i in range(3))
    sides = [dot(cross(p, q), along) for p, q in ((a, b), (b, c), (c, a))]
    same = (sides[0] > 0) == (sides[1] > 0)
    through = same & ((sides[1] > 0) == (sides[2] > 0))
    normal = cross(b - a, c - a)
    before, beyond = dot(a, normal), dot(a - along, normal)
    crossed: Masks = through & ((before > 0) != (beyond > 0))
    return crossed


def inside(x: Vec3s, corners: Scalars) -> bool:
    """Whether a point is certainly inside a closed surface.

    Parameters
    ----------
    x : (3,) float64, m; the point
    corners : (T, 3, 3) float64, m
        Triangles in which each edge occurs an even number of times.

    Returns
    -------
    bool
        True where rays in five unrelated directions all cross the surface an odd
        number of times.
    """
    return all(crossings(x, ray, corners).sum() % 2 == 1 for ray in _rays(x, corners))


def outside(x: Vec3s, corners: Scalars) -> bool:
    """Whether a point is certainly outside a closed surface.

    Parameters
    ----------
    x : (3,) float64, m; the point
    corners : (T, 3, 3) float64, m
        Triangles in which each edge occurs an even number of times.

    Returns
    -------
    bool; True where the same rays all cross it an even number of times
    """
    return all(crossings(x, ray, corners).sum() % 2 == 0 for ray in _rays(x, corners))


def sees_out(x: Vec3s, corners: Scalars) -> bool:
    """Whether a point is certainly not enclosed by any of some triangles.

    Parameters
    ----------
    x : (3,) float64, m; the point
    corners : (T, 3, 3) float64, m; triangles, closed or not

    Returns
    -------
    bool; True where one of a few rays crosses none of them
    """
    if ((x < corners.min(axis=(0, 1))) | (x > corners.max(axis=(0, 1)))).any():
        return True
    return any(not crossings(x, ray, corners).any() for ray in _rays(x, corners))


def _rays(x: Vec3s, corners: Scalars) -> list[Vec3s]:
    # Directions without a simple ratio of components, so that no edge or corner of an
    # ordinary scene lies on them, each long enough to leave the surface.
    reach = 4.0 * float(np.abs(corners - x).max())
    directions = [(0.618, 0.531, 0.580), (-0.713, 0.377, 0.591), (0.291, -0.843, 0.452)]
    directions += [(0.437, 0.229, -0.870), (-0.503, -0.671, -0.545)]
    return [reach * np.array(direction) for direction in directions]
