"""Samplers against their densities: round trips, determinants, integrals, tables."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.numerics.arrays import cross, dot, length
from restir_gi.reference.numerics.sampling import (
    invert_cosine_hemisphere,
    invert_triangle,
    invert_uniform_hemisphere,
    invert_uniform_sphere,
    pdf_cosine_hemisphere,
    pdf_uniform_hemisphere,
    sample_cosine_hemisphere,
    sample_triangle,
    sample_uniform_hemisphere,
    sample_uniform_sphere,
)
from restir_gi.reference.numerics.tables import (
    cumulate,
    guide_of,
    index_in_table,
    sample_table,
)
from restir_gi.reference.strategies import ROWS, uniforms

EPS = np.finfo(np.float64).eps


def pdf_uniform_sphere(z):
    return np.full_like(z, 1 / (4 * np.pi))


DIRECTIONS = {
    "uniform hemisphere": (
        sample_uniform_hemisphere,
        pdf_uniform_hemisphere,
        invert_uniform_hemisphere,
    ),
    "cosine hemisphere": (
        sample_cosine_hemisphere,
        pdf_cosine_hemisphere,
        invert_cosine_hemisphere,
    ),
    "uniform sphere": (
        sample_uniform_sphere,
        pdf_uniform_sphere,
        invert_uniform_sphere,
    ),
}

of_directions = pytest.mark.parametrize(
    ("sample", "pdf", "invert"), DIRECTIONS.values(), ids=DIRECTIONS
)


# ---------------------------------------------------------------- directions


@of_directions
@given(u1=uniforms(), u2=uniforms())
def test_samples_are_unit_vectors(sample, pdf, invert, u1, u2):
    """Six roundings of half an eps in |ω|²."""
    omega = sample(u1, u2)
    assert (abs(dot(omega, omega) - 1) <= 3 * EPS).all()


@of_directions
@given(u1=uniforms(), u2=uniforms())
def test_samples_lie_where_the_density_is(sample, pdf, invert, u1, u2):
    assert (pdf(sample(u1, u2)[:, 2]) > 0).all()


@of_directions
@given(u1=uniforms(), u2=uniforms())
def test_inversion_gives_the_numbers_back(sample, pdf, invert, u1, u2):
    """The height within rounding of 1; the azimuth as far as the circle is wide.

    |Δu1| <= 4 eps.  A point at radius s is known to eps/2 in each coordinate, and
    φ = 2π u2 to 4 roundings: the angle is off by at most eps (1/s + 4 · 2π) / 2π.  0 is
    next to 1.
    """
    omega = sample(u1, u2)
    v1, v2 = invert(omega)
    s = np.hypot(omega[:, 0], omega[:, 1])
    assert (abs(v1 - u1) <= 4 * EPS).all()
    off = abs(v2 - u2)
    off = np.minimum(off, 1 - off)
    somewhere = s > 0
    assert (off[somewhere] <= EPS * (1 / s[somewhere] + 4)).all()
    assert ((v2 >= 0) & (v2 < 1)).all()


def test_an_azimuth_is_below_1():
    """A hair below the x axis, where turns + 1 rounds to 1."""
    omega = np.array([[1.0, -1e-20, 0.0], [1.0, -1e-300, 0.0], [1.0, -0.0, 0.0]])
    for _, _, invert in DIRECTIONS.values():
        assert_array_equal(invert(omega)[1], 0.0)


def area_of_image(sample, u1, u2, step=1e-100):
    """|∂ω/∂u1 × ∂ω/∂u2|, by complex steps: no difference, so no cancellation."""
    du1 = sample(u1 + 1j * step, u2 + 0j).imag / step
    du2 = sample(u1 + 0j, u2 + 1j * step).imag / step
    return length(cross(du1, du2))


@of_directions
@given(u1=uniforms(), u2=uniforms())
def test_the_density_is_1_over_the_determinant(sample, pdf, invert, u1, u2):
    """Away from the pole, where azimuth and radius mean nothing.

    The derivatives are exact to a few roundings, 40 eps in all; 1 - u1² loses what is
    left of it near u1 = 1, and 1/u1 bounds the slope of a root near 0.
    """
    u1 = 0.01 + 0.98 * u1
    area = area_of_image(sample, u1, u2)
    expected = 1 / pdf(sample(u1, u2)[:, 2])
    margin = 40 * EPS * (1 / u1 + 1 / (1 - u1))
    assert (abs(area - expected) <= margin * expected).all()


def test_control_a_wrong_density_does_not_pass():
    u1, u2 = np.array([0.3]), np.array([0.6])
    area = area_of_image(sample_cosine_hemisphere, u1, u2)
    wrong = 1 / pdf_uniform_hemisphere(np.array([0.5]))
    assert abs(area / wrong - 1)[0] > 0.1


@of_directions
def test_the_density_integrates_to_1(sample, pdf, invert):
    """2π ∫ p dz; p is a polynomial of degree 1 on either side of z = 0."""
    nodes, weights = np.polynomial.legendre.leggauss(2)
    upper = (nodes + 1) / 2
    z = np.concatenate([upper, -upper])
    total = 2 * np.pi * np.sum(pdf(z) * np.tile(weights, 2) / 2)
    assert_allclose(total, 1, rtol=4 * EPS)


def test_below_the_hemisphere_there_is_nothing():
    below = np.array([-1.0, -1e-300])
    assert_array_equal(pdf_cosine_hemisphere(below), 0.0)
    assert_array_equal(pdf_uniform_hemisphere(below), 0.0)
    assert pdf_cosine_hemisphere(np.zeros(1))[0] == 0
    assert pdf_uniform_hemisphere(np.zeros(1))[0] > 0


def test_cosine_samples_never_graze():
    """The largest u1 of the generator leaves cos² θ = 2⁻²⁴: 1 / p <= π 2¹²."""
    omega = sample_cosine_hemisphere(np.array([1 - 2.0**-24]), np.zeros(1))
    assert 1 / pdf_cosine_hemisphere(omega[:, 2])[0] <= np.pi * 2**12 * (1 + EPS)


# ---------------------------------------------------------------- triangles


@given(uniforms(), uniforms())
def test_triangle_barycentrics_are_inside(u1, u2):
    b1, b2 = sample_triangle(u1, u2)
    assert (b1 >= 0).all()
    assert (b2 >= 0).all()
    # Two products and their sum, half an eps each of what is at most 1.
    assert (b1 + b2 <= 1 + 1.5 * EPS).all()


@given(uniforms(), uniforms())
def test_triangle_inversion_gives_the_numbers_back(u1, u2):
    u1 = np.maximum(u1, 2.0**-24)
    v1, v2 = invert_triangle(*sample_triangle(u1, u2))
    assert (abs(v1 - u1) <= 8 * EPS * u1).all()
    assert (abs(v2 - u2) <= 4 * EPS).all()


@given(uniforms(), uniforms())
def test_triangle_is_covered_evenly(u1, u2):
    """|∂(b1, b2) / ∂(u1, u2)| = 1/2, the area of the triangle of barycentrics."""
    u1, step = 0.01 + 0.98 * u1, 1e-100
    a = sample_triangle(u1 + 1j * step, u2 + 0j)
    b = sample_triangle(u1 + 0j, u2 + 1j * step)
    determinant = (a[0].imag * b[1].imag - a[1].imag * b[0].imag) / step**2
    assert_allclose(abs(determinant), 0.5, rtol=12 * EPS)


# ---------------------------------------------------------------- tables

whole_weights = arrays(np.int64, st.integers(1, 9), elements=st.integers(0, 6)).map(
    lambda w: w + (w.sum() == 0)
)


@given(whole_weights)
def test_the_law_of_a_table_is_exact(weights):
    """Each index comes as often as it weighs, on midpoints of as many cells.

    A midpoint is half a cell from every threshold, so no rounding makes a miss.
    """
    total = weights.sum()
    u = (np.arange(total) + 0.5) / total
    index, rest = sample_table(cumulate(weights.astype(float)), u)
    counts = np.bincount(index, minlength=len(weights))
    assert_array_equal(counts, weights)
    # What is left of u is the place within the interval: midpoints again.
    for i, w in enumerate(weights):
        expected = (np.arange(w) + 0.5) / max(w, 1)
        assert_allclose(rest[index == i], expected, atol=2 * EPS * total)


@given(whole_weights, uniforms())
def test_an_index_of_weight_0_is_never_drawn(weights, u):
    ends = [0.0, 2.0**-149, 0.5, 1 - 2.0**-24, 1 - 2.0**-53]
    cumulative = cumulate(weights.astype(float))
    # The thresholds themselves, and their neighbours.
    at = np.concatenate([cumulative, np.nextafter(cumulative, 0)])
    every = np.concatenate([u, ends, at[at < 1]])
    index, rest = sample_table(cumulative, every)
    assert (weights[index] > 0).all()
    assert ((rest >= 0) & (rest < 1)).all()
    assert_array_equal(index_in_table(cumulative, guide_of(cumulative), every), index)


@given(
    arrays(
        np.float64,
        st.integers(1, 30),
        elements=st.floats(0, 1e300, allow_subnormal=True),
    )
)
def test_a_running_sum_never_falls_and_ends_at_1(weights):
    weights[0] += weights.sum() == 0
    cumulative = cumulate(weights)
    assert (np.diff(cumulative) >= 0).all()
    last = np.flatnonzero(weights)[-1]
    assert_array_equal(cumulative[last:], 1.0)
    assert (cumulative <= 1).all()


def test_a_running_sum_never_falls_in_long_tables():
    """The end of a table that NumPy's pairwise sum would put below its running sum."""
    falls = 0
    for seed in range(40):
        weights = np.random.default_rng(seed).random(200)
        weights[-1] = 1e-30
        assert (np.diff(cumulate(weights)) >= 0).all()
        falls += np.cumsum(weights)[-2] > weights.sum()
    assert falls > 0  # else the seeds do not look where they should


@pytest.mark.parametrize("weights", [[], [0.0], [-1.0, 3.0], [np.nan], [np.inf, 1.0]])
def test_a_table_without_a_law_is_refused(weights):
    with pytest.raises(ValueError, match="weights must be"):
        cumulate(np.array(weights))


@given(u1=uniforms(), u2=uniforms())
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.longdouble])
def test_directions_keep_their_number_type(dtype, u1, u2):
    for sample, _, invert in DIRECTIONS.values():
        omega = sample((u1 / 2).astype(dtype), (u2 / 2).astype(dtype))
        assert omega.dtype == dtype
        assert all(v.dtype == dtype for v in invert(omega))
        assert len(omega) == ROWS
