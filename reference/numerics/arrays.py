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
    """Vectors from their components, (N, 3); in Fortran order.

    Parameters
    ----------
    x, y, z : (N,); any dtype
    """
    return np.moveaxis(np.stack([x, y, z]), 0, -1)


def zero_vectors(rows: int) -> Vec3s:
    """Zero vectors, to be filled, (N, 3) float64; in Fortran order."""
    return np.zeros((rows, 3), order="F")


def dot(a: Vec3s, b: Vec3s) -> Scalars:
    """Inner product a·b of each row.

    Parameters
    ----------
    a, b : (N, 3); any dtype; one of them may be a single vector ``(3,)``

    Returns
    -------
    (N,)
        Column sums, added in the order x, y, z, so that splitting the rows into
        bands cannot change a bit.
    """
    product: Scalars = a[..., 0] * b[..., 0]
    product += a[..., 1] * b[..., 1]
    product += a[..., 2] * b[..., 2]
    return product


def cross(a: Vec3s, b: Vec3s) -> Vec3s:
    """Vector product a × b of each row, (N, 3); right-handed.

    Parameters
    ----------
    a, b : (N, 3); any dtype
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
    x : (N,); non-negative; any dtype

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
    """Euclidean length |a| of each row, (N,); 0 for the zero vector.

    Parameters
    ----------
    a : (N, 3); any dtype
    """
    return sqrt(dot(a, a))


def divide_or_zero(numerator: Scalars, denominator: Scalars) -> Scalars:
    """Quotient a / b, and 0 where b = 0: how a null row stays a null.

    Parameters
    ----------
    numerator, denominator : (N,) or (N, 3); any dtype, broadcast against each other

    Returns
    -------
    (N,) or (N, 3); exactly 0 where the denominator is 0, whatever the numerator
    """
    shape = np.broadcast_shapes(numerator.shape, denominator.shape)
    dtype = np.result_type(numerator, denominator)
    out: Scalars = np.zeros(shape, dtype, order="F")
    if out.dtype == object:
        # Among rationals 0 is a rational: the quotient 0 / 2 of integers is a float.
        out += numerator * 0
    np.divide(numerator, denominator, out=out, where=denominator != 0)
    return out


def saturate(x: Scalars) -> Scalars:
    """Finite values for a result that overflowed: at most the largest of its dtype.

    Parameters
    ----------
    x : (N,); non-negative, infinite or NaN

    Returns
    -------
    (N,)
        NaN, from infinity over infinity, becomes 0: a null.  Object rows are returned
        as they are.
    """
    # As a rule there is nothing to be done: one pass tells, NaN included.
    if x.dtype == object or np.isfinite(x.max(initial=0.0)):
        return x
    finite: Scalars = np.nan_to_num(x, nan=0.0)
    return finite


def plus(a: Scalars, b: Scalars) -> Scalars:
    """Sum of numbers that are not negative, at most the largest of the dtype.

    Parameters
    ----------
    a, b : (N,); finite, not negative; any dtype

    Returns
    -------
    (N,); a + b
    """
    with np.errstate(over="ignore"):
        return saturate(a + b)


def triangle_normal(u: Vec3s, v: Vec3s) -> Vec3s:
    """Unit normal of triangles, u × v / |u × v|.

    Parameters
    ----------
    u, v : (N, 3) float, m; edges from one corner

    Returns
    -------
    (N, 3) float; 0 where there is no area, or its square leaves the range of the dtype
    """
    with np.errstate(over="ignore", invalid="ignore"):
        n = normalize(cross(u, v))
    kept: Vec3s = np.where(np.isfinite(n), n, 0.0)
    return kept


def normalize(a: Vec3s) -> Vec3s:
    """Unit vector a / |a| of each row, (N, 3); the zero vector stays the zero vector.

    Parameters
    ----------
    a : (N, 3); any dtype
    """
    return divide_or_zero(a, length(a)[..., None])
