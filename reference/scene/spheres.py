"""Rays and spheres, in float64: exact, without a step off the surface."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, dot


def first_sphere(
    o: Vec3s, d: Vec3s, center: Vec3s, radius: Scalars, start: Indices
) -> tuple[Scalars, Indices]:
    """Which sphere rays meet first, and where.

    Parameters
    ----------
    o, d : (N, 3) float64; origins and directions
    center : (S, 3) float64; of the spheres, in the unit of ``o``
    radius : (S,) float64; of the spheres
    start : (N,) int; sphere that each ray leaves; negative for none

    Returns
    -------
    (N,) float64, (N,) int
        Multiples of ``d``, inf where a ray meets none; index of the sphere.
    """
    first, which = np.full(len(o), np.inf), np.zeros(len(o), np.int64)
    for index in range(len(radius)):
        near, far = _crossings(o, d, center[index], radius[index])
        # A ray that leaves this sphere crosses it at 0, rounded either way: no hit.
        leaves, at_near = start == index, np.abs(near) < np.abs(far)
        near = np.where(leaves & at_near, -np.inf, near)
        far = np.where(leaves & ~at_near, -np.inf, far)
        t = np.where(near > 0, near, np.where(far > 0, far, np.inf))
        which = np.where(t < first, index, which)
        first = np.minimum(first, t)
    return first, which


def _crossings(
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
