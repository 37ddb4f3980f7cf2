"""Microfacets: densities integrate to what they should, samplers follow them.

Determinants are taken by complex steps: the samplers run on complex numbers, and the
imaginary part is the derivative, with no difference that could cancel.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.special import erf

from restir_gi.reference.numerics.arrays import cross, dot, length
from restir_gi.reference.numerics.sampling import left_of
from restir_gi.reference.scene.materials.microfacet import (
    beckmann_density,
    beckmann_g1,
    facing_share,
    ggx_density,
    reflect,
    sample_facing_normal,
    sample_visible_normal,
    smith_g1,
)
from restir_gi.reference.strategies import scalars, uniforms, unit_vectors

EPS = np.finfo(np.float64).eps

WIDTHS = [0.05, 0.2, 0.5, 1.0]


def one(function, x, alpha):
    """Value of a function of rows at one number."""
    return float(function(np.array([float(x)]), np.array([alpha]))[0])


@pytest.mark.parametrize("alpha", WIDTHS)
def test_the_projected_density_integrates_to_1(alpha):
    """∫ D cos θ dω = π ∫ D d(sin²θ), by quad and within its own error."""
    total, error = quad(
        lambda s: np.pi * one(ggx_density, np.sqrt(1 - s), alpha),
        0, 1, points=[alpha**2, 10 * alpha**2][: 1 + (alpha < 0.3)], limit=200,
    )  # fmt: skip
    assert error < 2e-8
    assert abs(total - 1) < 2e-8


def seen_area(cos_o, cos_h):
    """∫ max(0, wo·h) dφ over the azimuth of h, in closed form."""
    a = cos_o * cos_h
    b = np.sqrt((1 - cos_o**2) * (1 - cos_h**2))
    if a >= b:
        return 2 * np.pi * a
    phi = np.arccos(-a / b)
    return 2 * (a * phi + b * np.sin(phi))


@pytest.mark.parametrize("alpha", WIDTHS)
@pytest.mark.parametrize("cos_o", [0.05, 0.3, 0.7, 1.0])
def test_visible_microfacets_have_the_projected_area_of_the_surface(alpha, cos_o):
    """∫ G1(wo) max(0, wo·h) D(h) dh = cos θ_o, whatever the roughness.

    In s = tan²θ / (tan²θ + alpha²), in which D cos θ dω is even.
    """

    def integrand(s):
        tan2 = alpha**2 * s / (1 - s)
        cos_h = 1 / np.sqrt(1 + tan2)
        # d(cos θ) / ds, from cos θ = (1 + tan²)^(-1/2).
        slope = 0.5 * cos_h**3 * alpha**2 / (1 - s) ** 2
        return one(ggx_density, cos_h, alpha) * seen_area(cos_o, cos_h) * slope

    total, error = quad(integrand, 0, 1, epsabs=1e-9, limit=400)
    assert error < 1e-7
    assert abs(one(smith_g1, cos_o, alpha) * total / cos_o - 1) < 2e-7 / cos_o


@given(scalars(0, 1), scalars(0.001, 1))
def test_g1_is_a_share_that_grows_with_the_cosine(cos, alpha):
    g = smith_g1(cos, alpha)
    assert ((g >= 0) & (g <= 1)).all()
    higher = np.minimum(cos + 0.01, 1.0)
    assert (smith_g1(higher, alpha) >= g).all()


def test_g1_at_the_ends():
    alpha = np.full(3, 0.5)
    assert_array_equal(smith_g1(np.array([1.0, 0.0, -0.5]), alpha), [1.0, 0.0, 0.0])


def test_normals_below_the_surface_do_not_exist():
    assert_array_equal(ggx_density(np.array([-0.5, 0.0]), np.full(2, 0.5)), 0.0)


# ---------------------------------------------------------------- visible normals


@st.composite
def views(draw, least=0.05):
    """Unit vectors above z = 0, with widths and uniforms away from the ends."""
    cosine, phi = draw(scalars(least, 1.0)), 2 * np.pi * draw(uniforms())
    sine = np.sqrt(1 - cosine**2)
    wo = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    u1, u2 = (0.02 + 0.96 * draw(uniforms()) for _ in range(2))
    return wo, draw(scalars(0.05, 1)), u1, u2


def visible_density(wo, h, alpha):
    """Density G1(wo) max(0, wo·h) D(h) / cos θ_o, as the docstring states it."""
    seen = np.maximum(dot(wo, h), 0.0) * ggx_density(h[:, 2], alpha)
    return smith_g1(wo[:, 2], alpha) * seen / wo[:, 2]


@given(views())
def test_visible_normals_are_unit_vectors_above_the_surface(view):
    h = sample_visible_normal(*view)
    assert (abs(dot(h, h) - 1) <= 4 * EPS).all()
    assert (h[:, 2] >= 0).all()
    # Visible from wo, to the rounding of a projection onto a disk.
    assert (dot(view[0], h) >= -8 * EPS).all()


def image_area(sample, u1, u2, step=1e-100):
    """|∂ω/∂u1 × ∂ω/∂u2| of a sampler of directions."""
    du1 = sample(u1 + 1j * step, u2 + 0j).imag / step
    du2 = sample(u1 + 0j, u2 + 1j * step).imag / step
    return length(cross(du1, du2))


@given(views())
def test_visible_normals_have_their_density(view):
    """Density times determinant is 1, at each point.

    Rounding: the lifted point has p3 = sqrt(1 - p1² - p2²), and its slope 1 / p3;
    u1 <= 0.98 keeps it above 0.1.  Where it peaks, D loses 1 / alpha², 400 at 0.05.
    With 1 / p3² and some 20 roundings: 1e6 eps.
    """
    wo, alpha, u1, u2 = view
    h = sample_visible_normal(wo, alpha, u1, u2)
    area = image_area(lambda a, b: sample_visible_normal(wo, alpha, a, b), u1, u2)
    product = visible_density(wo, h, alpha) * area
    assert_allclose(product, 1.0, rtol=1e6 * EPS)


@given(views())
def test_control_another_width_is_another_density(view):
    wo, alpha, u1, u2 = view
    h = sample_visible_normal(wo, alpha, u1, u2)
    area = image_area(lambda a, b: sample_visible_normal(wo, alpha, a, b), u1, u2)
    off = visible_density(wo, h, alpha * 1.01) * area - 1
    # 1 % of width is 2 % of D, but where D does not depend on alpha: not in all rows.
    assert not (abs(off) <= 1e6 * EPS).all()


def test_seen_straight_on_the_normals_are_those_of_the_surface():
    """Their density is D cos θ then, and tan²θ = alpha² u / (1 - u) inverts it."""
    u = (np.arange(64) + 0.5) / 64
    wo = np.broadcast_to([0.0, 0.0, 1.0], (64, 3))
    h = sample_visible_normal(wo, np.full(64, 0.3), u, np.full(64, 0.125))
    tan2 = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
    assert_allclose(tan2, 0.09 * u / (1 - u), rtol=1e3 * EPS)


# ---------------------------------------------------------------- Beckmann


@pytest.mark.parametrize("alpha", WIDTHS)
def test_beckmanns_projected_density_integrates_to_1(alpha):
    """In s = exp(-tan²θ / α²), by which D cos θ dω = ds dφ / 2π: an even integrand."""

    def integrand(s):
        tan2 = -(alpha**2) * np.log(s)
        cos = 1 / np.sqrt(1 + tan2)
        # d(cos θ) / ds, from cos θ = (1 + tan²)^(-1/2).
        slope = 0.5 * cos**3 * alpha**2 / s
        return 2 * np.pi * one(beckmann_density, cos, alpha) * cos * slope

    total, error = quad(integrand, 1e-12, 1)
    assert error < 2e-8
    assert abs(total - 1) < 2e-8


def smith_of_beckmann(cos, alpha):
    """Smith's masking with the error function, to which the kernel has a fit."""
    a = cos / (alpha * np.sqrt(1 - cos * cos))
    return 2 / (1 + erf(a) + np.exp(-a * a) / (a * np.sqrt(np.pi)))


@given(scalars(0.001, 0.999), scalars(0.001, 1))
def test_beckmanns_masking_is_smiths_within_its_fit(cos, alpha):
    """[Walter07] states 0.35 %."""
    exact = smith_of_beckmann(cos, alpha)
    assert (abs(beckmann_g1(cos, alpha) - exact) <= 0.0035 * exact).all()


@given(scalars(0, 1), scalars(0.001, 1))
def test_beckmanns_masking_is_a_share_that_grows_with_the_cosine(cos, alpha):
    g = beckmann_g1(cos, alpha)
    assert ((g >= 0) & (g <= 1)).all()
    # The fit leaves 1 again at a = 1.6, where it is cut, by less than a rounding.
    higher = np.minimum(cos + 0.01, 1.0)
    assert (beckmann_g1(higher, alpha) >= g).all()


def test_beckmann_at_the_ends():
    alpha = np.full(3, 0.5)
    cos = np.array([1.0, 0.0, -0.5])
    assert_array_equal(beckmann_g1(cos, alpha), [1.0, 0.0, 0.0])
    density = beckmann_density(cos, alpha)
    assert_allclose(density, [1 / (np.pi * 0.25), 0.0, 0.0], rtol=4 * EPS)


def facing_density(wo, h, alpha):
    """Density of the sampler, as its docstring states it."""
    cos_d = dot(wo, h)
    share = facing_share(h[:, 2], wo[:, 2], cos_d)
    return beckmann_density(h[:, 2], alpha) * np.maximum(cos_d, 0) * share / wo[:, 2]


def turned(h):
    return h * [-1.0, -1.0, 1.0]


def facing_normal(*place):
    """Without what is left of the last number."""
    return sample_facing_normal(*place)[0]


@given(uniforms(), uniforms())
def test_a_number_that_has_chosen_is_uniform_still(u, p):
    """It runs from 0 to 1 once for each choice: the map back is linear.

    Two roundings of a quotient, a difference that is exact where it is small, and one
    each of the product and the sum.
    """
    left = left_of(u, p)
    assert ((left >= 0) & (left < 1)).all()
    back = np.where(u < p, left * p, p + left * (1.0 - p))
    assert (abs(back - u) <= 4 * EPS).all()


@given(views(), uniforms())
def test_facing_normals_have_their_density(view, u3):
    """The square is folded twice over the hemisphere: each normal and its opposite.

    By u1 and u2 alone the density is the inverse of the determinant; u3 keeps a normal
    or turns it, so that both together have what both had.  Rounding as for GGX: the
    exponent tan²/α² is below -log(0.02) and off by 1 / α², 400 roundings at 0.05.
    """
    wo, alpha, u1, u2 = view
    h = facing_normal(wo, alpha, u1, u2, u3)
    assert (abs(dot(h, h) - 1) <= 4 * EPS).all()
    assert (h[:, 2] >= 0).all()
    area = image_area(lambda a, b: facing_normal(wo, alpha, a, b, u3), u1, u2)
    both = facing_density(wo, h, alpha) + facing_density(wo, turned(h), alpha)
    assert_allclose(0.5 * both * area, 1.0, rtol=1e6 * EPS)


@given(views(), uniforms())
def test_of_two_facing_normals_one_is_drawn_by_what_it_shows(view, u3):
    """Kept if u3 is below its share of both densities; never one seen from behind."""
    wo, alpha, u1, u2 = view
    h = facing_normal(wo, alpha, u1, u2, np.zeros_like(u1))
    first = facing_normal(wo, alpha, u1, u2, u3)
    # With u3 = 0 the normal itself is kept, unless it shows nothing.
    mine, other = facing_density(wo, h, alpha), facing_density(wo, turned(h), alpha)
    share = mine / (mine + other)
    sure = abs(u3 - share) > 1e3 * EPS
    kept = abs(first - h).max(axis=1) == 0
    assert_array_equal(kept[sure], (u3 < share)[sure])
    assert (dot(wo, first) >= -8 * EPS).all()


@given(views(), uniforms())
def test_control_facing_normals_of_another_width_have_another_density(view, u3):
    wo, alpha, u1, u2 = view
    h = facing_normal(wo, alpha, u1, u2, u3)
    area = image_area(lambda a, b: facing_normal(wo, alpha, a, b, u3), u1, u2)
    wide = 1.01 * alpha
    both = facing_density(wo, h, wide) + facing_density(wo, turned(h), wide)
    assert not (abs(0.5 * both * area - 1) <= 1e6 * EPS).all()


# ---------------------------------------------------------------- mirrors


@given(unit_vectors(), unit_vectors())
def test_reflecting_twice_changes_nothing(wo, h):
    assert (abs(reflect(reflect(wo, h), h) - wo) <= 16 * EPS).all()


@given(unit_vectors(), unit_vectors())
def test_mirror_images_meet_the_normal_at_the_same_angle(wo, h):
    wi = reflect(wo, h)
    assert (abs(dot(wi, h) - dot(wo, h)) <= 12 * EPS).all()
    assert (abs(dot(wi, wi) - 1) <= 16 * EPS).all()
    # In one plane.
    assert (abs(dot(cross(wo, h), wi)) <= 16 * EPS).all()
