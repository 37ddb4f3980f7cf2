"""Fresnel reflectance against known values, Snell's law, and the complex formula."""

import mpmath
import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.scene.materials.fresnel import (
    fresnel_conductor,
    fresnel_dielectric,
    fresnel_schlick,
)
from restir_gi.reference.strategies import ROWS, colors, scalars

EPS = np.finfo(np.float64).eps

cosines = scalars(0, 1)
indices = st.one_of(scalars(1.01, 3), scalars(0.4, 0.99))


def dielectric(cos_i, eta):
    reflectance, cos_t = fresnel_dielectric(np.array([cos_i]), np.array([eta]))
    return reflectance[0], cos_t[0]


def test_glass_seen_straight_on_reflects_4_percent():
    """((1.5 - 1) / (1.5 + 1))² = 1/25, from either side."""
    assert_allclose(dielectric(1.0, 1.5)[0], 0.04, rtol=8 * EPS)
    assert_allclose(dielectric(1.0, 1 / 1.5)[0], 0.04, rtol=8 * EPS)


def test_at_brewsters_angle_one_polarization_is_gone():
    """For tan θ = η the light polarized in the plane enters; ((1-η²) / (1+η²))² / 2."""
    for eta in (1.33, 1.5, 2.4):
        reflectance, cos_t = dielectric(np.cos(np.arctan(eta)), eta)
        expected = 0.5 * ((1 - eta**2) / (1 + eta**2)) ** 2
        assert_allclose(reflectance, expected, rtol=64 * EPS)
        # Reflected and refracted ray are at right angles.
        assert_allclose(cos_t, np.sin(np.arctan(eta)), rtol=8 * EPS)


def test_at_grazing_angles_all_is_reflected():
    for eta in (0.5, 1.0, 1.5):
        assert dielectric(0.0, eta)[0] == 1


def test_beyond_the_critical_angle_all_is_reflected():
    critical = np.sqrt(1 - 1 / 1.5**2)
    below, above = critical * (1 - 1e-9), critical * (1 + 1e-9)
    assert dielectric(below, 1 / 1.5) == (1.0, 0.0)
    assert dielectric(above, 1 / 1.5)[0] < 1


@given(cosines)
def test_where_no_boundary_is_nothing_is_reflected(cos_i):
    """Equal indices, away from grazing; cos_t = cos_i to the rounding of 1 - sin²."""
    cos_i = np.maximum(cos_i, 1e-3)
    reflectance, cos_t = fresnel_dielectric(cos_i, np.ones(ROWS))
    off = 4 * EPS / cos_i**2
    assert (reflectance <= off**2).all()
    assert (abs(cos_t - cos_i) <= off * cos_i).all()


@given(cosines, indices)
def test_the_refracted_ray_obeys_snell(cos_i, eta):
    """In squares, sin²θ_i = η² sin²θ_t; under total reflection cos θ_t = 0."""
    reflectance, cos_t = fresnel_dielectric(cos_i, eta)
    sin2_i, sin2_t = 1 - cos_i**2, eta**2 * (1 - cos_t**2)
    total = cos_t == 0
    off = 8 * EPS * (1 + eta**2)
    assert (abs(sin2_i - sin2_t) <= off)[~total].all()
    assert (sin2_i >= eta**2 - off)[total].all()
    assert (reflectance[total] == 1).all()


@given(scalars(0.05, 1), indices)
def test_a_boundary_reflects_alike_from_both_sides(cos_i, eta):
    """F(cos_i, η) = F(cos_t, 1/η): Helmholtz.

    The cosines are roots of 1 - sin², known to (1 + η² + η⁻²) eps, so that their errors
    go as the inverse cosine; so does the slope of F at the critical angle.
    """
    reflectance, cos_t = fresnel_dielectric(cos_i, eta)
    passes = cos_t > 1e-3
    back, cos_back = fresnel_dielectric(cos_t[passes], 1 / eta[passes])
    size = (1 + eta**2 + 1 / eta**2)[passes]
    off = 16 * EPS * size / (cos_i[passes] * cos_t[passes] ** 2)
    assert (abs(back - reflectance[passes]) <= off).all()
    assert (abs(cos_back - cos_i[passes]) <= off).all()


@given(cosines, indices)
def test_reflectance_is_a_share(cos_i, eta):
    reflectance, cos_t = fresnel_dielectric(cos_i, eta)
    assert ((reflectance >= 0) & (reflectance <= 1)).all()
    assert ((cos_t >= 0) & (cos_t <= 1)).all()


# ---------------------------------------------------------------- metals


def test_there_is_no_noise_where_there_is_no_boundary():
    """Of equal media, along the boundary too: finite, and a share."""
    found = fresnel_conductor(np.zeros(2), np.ones((2, 3)), np.zeros((2, 3)))
    assert ((found >= 0) & (found <= 1)).all()


def complex_fresnel(cos_i, eta, k):
    """|r|² of both polarizations for a complex index, averaged, in 40 digits."""
    with mpmath.workdps(40):
        c, n = mpmath.mpf(float(cos_i)), mpmath.mpc(float(eta), float(k))
        inside = mpmath.sqrt(n * n - (1 - c * c))
        r_s = (c - inside) / (c + inside)
        r_p = (n * n * c - inside) / (n * n * c + inside)
        return float((abs(r_s) ** 2 + abs(r_p) ** 2) / 2)


@given(cosines, colors(0.1, 3.0), colors(0.0, 6.0))
def test_metals_follow_the_complex_formula(cos_i, eta, k):
    """Absolute error of a number below 1: the root of a² cancels by (|n|² + 1) / a².

    a >= eta k / sqrt(|n|² + 1), and below that its square is what rounding leaves.
    Along a boundary between equal media the formula is 0 / 0.
    """
    assume(((cos_i[:, None] > 0) | (eta != 1) | (k != 0)).all())
    found = fresnel_conductor(cos_i, eta, k)
    n2 = eta**2 + k**2 + 1
    for (row, channel), value in np.ndenumerate(found):
        exact = complex_fresnel(cos_i[row], eta[row, channel], k[row, channel])
        lost = np.sqrt(8 * EPS * n2[row, channel])
        a = eta[row, channel] * k[row, channel] / np.sqrt(n2[row, channel])
        off = 32 * EPS * n2[row, channel] / max(a, lost)
        assert abs(value - exact) <= off


@given(cosines, colors(0.1, 3.0), colors(0.0, 6.0))
def test_reflectance_of_a_metal_is_a_share(cos_i, eta, k):
    found = fresnel_conductor(cos_i, eta, k)
    assert (found >= 0).all()
    assert (found <= 1 + 8 * EPS).all()


def test_gold_seen_straight_on():
    """((η-1)² + k²) / ((η+1)² + k²)."""
    eta, k = np.array([[0.143, 0.374, 1.442]]), np.array([[3.983, 2.387, 1.603]])
    expected = ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)
    assert_allclose(fresnel_conductor(np.ones(1), eta, k), expected, rtol=16 * EPS)


@given(scalars(0.01, 1), st.floats(1.1, 3))
def test_a_metal_that_absorbs_nothing_is_glass(cos_i, eta):
    index = np.full((ROWS, 3), eta)
    metal = fresnel_conductor(cos_i, index, 0 * index)
    glass, _ = fresnel_dielectric(cos_i, np.full(ROWS, eta))
    # a² is a difference of numbers up to η² that is at least η² - 1 > 0.2.
    assert_allclose(metal, np.repeat(glass[:, None], 3, axis=1), atol=64 * EPS * eta**2)


def test_at_grazing_angles_metal_reflects_all():
    eta, k = np.full((1, 3), 0.2), np.full((1, 3), 3.0)
    assert_allclose(fresnel_conductor(np.zeros(1), eta, k), 1.0, rtol=8 * EPS)


def test_a_metal_of_no_index_is_a_number_too():
    """Rows of materials without Fresnel term share the arrays of those with one."""
    cos_i = np.array([0.0, 0.5, 1.0])
    for eta in (0.0, 1.0):
        index = np.full((3, 3), eta)
        found = fresnel_conductor(cos_i, index, 0 * index)
        assert ((found >= 0) & (found <= 1)).all()


# ---------------------------------------------------------------- Schlick


@given(cosines, colors())
def test_schlick_lies_between_its_ends(cos_i, f0):
    found = fresnel_schlick(cos_i, f0)
    assert (found >= f0 * (1 - EPS)).all()
    assert (found <= 1 + EPS).all()
    assert_array_equal(fresnel_schlick(np.ones(ROWS), f0), f0)
    assert_allclose(fresnel_schlick(np.zeros(ROWS), f0), 1.0, rtol=EPS)
