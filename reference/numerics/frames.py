"""Frames about normals, and turning vectors into them."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, dot, vectors


def normal_frames(n: Vec3s) -> tuple[Vec3s, Vec3s]:
    """Two tangents that make a right-handed orthonormal frame with each unit normal.

    [Duff17, Listing 3]: continuous but for the sign flip at n_z = 0, no branch that
    loses precision at the pole.

    Parameters
    ----------
    n : (N, 3) float; unit vectors

    Returns
    -------
    (N, 3), (N, 3) float; tangent and bitangent
    """
    x, y, z = n[:, 0], n[:, 1], n[:, 2]
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = vectors(1.0 + sign * x * x * a, sign * b, -sign * x)
    bitangent = vectors(b, sign + y * y * a, -y)
    return tangent, bitangent


def to_world(local: Vec3s, n: Vec3s) -> Vec3s:
    """Directions given about the z axis, turned to stand about unit normals n.

    Parameters
    ----------
    local : (N, 3) float; components along tangent, bitangent and normal
    n : (N, 3) float; unit normals

    Returns
    -------
    (N, 3) float; same length as ``local``
    """
    tangent, bitangent = normal_frames(n)
    x, y, z = local[:, 0:1], local[:, 1:2], local[:, 2:3]
    turned: Vec3s = x * tangent + y * bitangent + z * n
    return turned


def turn(a: Vec3s, matrix: Scalars) -> Vec3s:
    """Product of one 3 x 3 matrix with each row.

    Parameters
    ----------
    a : (N, 3); any dtype
    matrix : (3, 3); applied from the left

    Returns
    -------
    (N, 3); by column sums: a matrix product may round differently in another band
    """
    return vectors(dot(a, matrix[0]), dot(a, matrix[1]), dot(a, matrix[2]))
