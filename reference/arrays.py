"""Row-wise verbs: the only functions that know which axis holds the components.

A frame is N rows.  Scalars are ``(N,)``, vectors ``(N, 3)``.  Everything here runs on
any dtype: float16 to longdouble, and object arrays of ``fractions.Fraction`` or
``mpmath.mpf``.

Vectors are made with their components apart in memory (Fortran order): NumPy then runs
along the rows, three times faster than along rows of three.  Nothing depends on it.
"""

from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

Scalars = NDArray[Any]
Vec3s = NDArray[Any]
Masks = NDArray[np.bool_]
Indices = NDArray[np.integer[Any]]


def vectors(x: Scalars, y: Scalars, z: Scalars) -> Vec3s:
    """Vectors from their components.

    Parameters
    ----------
    x, y, z : (N,)
        Any dtype.

    Returns
    -------
    (N, 3)
        In Fortran order.
    """
    return np.moveaxis(np.stack([x, y, z]), 0, -1)


def zero_vectors(rows: int) -> Vec3s:
    """Zero vectors, to be filled.

    Parameters
    ----------
    rows : int
        How many.

    Returns
    -------
    (N, 3) float64
        In Fortran order.
    """
    return np.zeros((rows, 3), order="F")


def dot(a: Vec3s, b: Vec3s) -> Scalars:
    """Inner product a·b of each row.

    Parameters
    ----------
    a, b : (N, 3)
        Any dtype; one of them may be a single vector ``(3,)``.

    Returns
    -------
    (N,)
        Column sums, added in the order x, y, z, so that splitting the rows into
        bands cannot change a bit.
    """
    product: Scalars = (
        a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    )
    return product


def cross(a: Vec3s, b: Vec3s) -> Vec3s:
    """Vector product a × b of each row.

    Parameters
    ----------
    a, b : (N, 3)
        Any dtype.

    Returns
    -------
    (N, 3)
        Right-handed.
    """
    return vectors(
        a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
        a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
        a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0],
    )


def sqrt(x: Scalars) -> Scalars:
    """Square root √x of each row, exact for the squares of rationals.

    Parameters
    ----------
    x : (N,)
        Non-negative; any dtype.

    Returns
    -------
    (N,)
        For object rows: ``Fraction`` where the row is one (it must then be the square
        of a rational), else the row's own ``sqrt()`` method.

    Raises
    ------
    ValueError
        A ``Fraction`` whose root is irrational.
    """
    if x.dtype != object:
        root: Scalars = np.sqrt(x)
        return root
    return np.array([_sqrt_of_object(value) for value in x], dtype=object)


def _sqrt_of_object(x: Any) -> Any:
    if not isinstance(x, int | Fraction):
        return x.sqrt()
    numerator, denominator = isqrt(x.numerator), isqrt(x.denominator)
    if numerator**2 != x.numerator or denominator**2 != x.denominator:
        raise ValueError(f"sqrt({x}) is irrational; choose Pythagorean distances")
    return Fraction(numerator, denominator)


def length(a: Vec3s) -> Scalars:
    """Euclidean length |a| of each row.

    Parameters
    ----------
    a : (N, 3)
        Any dtype.

    Returns
    -------
    (N,)
        0 for the zero vector.
    """
    return sqrt(dot(a, a))


def divide_or_zero(numerator: Scalars, denominator: Scalars) -> Scalars:
    """Quotient a / b, and 0 where b = 0: how a null row stays a null.

    Parameters
    ----------
    numerator, denominator : (N,) or (N, 3)
        Any dtype, broadcast against each other.

    Returns
    -------
    (N,) or (N, 3)
        Exactly 0 where the denominator is 0, whatever the numerator.
    """
    shape = np.broadcast_shapes(numerator.shape, denominator.shape)
    dtype = np.result_type(numerator, denominator)
    out: Scalars = np.zeros(shape, dtype, order="F")
    if out.dtype == object:
        # Among rationals 0 is a rational: the quotient 0 / 2 of integers is a float.
        out += numerator * 0
    np.divide(numerator, denominator, out=out, where=denominator != 0)
    return out


def normalize(a: Vec3s) -> Vec3s:
    """Unit vector a / |a| of each row.

    Parameters
    ----------
    a : (N, 3)
        Any dtype.

    Returns
    -------
    (N, 3)
        The zero vector stays the zero vector.
    """
    return divide_or_zero(a, length(a)[..., None])


def normal_frames(n: Vec3s) -> tuple[Vec3s, Vec3s]:
    """Two tangents that make a right-handed orthonormal frame with each unit normal.

    Parameters
    ----------
    n : (N, 3) float
        Unit vectors.

    Returns
    -------
    (N, 3), (N, 3) float
        Tangent and bitangent.

    Notes
    -----
    [Duff17, Listing 3]: continuous but for the sign flip at n_z = 0, no branch that
    loses precision at the pole.
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
    local : (N, 3) float
        Components along tangent, bitangent and normal.
    n : (N, 3) float
        Unit normals.

    Returns
    -------
    (N, 3) float
        Same length as ``local``.
    """
    tangent, bitangent = normal_frames(n)
    x, y, z = local[:, 0:1], local[:, 1:2], local[:, 2:3]
    turned: Vec3s = x * tangent + y * bitangent + z * n
    return turned


def turn(a: Vec3s, matrix: Scalars) -> Vec3s:
    """Product of one 3 x 3 matrix with each row.

    Parameters
    ----------
    a : (N, 3)
        Any dtype.
    matrix : (3, 3)
        Applied from the left.

    Returns
    -------
    (N, 3)
        By column sums: a matrix product may round differently in another band.
    """
    return vectors(dot(a, matrix[0]), dot(a, matrix[1]), dot(a, matrix[2]))
