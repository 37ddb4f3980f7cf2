"""Kernels at the ends of the number line: total, finite, and as exact as their input.

Results are judged against mpmath on the same rounded inputs.  A hard input is not a bad
kernel: the condition number is allowed for, and written beside each bound.
"""

import mpmath
import numpy as np
import pytest
from hypothesis import given, target
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.numerics.arrays import dot, length
from restir_gi.reference.numerics.records import take
from restir_gi.reference.passes.gbuffer import similar
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    Samples,
    balance_heuristic,
    cap_confidence,
    choose_second,
    finalize,
    initial_candidates,
    merge,
    one_over_m,
    one_over_z,
    reused_candidates,
)
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.resampling.source import sample_source, source_pdf
from restir_gi.reference.resampling.target import reflected
from restir_gi.reference.resampling.target import target as p_hat_of
from restir_gi.reference.scene.materials import bsdf_sampling
from restir_gi.reference.scene.materials.fresnel import (
    fresnel_conductor,
    fresnel_dielectric,
)
from restir_gi.reference.scene.materials.kinds import Conductor
from restir_gi.reference.scene.materials.microfacet import (
    ggx_density,
    sample_visible_normal,
    smith_g1,
)
from restir_gi.reference.scene.materials.parameters import Kind, tabulate
from restir_gi.reference.scene.materials.table import is_shared
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.strategies import EXAMPLES, scalars, unit_vectors

F32, F64 = np.finfo(np.float32), np.finfo(np.float64)


def rows(*values, dtype=np.float64):
    return np.array(values, dtype)


# ---------------------------------------------------------------- Jacobian


def exact_jacobian(x_from, x_to, x, n):
    """J and Σκ of one row in mpmath, from the kernel's own rounded inputs."""
    with mpmath.workdps(60):
        seen, condition = [], 0
        for eye in (x_to, x_from):
            v = [mpmath.mpf(float(a)) - float(b) for a, b in zip(eye, x, strict=True)]
            d2 = mpmath.fsum(c * c for c in v)
            parts = [c * float(m) for c, m in zip(v, n, strict=True)]
            seen.append(abs(mpmath.fsum(parts)) / mpmath.sqrt(d2) ** 3)
            condition += mpmath.fsum(map(abs, parts)) / abs(mpmath.fsum(parts))
        return seen[0] / seen[1], condition


def share_of_bound(x_from, x_to, x, n):
    """Error of J over (22 + 4 Σκ) eps, the bound derived in properties/test_shift."""
    J = reconnection_jacobian(x_from, x_to, x, n)
    assert np.isfinite(J).all()
    shares = []
    for row in range(len(J)):
        exact, condition = exact_jacobian(x_from[row], x_to[row], x[row], n[row])
        bound = (22 + 4 * condition) * float(np.finfo(J.dtype).eps) * exact
        shares.append(float(abs(mpmath.mpf(float(J[row])) - exact) / bound))
    return max(shares)


AXES = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [2 / 3, 1 / 3, 2 / 3]])


@pytest.mark.parametrize("distance", [1e-12, 1e-8, 1e-4, 1.0, 1e4, 1e8])
def test_jacobian_of_near_and_far_points(distance):
    """Distances over twenty powers of ten; J goes as their square."""
    x, n = np.zeros((3, 3)), AXES[::-1]
    x_from, x_to = AXES, distance * AXES[[1, 2, 0]]
    assert share_of_bound(x_from, x_to, x, n) <= 1
    assert share_of_bound(x_to, x_from, x, n) <= 1


@pytest.mark.parametrize("cosine", [1e-3, 1e-8, 1e-15, 1e-100, 1e-300])
def test_jacobian_at_grazing_angles(cosine):
    """Cosines that no camera meets, from either side: finite, and exact for them."""
    x, n = np.zeros((1, 3)), rows([0.0, 0.0, 1.0])
    grazing, steep = rows([1.0, 0.0, cosine]), rows([0.6, 0.0, 0.8])
    assert share_of_bound(grazing, steep, x, n) <= 1
    assert share_of_bound(steep, grazing, x, n) <= 1


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("offset", [0.0, 1e3, 1e5, 1e6])
def test_jacobian_far_from_the_origin_in_half_the_digits(scale, offset):
    """Float32 rounds the places; judged on the rounded places it is as good as ever."""
    place = np.float32(offset)
    eyes = np.float32(scale) * np.float32([[0, 0, 1], [0.5, 0.25, 2], [-3, 1, 0.5]])
    x = np.full((3, 3), place)
    n = AXES[[0, 0, 0]].astype(np.float32)
    x_from, x_to = place + eyes, place + eyes[[1, 2, 0]]
    # Where the grid of float32 swallows the distance there is no cosine left to judge.
    heights = [dot(n, eye - x) for eye in (x_from, x_to)]
    left = np.flatnonzero((heights[0] != 0) & (heights[1] != 0))
    some = [a[left] for a in (x_from, x_to, x, n)]
    assert not len(left) or share_of_bound(*some) <= 1


@given(
    *[arrays(np.float32, (2, 3), elements=st.floats(-64, 64, width=32))] * 3,
    unit_vectors(2),
)
def test_worst_case_search_for_the_jacobian(x_from, x_to, x, n):
    """Hypothesis searches forwards the worst rounding."""
    n = n.astype(np.float32)
    heights = [dot(n, eye - x) for eye in (x_from, x_to)]
    usable = np.flatnonzero((abs(heights[0]) > 1e-6) & (abs(heights[1]) > 1e-6))
    if len(usable):
        worst = share_of_bound(*(a[usable] for a in (x_from, x_to, x, n)))
        target(worst)
        assert worst <= 1


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_jacobian_of_degenerate_geometry_is_0(dtype):
    """Edge-on from the source, touching from either side, no normal: no inverse."""
    here, up, beside = rows([0, 0, 0], [0, 0, 1], [1, 0, 0], dtype=dtype)[:, None]
    assert reconnection_jacobian(beside, up, here, up)[0] == 0
    assert reconnection_jacobian(here, up, here, up)[0] == 0
    assert reconnection_jacobian(up, here, here, up)[0] == 0
    assert reconnection_jacobian(here, here, here, up)[0] == 0
    assert reconnection_jacobian(up, up, here, 0 * up)[0] == 0
    # Edge-on for the receiver: it sees nothing of the patch.
    assert reconnection_jacobian(up, beside, here, up)[0] == 0


@pytest.mark.parametrize(("dtype", "tiny"), [(np.float32, 1e-23), (np.float64, 1e-170)])
def test_jacobian_of_distances_whose_square_vanishes_is_0(dtype, tiny):
    """Rejected as if the point touched the patch; never infinite or undefined."""
    x, n = np.zeros((1, 3), dtype), rows([0, 0, 1], dtype=dtype)
    near, far = rows([0, 0, tiny], dtype=dtype), rows([0, 0, 1], dtype=dtype)
    for x_from, x_to in ((near, far), (far, near), (near, near)):
        assert reconnection_jacobian(x_from, x_to, x, n)[0] in (0, 1)


@pytest.mark.parametrize(("dtype", "huge"), [(np.float32, 1e20), (np.float64, 1e160)])
def test_jacobian_of_distances_whose_square_overflows_is_finite(dtype, huge):
    x, n = np.zeros((1, 3), dtype), rows([0, 0, 1], dtype=dtype)
    far, near = rows([0, 0, huge], dtype=dtype), rows([0, 0, 1], dtype=dtype)
    assert np.isfinite(reconnection_jacobian(far, near, x, n)).all()


# ---------------------------------------------------------------- reservoirs


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_largest_radiance_weight_and_confidence_fit(dtype):
    """L = 65504, W = 1e8, M = 500, merged forty times: 1.3e17, far below 3.4e38."""
    one = np.ones(1, dtype)
    r = Reservoirs(np.zeros(1), one * dtype(1e8), one * 500)
    kept = reused_candidates(r, one * 65504)
    for _ in range(40):
        kept = merge(kept, reused_candidates(r, one * 65504), one / 2)
    closed = finalize(kept, kept.M)
    assert_allclose(closed.W, 1e8, rtol=64 * float(np.finfo(dtype).eps))
    assert closed.M[0] == 41 * 500


def test_a_weight_that_underflows_is_a_null_that_counts():
    r = Reservoirs(
        np.zeros(1), rows(1e-30, dtype=np.float32), rows(7, dtype=np.float32)
    )
    c = reused_candidates(r, rows(1e-20, dtype=np.float32))
    assert c.w[0] == 0
    assert c.M[0] == 7
    other = Candidates(np.ones(1), *(np.ones(1, np.float32) for _ in range(3)))
    kept = merge(other, c, np.zeros(1, np.float32))
    assert kept.y[0] == 1
    assert kept.M[0] == 8


def test_numbers_near_the_smallest_lose_digits_but_not_their_mean():
    """Subnormal weights: f W = f/p̂ · w/M stays finite and right where w/p̂ is."""
    p_hat = rows(1e-310, 3e-320)
    c = initial_candidates(np.arange(2), p_hat, np.ones(2))
    assert_array_equal(finalize(c, c.M).W, 1.0)
    # In two divisions: p̂ · Z underflows, w / p̂ / Z does not.
    tiny = Candidates(np.zeros(1), rows(1e-200), rows(1e-300), np.ones(1))
    assert_allclose(finalize(tiny, rows(1e-200)).W, 1e100, rtol=4 * F64.eps)


def test_the_weight_of_an_all_but_impossible_sample_stays_finite():
    """p̂ = 1e-39 beside w = 1, in float32: chosen once in 2^24 draws, with u = 0."""
    tiny, one = rows(1e-39, dtype=np.float32), np.ones(1, np.float32)
    both = merge(
        Candidates(np.zeros(1), one, one, one),
        Candidates(np.ones(1), tiny, tiny, one),
        np.zeros(1, np.float32),
    )
    assert np.isfinite(finalize(both, both.M).W).all()


def test_nothing_at_all_is_nothing():
    """No confidence, no target, no weight, no domain: W = 0 and no complaint."""
    zero, one = np.zeros(1), np.ones(1)
    nothing = Candidates(zero, zero, zero, zero)
    kept = merge(nothing, nothing, zero)
    for total in (
        kept.M,
        one_over_m([zero, zero]),
        one_over_z([one, one], [zero > 0, zero > 0]),
        balance_heuristic([one, one], [zero, zero], zero),
    ):
        assert finalize(kept, total).W[0] == 0
    # A target that was evaluated again and is gone.
    assert finalize(Candidates(zero, zero, one, one), one).W[0] == 0
    assert cap_confidence(Reservoirs(zero, zero, zero), 30.0).M[0] == 0


@pytest.mark.parametrize(
    ("dtype", "exact"), [(np.float16, 2**11), (np.float32, 2**24), (np.float64, 2**53)]
)
def test_confidence_counts_exactly_as_far_as_whole_numbers_go(dtype, exact):
    """Spatial M, at most 500 + 30 + 9 · 30 before it is capped, fits into half."""
    one = np.ones(1, dtype)
    last = Candidates(one, one, one, one * (exact - 1))
    assert merge(last, Candidates(one, one, one, one), one / 2).M[0] == exact
    assert 500 + 30 + 9 * 30 < 2**11


@given(
    *[arrays(np.float64, 4, elements=st.floats(2.0**-30, 2.0**30))] * 3,
    arrays(np.float64, 4, elements=st.floats(0, 1, exclude_max=True)),
    st.integers(-200, 200),
)
def test_the_unit_of_radiance_does_not_matter(p_hat, pdf, W, u, exponent):
    """Radiance times 2^k: the same samples, the same W, to the last bit.

    An absolute epsilon anywhere (max(w, 1e-4), a limit on W) would show.
    """

    def resampled(unit):
        new = initial_candidates(np.arange(4), p_hat * unit, pdf)
        r = Reservoirs(np.arange(4, 8), W, np.full(4, 3.0))
        kept = merge(reused_candidates(r, p_hat[::-1] * unit), new, u)
        return finalize(kept, kept.M)

    plain, scaled = resampled(1.0), resampled(2.0**exponent)
    assert_array_equal(scaled.y, plain.y)
    assert_array_equal(scaled.W, plain.W)


@given(
    *[arrays(np.float32, 4, elements=st.floats(0, 2.0**20, width=32))] * 2,
    arrays(np.float64, 4, elements=st.floats(0, 1, exclude_max=True)),
)
def test_decisions_of_half_the_digits_flip_only_at_the_threshold(w_a, w_b, u):
    """Float32 and float64 differ only where |u S - w| is within three roundings."""
    u = np.floor(u * 2**24) * 2.0**-24
    wide = [a.astype(np.float64) for a in (w_a, w_b)]
    single = choose_second(w_a, w_b, u.astype(np.float32))
    double = choose_second(*wide, u)
    left, right = u * (wide[0] + wide[1]), wide[1]
    # A sum and a product: two roundings; where they are subnormal, one step of those.
    margin = 1.5 * float(F32.eps) * np.maximum(left, right) + 2 * float(
        F32.smallest_subnormal
    )
    near = abs(left - right) <= margin
    assert_array_equal(single[~near], double[~near])


# ---------------------------------------------------------------- similarity

UP = rows([0.0, 0.0, 1.0])


def tilted(degrees):
    angle = np.radians(degrees)
    return rows([np.sin(angle), 0.0, np.cos(angle)])


def test_the_limit_of_the_angle_is_inclusive():
    depth = np.ones(1)
    at, beyond = tilted(25.0), tilted(25.0 + 1e-6)
    assert similar(UP, depth, at, depth, 25.0, 0.05)[0]
    assert not similar(UP, depth, beyond, depth, 25.0, 0.05)[0]
    assert not similar(UP, depth, -UP, depth, 25.0, 0.05)[0]


def test_the_limit_of_the_depth_is_inclusive():
    """15 and 16 differ by exactly 1/16 of the larger."""
    near, far = rows(15.0), rows(16.0)
    for a, b in ((near, far), (far, near)):
        assert similar(UP, a, UP, b, 25.0, 0.0625)[0]
    nearer = np.nextafter(near, 0)
    assert not similar(UP, nearer, UP, far, 25.0, 0.0625)[0]
    assert not similar(UP, far, UP, nearer, 25.0, 0.0625)[0]


@pytest.mark.parametrize("depth", [0.0, -1.0, -1e-300])
def test_nothing_seen_is_like_nothing(depth):
    for other in (0.0, 1.0, depth):
        assert not similar(UP, rows(depth), UP, rows(other), 25.0, 0.05)[0]
        assert not similar(UP, rows(other), UP, rows(depth), 25.0, 0.05)[0]


@given(unit_vectors(), unit_vectors(), scalars(0, 100), scalars(0, 100))
def test_pixels_agree_on_whether_they_are_neighbours(n_a, n_b, a, b):
    there = similar(n_a, a, n_b, b, 25.0, 0.05)
    assert_array_equal(there, similar(n_b, b, n_a, a, 25.0, 0.05))


@pytest.mark.parametrize("scale", [1e-300, 1e-3, 1e3, 1e300])
def test_similarity_does_not_know_the_unit_of_length(scale):
    a, b = rows(1.0, 1.0, 1.0) * scale, rows(0.96, 1.04, 0.5) * scale
    n = np.repeat(UP, 3, axis=0)
    assert similar(n, a, n, b, 25.0, 0.05).tolist() == [True, True, False]


# ---------------------------------------------------------------- targets


def receivers(material, position, wo=(0.0, 0.0, 1.0)):
    """Points on one material with normal z."""
    materials = tabulate([material])
    position = np.atleast_2d(position)
    count = len(position)
    points = SurfacePoints(
        position, np.tile(UP, (count, 1)), None, np.tile(wo, (count, 1)),
        np.repeat(materials.color, count, axis=0), np.zeros(count, np.int32),
        np.zeros(count, np.int32), np.ones(count, bool),
    )  # fmt: skip
    return materials, points


PAINT = EXAMPLES[Kind.LAMBERTIAN][0]
METAL = EXAMPLES[Kind.ROUGH_CONDUCTOR][0]
both_targets = pytest.mark.parametrize("kind", ["scattered", "outgoing"])
both_materials = pytest.mark.parametrize(
    "material", [PAINT, METAL], ids=["paint", "metal"]
)


@both_targets
@both_materials
def test_what_a_receiver_cannot_use_is_a_null(kind, material):
    """Below its horizon, behind the sample point, edge-on, or the receiver itself."""
    places = rows([0, 0, -1], [0, 0, 1], [1, 0, 1], [1, 0, 0], [0, 0, 0])
    normals = rows([0, 0, 1], [0, 0, 1], [1, 0, -1], [0, 0, -1], [0, 0, 1])
    y = Samples(places, normals / length(normals)[:, None], np.ones((5, 3)))
    materials, points = receivers(material, np.zeros((5, 3)))
    p_hat = p_hat_of(kind, materials, points, y)
    assert_array_equal(p_hat, 0)
    r = Reservoirs(y, np.ones(5), np.full(5, 3.0))
    c = reused_candidates(r, p_hat, np.ones(5))
    assert_array_equal(c.w, 0)
    assert_array_equal(c.M, 3)


@both_targets
@both_materials
@pytest.mark.parametrize("radiance", [0.0, 5e-324, 1e-300, 1e300])
def test_radiance_of_any_size_gives_a_finite_target(kind, material, radiance):
    y = Samples(rows([0.1, 0.0, 1.0]), -UP, np.full((1, 3), radiance))
    materials, points = receivers(material, np.zeros((1, 3)))
    p_hat = p_hat_of(kind, materials, points, y)
    assert np.isfinite(p_hat).all()
    if radiance != 5e-324:  # of which any share is 0
        assert (p_hat > 0).all() == (radiance > 0)


@both_targets
@both_materials
@pytest.mark.parametrize("distance", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_a_target_does_not_know_the_distance(kind, material, distance):
    """Solid angle is measured at the receiver: near and far count alike."""
    y = Samples(distance * rows([0.6, 0.0, 0.8]), -UP, np.ones((1, 3)))
    unit = Samples(rows([0.6, 0.0, 0.8]), -UP, np.ones((1, 3)))
    materials, points = receivers(material, np.zeros((1, 3)))
    found, expected = (p_hat_of(kind, materials, points, s) for s in (y, unit))
    # A direction is known to 3 eps, a lobe of alpha 0.3 multiplies that by 2 / alpha².
    assert_allclose(found, expected, rtol=100 * F64.eps)


@both_materials
def test_both_targets_are_positive_together(material):
    """Supports that differ would make 1/Z wrong for one of them."""
    rng = np.random.default_rng(5)
    places, normals = rng.normal(size=(2, 500, 3))
    y = Samples(places, normals / length(normals)[:, None], np.ones((500, 3)))
    materials, points = receivers(material, rng.normal(size=(500, 3)))
    positive = [
        p_hat_of(k, materials, points, y) > 0 for k in ("scattered", "outgoing")
    ]
    light = reflected(materials, points, y).any(axis=1)
    assert_array_equal(*positive)
    assert_array_equal(positive[0], light)
    assert 0 < light.sum() < 500


# ---------------------------------------------------------------- draws at the corners

CORNERS = [0.0, 2.0**-24, 0.5, 1 - 2.0**-24]
GRAZING = [1e-9, 1e-6, 1e-3, 0.1, 1.0]
EVERY = [m for kind in Kind for m in EXAMPLES[kind]]
THIN = [Conductor((1.0, 1.0, 1.0), 1e-3), Conductor((1.0, 1.0, 1.0), 1.0, schlick=True)]


def corners():
    """All four lanes at the ends of the unit interval."""
    return tuple(g.ravel() for g in np.meshgrid(*[CORNERS] * 3, [0.5]))


@pytest.mark.parametrize("material", EVERY + THIN, ids=repr)
@pytest.mark.parametrize("cos_o", GRAZING)
def test_draws_at_the_corners_are_finite(material, cos_o):
    """Unit directions, weights without NaN, and a density wherever a weight is.

    A direction mirrored in a normal of 1e-3 width is unit to 8 eps / cos.
    """
    u = corners()
    wo = (np.sqrt(1 - cos_o**2), 0.0, cos_o)
    materials, points = receivers(material, np.zeros((len(u[0]), 3)), wo)
    drawn = bsdf_sampling.sample(materials, points, u)
    assert np.isfinite(drawn.weight).all()
    assert np.isfinite(drawn.pdf).all()
    assert (drawn.weight >= 0).all()
    assert_allclose(length(drawn.wi), 1, rtol=64 * F64.eps)
    weighs = drawn.weight.any(axis=1)
    assert ((drawn.pdf > 0) | drawn.delta)[weighs].all()


@pytest.mark.parametrize("source", ["uniform", "cosine", "bsdf"])
@pytest.mark.parametrize("material", EVERY, ids=repr)
def test_initial_directions_at_the_corners_have_a_density(source, material):
    """Positive, or the draw is a null or not reused; for hemispheres 1 / p <= π 2¹²."""
    u = corners()
    materials, points = receivers(material, np.zeros((len(u[0]), 3)), (0.6, 0.0, 0.8))
    drawn = sample_source(source, materials, points, u)
    density = source_pdf(source, materials, points, drawn.wi)
    weighs = drawn.weight.any(axis=1) & ~drawn.delta & is_shared(materials, points)
    assert (density[weighs] > 0).all()
    if source != "bsdf":
        assert (1 / density[weighs] <= np.pi * 2**12 * (1 + 4 * F64.eps)).all()


@pytest.mark.parametrize("alpha", [1e-3, 0.5, 1.0])
@pytest.mark.parametrize("cos_o", [1e-9, 1e-4, 1.0])
def test_visible_normals_at_the_corners(alpha, cos_o):
    _, u1, u2, _ = corners()
    count = len(u1)
    wo = np.tile([np.sqrt(1 - cos_o**2), 0.0, cos_o], (count, 1))
    h = sample_visible_normal(wo, np.full(count, alpha), u1, u2)
    assert_allclose(length(h), 1, rtol=8 * F64.eps)
    assert (h[:, 2] >= 0).all()
    assert np.isfinite(ggx_density(h[:, 2], np.full(count, alpha))).all()


@pytest.mark.parametrize("alpha", [1e-3, 1.0])
def test_microfacets_at_the_ends_of_the_cosine(alpha):
    cos = rows(0.0, 5e-324, 1e-300, 1e-16, 1 - 2.0**-53, 1.0, -1.0)
    width = np.full(len(cos), alpha)
    for value in (ggx_density(cos, width), smith_g1(cos, width)):
        assert np.isfinite(value).all()
        assert (value >= 0).all()
    assert_allclose(
        ggx_density(rows(1.0), rows(alpha)), 1 / (np.pi * alpha**2), rtol=1e-9
    )


def test_fresnel_at_the_ends():
    """Grazing and straight on, indices from a void to diamond and beyond."""
    cos, eta = (g.ravel() for g in np.meshgrid(
        [0.0, 5e-324, 1e-160, 1e-8, 1.0], [1e-3, 0.4, 1.0, 1 + 2.0**-52, 2.4, 1e3]
    ))  # fmt: skip
    reflectance, cos_t = fresnel_dielectric(cos, eta)
    assert ((reflectance >= 0) & (reflectance <= 1)).all()
    assert ((cos_t >= 0) & (cos_t <= 1)).all()
    index = np.repeat(eta[:, None], 3, axis=1)
    for k in (0.0, 1e-8, 1.0, 100.0):
        metal = fresnel_conductor(cos, index, np.full_like(index, k))
        assert ((metal >= 0) & (metal <= 1 + 16 * F64.eps)).all()


def test_a_row_does_not_spoil_its_neighbours():
    """The worst rows of this file at once, beside a plain one."""
    materials, points = receivers(METAL, np.zeros((4, 3)))
    y = Samples(
        rows([0, 0, 0], [0, 0, 1e-9], [1e6, 0, 1e-9], [0.6, 0, 0.8]),
        np.repeat(-UP, 4, axis=0),
        rows([1e300] * 3, [0.0] * 3, [5e-324] * 3, [1.0] * 3),
    )
    together = p_hat_of("scattered", materials, points, y)
    last = np.array([3])
    alone = p_hat_of("scattered", materials, take(points, last), take(y, last))
    assert together[3] == alone[0] > 0
    assert np.isfinite(together).all()
