"""The reconnection Jacobian against what it claims to be: a ratio of solid angles.

Reciprocity and the chain rule hold for J, for 1/J and for the form with distances that
are not squared.  Only measured solid angles tell them apart; the controls show both.
"""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.numerics.arrays import divide_or_zero, dot, length
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.strategies import views_of_a_patch

EPS = np.finfo(np.float64).eps


def rounding(views, *eyes, eps=EPS):
    """Bound on the relative error of J on its own rounded inputs, as a row each.

    With u = eps/2 and first-order bounds: v = x - x_s carries 1u a component.  |v|² is
    2u + 3u, their ratio 11u, its root 6u, its cube 18u + 2u.  n·v carries 4u in units
    of Σ|n_i v_i|, that is 4κu with κ = Σ|n_i v_i| / |n·v|; the quotient and the last
    product 2u.  Together (22 + 4 Σκ) u; eps in place of u is the margin.
    """
    total = 22.0
    for eye in eyes:
        v = eye - views.position
        total = total + 4 * dot(abs(views.normal), abs(v)) / abs(dot(views.normal, v))
    return total * eps


def jacobian(views, i_from, i_to):
    eyes = views.eyes
    return reconnection_jacobian(eyes[i_from], eyes[i_to], views.position, views.normal)


# ---------------------------------------------------------------- wrong forms


def inverted(x_from, x_to, x_sample, n_sample):
    return 1.0 / reconnection_jacobian(x_from, x_to, x_sample, n_sample)


def unsquared(x_from, x_to, x_sample, n_sample):
    J = reconnection_jacobian(x_from, x_to, x_sample, n_sample)
    return J * length(x_to - x_sample) / length(x_from - x_sample)


def without_cosines(x_from, x_to, x_sample, n_sample):
    return (length(x_from - x_sample) / length(x_to - x_sample)) ** 2


def clamped(x_from, x_to, x_sample, n_sample):
    J = reconnection_jacobian(x_from, x_to, x_sample, n_sample)
    return np.clip(J, 1 / 3, 3)


WRONG = [inverted, unsquared, without_cosines]


# ---------------------------------------------------------------- identities


@given(views_of_a_patch())
def test_there_and_back_is_1(views):
    back_and_forth = jacobian(views, 0, 1) * jacobian(views, 1, 0)
    tolerance = 2 * rounding(views, *views.eyes[:2]) + EPS
    assert (abs(back_and_forth - 1) <= tolerance).all()


@given(views_of_a_patch())
def test_by_way_of_a_third_point(views):
    direct = jacobian(views, 0, 2)
    by_way = jacobian(views, 0, 1) * jacobian(views, 1, 2)
    tolerance = 3 * rounding(views, *views.eyes) + EPS
    assert (abs(by_way - direct) <= tolerance * direct).all()


@given(views_of_a_patch(eyes=1))
def test_of_equal_points_is_1_exactly(views):
    eye = views.eyes[0]
    J = reconnection_jacobian(eye, eye.copy(), views.position, views.normal)
    assert_array_equal(J, 1.0)


@given(views_of_a_patch(eyes=2), st.integers(-12, 12))
def test_the_unit_of_length_does_not_matter(views, exponent):
    """A power of two changes no digit, so not even the last bit may move."""
    unit = 2.0**exponent
    x_from, x_to = (eye * unit for eye in views.eyes)
    scaled = reconnection_jacobian(x_from, x_to, views.position * unit, views.normal)
    assert_array_equal(scaled, jacobian(views, 0, 1))


@given(views_of_a_patch(eyes=2), st.integers(-12, 12))
def test_the_length_and_side_of_the_normal_do_not_matter(views, exponent):
    x_from, x_to = views.eyes
    for factor in (2.0**exponent, -1.0):
        turned = reconnection_jacobian(
            x_from, x_to, views.position, views.normal * factor
        )
        assert_array_equal(turned, jacobian(views, 0, 1))


@given(views_of_a_patch())
@pytest.mark.parametrize("wrong", [inverted, unsquared])
def test_control_identities_cannot_tell(wrong, views):
    """The reason for the measurements below: wrong forms obey the same algebra."""
    (a, b, c), where = views.eyes, (views.position, views.normal)
    chain = wrong(a, b, *where) * wrong(b, c, *where)
    # Three to six more roundings than the right form.
    tolerance = 3 * rounding(views, a, b, c) + 8 * EPS
    assert (abs(chain - wrong(a, c, *where)) <= tolerance * chain).all()


def test_control_the_chain_rule_finds_a_clamp():
    """Where each step is within the limits and both together are not."""
    patch = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    near, middle, far = (np.array([[0.0, 0.0, d]]) for d in (1.0, 1.5, 2.0))
    chain = clamped(near, middle, *patch) * clamped(middle, far, *patch)
    assert abs(chain / clamped(near, far, *patch) - 1) > 0.2


# ---------------------------------------------------------------- measured angles


def exactly(a):
    """Digits of a number of any type, or of each number of a vector, as mpmath's own.

    Two floats hold a longdouble.  To be called where enough digits are set.
    """
    if np.ndim(a):
        return [exactly(x) for x in a]
    return mpmath.mpf(float(a)) + mpmath.mpf(float(a - type(a)(float(a))))


def inner(p, q):
    """Inner product of two vectors of mpmath's numbers."""
    return mpmath.fsum(x * y for x, y in zip(p, q, strict=True))


def outer(p, q):
    """Vector product of two vectors of mpmath's numbers."""
    return [p[i - 2] * q[i - 1] - p[i - 1] * q[i - 2] for i in range(3)]


def minus(p, q):
    """Difference of two vectors of mpmath's numbers."""
    return [x - y for x, y in zip(p, q, strict=True)]


def solid_angle_of_triangle(eye, corners):
    """Solid angle of a triangle by its spherical excess.

    tan(Ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|), corners as seen
    from the eye.
    """
    a, b, c = (minus(corner, eye) for corner in corners)
    A, B, C = (mpmath.sqrt(inner(v, v)) for v in (a, b, c))
    denominator = A * B * C + inner(a, b) * C + inner(b, c) * A + inner(c, a) * B
    return 2 * mpmath.atan2(abs(inner(a, outer(b, c))), denominator)


def measured_ratio(x_from, x_to, position, normal, size=1e-14):
    """Ratio of the solid angles of a tiny triangle about the sample point.

    The triangle's centroid is the sample point, so that the error is of second order:
    (size / distance / cosine)² < 1e-20, below the rounding of float64.
    """
    with mpmath.workdps(60):
        eyes, x, n = exactly([x_to, x_from]), exactly(position), exactly(normal)
        least = min(range(3), key=lambda i: abs(n[i]))
        t = outer(n, [mpmath.mpf(i == least) for i in range(3)])
        s = outer(n, t)
        corners = [
            [x[i] + size * (p * t[i] + q * s[i]) for i in range(3)]
            for p, q in ((1, 0), (-1, 1), (0, -1))
        ]
        to, back = (solid_angle_of_triangle(eye, corners) for eye in eyes)
        return to / back


def measured(views, i_from, i_to):
    rows = zip(
        views.eyes[i_from], views.eyes[i_to], views.position, views.normal, strict=True
    )
    return np.array([float(measured_ratio(*row)) for row in rows])


@given(views_of_a_patch(eyes=2, rows=2))
def test_is_the_measured_ratio_of_solid_angles(views):
    """In float64 rounding of the kernel alone: the measurement has 60 digits."""
    ratio = measured(views, 0, 1)
    tolerance = rounding(views, *views.eyes) + EPS
    assert (abs(jacobian(views, 0, 1) - ratio) <= tolerance * ratio).all()


@pytest.mark.parametrize("wrong", [*WRONG, clamped])
def test_control_the_measurement_finds_wrong_forms(wrong):
    """In one geometry where distances and cosines differ: J = 0.8 · 9 = 7.2."""
    x_from, x_to = np.array([[0.0, 0.0, 3.0]]), np.array([[0.6, 0.0, 0.8]])
    patch = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    ratio = float(measured_ratio(x_from[0], x_to[0], patch[0][0], patch[1][0]))
    assert_allclose(reconnection_jacobian(x_from, x_to, *patch), ratio, rtol=30 * EPS)
    assert abs(wrong(x_from, x_to, *patch)[0] / ratio - 1) > 0.2


# ---------------------------------------------------------------- integrals


def rectangle_solid_angle(a, b, height):
    """Solid angle of [0, a] x [0, b] from a point at its corner, `height` above it."""
    return np.arctan(a * b / (height * np.sqrt(a * a + b * b + height * height)))


def rectangle_from(eye):
    """Solid angle of [-1, 1] x [-1, 1] in the plane z = 0: four corners, with signs."""
    x, y, z = eye
    return sum(
        np.sign(cx * cy) * rectangle_solid_angle(abs(cx), abs(cy), z)
        for cx in (1 - x, 1 + x)
        for cy in (1 - y, 1 + y)
    )


def integral_over_patch(jacobian, eye_from, eye_to, order=60):
    """∫ J dω_from over the square [-1, 1]², by a product of Gauss rules."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    x, y = (grid.ravel() for grid in np.meshgrid(nodes, nodes))
    area = np.outer(weights, weights).ravel()
    patch = np.column_stack([x, y, 0 * x])
    normal = np.broadcast_to([0.0, 0.0, 1.0], patch.shape)
    x_from, x_to = (np.broadcast_to(eye, patch.shape) for eye in (eye_from, eye_to))
    v = x_from - patch
    omega = divide_or_zero(v[:, 2], length(v) ** 3) * area
    return np.sum(jacobian(x_from, x_to, patch, normal) * omega)


FROM, TO = np.array([0.3, -0.4, 1.7]), np.array([-0.5, 0.2, 0.6])


def test_integrates_one_solid_angle_into_the_other():
    """Ω_to = ∫ J dω_from.

    The nearest singularity is 0.6 from the square of half width 1, so that a Gauss rule
    of 60 nodes has converged far below rounding; 3600 terms of 40 eps are summed
    pairwise.
    """
    for x_from, x_to in ((FROM, TO), (TO, FROM)):
        total = integral_over_patch(reconnection_jacobian, x_from, x_to)
        assert_allclose(total, rectangle_from(x_to), rtol=80 * EPS)


@pytest.mark.parametrize("wrong", WRONG)
def test_control_the_integral_finds_wrong_forms(wrong):
    total = integral_over_patch(wrong, FROM, TO)
    assert abs(total / rectangle_from(TO) - 1) > 0.2


# ---------------------------------------------------------------- number types


def literal(x_from, x_to, x, n):
    """|cos φ_to| / |cos φ_from| · d_from² / d_to² as it stands in the paper, and Σκ."""
    results, condition = [], 0
    for eye in (x_to, x_from):
        v = minus(eye, x)
        d = mpmath.sqrt(inner(v, v))
        cosine = abs(inner(v, n)) / d
        results.append(cosine / d**2)
        condition += inner([abs(c) for c in v], [abs(c) for c in n]) / (cosine * d)
    return results[0] / results[1], condition


@given(views_of_a_patch(eyes=2, near=0.125, far=8.0, least=0.125, rows=3))
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble])
def test_rounding_is_that_of_the_number_type(dtype, views):
    """Judged on the same rounded inputs, with the condition Σκ of the cosines.

    Float16 has 11 bits: at κ = 8 a bound of 60 %, which still is the kernel's rounding
    and nothing else.
    """
    places = *views.eyes, views.position, views.normal
    inputs = [a.astype(dtype) for a in places]
    J = reconnection_jacobian(*inputs)
    assert J.dtype == dtype
    with mpmath.workdps(60):
        for row, found in enumerate(exactly(J)):
            exact, condition = literal(*(exactly(a[row]) for a in inputs))
            tolerance = (22 + 4 * condition) * exactly(np.finfo(dtype).eps)
            assert abs(found - exact) <= tolerance * exact


@given(views_of_a_patch(eyes=2, rows=2))
def test_runs_on_numbers_of_mpmath(views):
    """Object arrays keep their type and all their digits."""
    with mpmath.workdps(50):
        places = *views.eyes, views.position, views.normal
        inputs = [np.array([exactly(row) for row in a], object) for a in places]
        for row, found in enumerate(reconnection_jacobian(*inputs)):
            exact, condition = literal(*(a[row] for a in inputs))
            assert isinstance(found, mpmath.mpf)
            assert abs(found - exact) <= (22 + 4 * condition) * mpmath.eps * exact
