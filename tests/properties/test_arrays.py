"""Row-wise verbs: what vectors are known to do."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.arrays import (
    cross,
    divide_or_zero,
    dot,
    length,
    normalize,
    sqrt,
)
from restir_gi.reference.numerics.frames import normal_frames, to_world, turn
from restir_gi.reference.strategies import ROWS, points, scalars, unit_vectors

EPS = np.finfo(np.float64).eps


def rationals(shape):
    twelfths = arrays(np.int64, shape, elements=st.integers(-240, 240))
    return twelfths.map(lambda a: a * Fraction(1, 12))


vectors = rationals((ROWS, 3))


# ---------------------------------------------------------------- exact, in fractions


@given(vectors, vectors)
def test_dot_is_the_sum_of_products(a, b):
    expected = [
        sum(x * y for x, y in zip(p, q, strict=True)) for p, q in zip(a, b, strict=True)
    ]
    assert_array_equal(dot(a, b), expected)
    assert_array_equal(dot(a, b[0]), dot(a, np.broadcast_to(b[0], a.shape)))


@given(vectors, vectors, vectors)
def test_cross_is_the_determinant(a, b, c):
    """c·(a × b) is the determinant, and so vanishes for c = a and c = b."""
    volume = dot(c, cross(a, b))
    assert_array_equal(volume, dot(a, cross(b, c)))
    assert_array_equal(volume, -dot(c, cross(b, a)))
    assert_array_equal(dot(a, cross(a, b)), 0)


def test_cross_is_right_handed():
    x, y, z = np.eye(3)[:, None]
    assert_array_equal(cross(x, y), z)
    assert_array_equal(cross(y, z), x)
    assert_array_equal(cross(z, x), y)


@given(rationals(ROWS), rationals(ROWS))
def test_divide_or_zero(a, b):
    expected = [p / q if q else 0 for p, q in zip(a, b, strict=True)]
    found = divide_or_zero(a, b)
    assert_array_equal(found, expected)
    assert all(isinstance(x, Fraction) for x in found)


def test_a_quotient_of_nothing_stays_rational():
    """0 / 0 and then 0 / 2: as integers, that would be the float 0.0."""
    zero, two = np.array([Fraction(0)]), np.array([2], object)
    twice = divide_or_zero(divide_or_zero(zero, zero), two)
    assert isinstance(twice[0], Fraction)


@given(arrays(np.float64, ROWS, elements=st.floats(-1e300, 1e300)))
def test_nothing_divided_by_nothing_is_nothing(a):
    assert_array_equal(divide_or_zero(a, np.zeros(ROWS)), 0)
    assert_array_equal(divide_or_zero(a, np.zeros(1)), 0)


@given(rationals(ROWS))
def test_roots_of_squares_are_exact(numbers):
    squares = np.array([x * x for x in numbers], object)
    assert_array_equal(sqrt(squares), [abs(x) for x in numbers])


def test_an_irrational_root_is_refused():
    with pytest.raises(ValueError, match="irrational"):
        sqrt(np.array([Fraction(1), Fraction(2)]))
    with pytest.raises(ValueError, match="irrational"):
        sqrt(np.array([Fraction(4, 3)]))


def test_roots_of_other_objects_are_their_own():
    with mpmath.workdps(40):
        root = sqrt(np.array([mpmath.mpf(2)], object))[0]
        assert abs(root * root - 2) <= 4 * mpmath.eps


# ---------------------------------------------------------------- floats


@given(points(1e100))
def test_normalize_leaves_a_direction(a):
    """Unit length to 3 eps; the same direction; the zero vector as it is.

    Components below 1e-150 may lose their squares: those rows are at most normalized.
    """
    n = normalize(a)
    size = length(n)
    long = length(a) > 1e-150
    assert (abs(size[long] - 1) <= 3 * EPS).all()
    assert (abs(cross(n, a)[long]) <= 4 * EPS * length(a)[long, None]).all()
    assert (dot(n, a)[long] > 0).all()
    nothing = ~a.any(axis=1)
    assert_array_equal(n[nothing], 0)


@given(unit_vectors())
def test_frames_are_orthonormal_and_right_handed(n):
    """Nine products of numbers up to 1, a = -1 / (1 + |z|): 8 eps; normals: 3 eps."""
    t, b = normal_frames(n)
    for first, second in ((t, b), (t, n), (b, n)):
        assert (abs(dot(first, second)) <= 12 * EPS).all()
    for v in (t, b):
        assert (abs(dot(v, v) - 1) <= 12 * EPS).all()
    assert (abs(cross(t, b) - n) <= 12 * EPS).all()


@pytest.mark.parametrize("z", [1.0, -1.0])
@pytest.mark.parametrize("tilt", [0.0, 1e-300, 1e-20, 1e-8])
def test_frames_do_not_fail_at_the_poles(z, tilt):
    n = np.array([[tilt, -tilt, z], [-tilt, tilt, z], [0.0, tilt, z]])
    t, b = normal_frames(n)
    assert (abs(cross(t, b) - n) <= 12 * EPS + tilt**2).all()


def test_frames_at_either_zero():
    """The two signs of z = 0 make two frames of one normal; both are right."""
    n = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, -0.0]])
    t, b = normal_frames(n)
    assert_array_equal(cross(t, b), n)


@given(points(), unit_vectors())
def test_to_world_is_a_turn_that_takes_z_to_n(local, n):
    """To 16 eps of the length, or of 1e-150, below which squares lose their digits."""
    size = length(local)
    turned = to_world(local, n)
    off = 16 * EPS * np.maximum(size, 1e-150)
    assert (abs(length(turned) - size) <= off).all()
    assert (abs(dot(turned, n) - local[:, 2]) <= off).all()
    z = np.broadcast_to([0.0, 0.0, 1.0], n.shape)
    assert_array_equal(to_world(z, n), n)


@given(vectors, rationals((3, 3)))
def test_turn_is_a_matrix_product(a, matrix):
    assert_array_equal(turn(a, matrix), a @ matrix.T)


@given(scalars(0, 100))
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble])
def test_number_types_are_kept(dtype, x):
    x = x.astype(dtype)
    v = np.stack([x, x / 2, x / 4], axis=-1)
    for found in (
        dot(v, v / 64),
        cross(v, v),
        sqrt(x),
        length(v / 64),
        normalize(v / 64),
    ):
        assert found.dtype == dtype
    assert divide_or_zero(x, x + 1).dtype == dtype
