"""Materials: reciprocity, energy, and samplers that do what their densities say.

Integrals over the hemisphere are taken by a product rule in (cos θ, φ) that knows
nothing of the samplers.
"""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.numerics.arrays import cross, dot, length
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.scene.materials import (
    bsdf_sampling,
    conductor,
    lambertian,
    table,
)
from restir_gi.reference.scene.materials.coated import coat_probability, reflect_in_coat
from restir_gi.reference.scene.materials.dielectric import relative_index
from restir_gi.reference.scene.materials.fresnel import fresnel_dielectric
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.materials.microfacet import reflect
from restir_gi.reference.scene.materials.parameters import Kind, tabulate
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.strategies import (
    EXAMPLES,
    directions_above,
    draws,
    surfaces,
    unit_vectors,
)

EPS = np.finfo(np.float64).eps

SCATTERING = (
    Kind.LAMBERTIAN,
    Kind.ROUGH_CONDUCTOR,
    Kind.ROUGH_COATED,
    Kind.SMOOTH_COATED,
)
"""Kinds that scatter into solid angles above the surface."""

OPAQUE = (*SCATTERING, Kind.SMOOTH_CONDUCTOR)

WITH_DELTA = (Kind.SMOOTH_CONDUCTOR, Kind.SMOOTH_COATED, Kind.DIELECTRIC)


def seen_from(points, wo):
    """The same points with other viewers."""
    return SurfacePoints(
        points.position, points.normal, points.smooth, wo, points.color,
        points.material, points.primitive, points.front,
    )  # fmt: skip


@st.composite
def lit_surfaces(draw, *kinds, smooth=None, least=0.01):
    """Surfaces and directions to lights, above the shading normal."""
    surface = draw(surfaces(*kinds, smooth=smooth))
    return surface, draw(directions_above(surface.points.shading, least))


# ---------------------------------------------------------------- reciprocity


@given(lit_surfaces(*SCATTERING, smooth=False))
def test_light_and_viewer_may_change_places(case):
    """f(ωo, ωi) = f(ωi, ωo), on flat faces; interpolated normals break it.

    The half vector has the same bits, but its cosines with ωi and ωo differ by 4 eps,
    and F >= 0.03 changes by up to 6 times that: 800 eps.  All else is a few roundings.
    """
    surface, wi = case
    points = surface.points
    there = table.scattering(surface.table, points, wi)
    back = table.scattering(surface.table, seen_from(points, wi), points.wo)
    cos_i, cos_o = dot(points.normal, wi), dot(points.normal, points.wo)
    f_there, f_back = there / cos_i[:, None], back / cos_o[:, None]
    assert (abs(f_there - f_back) <= 1000 * EPS * abs(f_there)).all()


# ---------------------------------------------------------------- where nothing goes


@given(surfaces(*OPAQUE), unit_vectors())
def test_nothing_is_reflected_below_the_surface(surface, wi):
    """Below the geometric or the shading normal, and on black backs."""
    points, materials = surface.points, surface.table
    above = (dot(points.normal, wi) > 0) & (dot(points.shading, wi) > 0)
    lit = above & (points.front | materials.two_sided[points.material])
    value = table.scattering(materials, points, wi)
    density = table.pdf(materials, points, wi)
    assert_array_equal(value[~lit], 0)
    assert_array_equal(density[~lit], 0)
    assert (value >= 0).all()
    assert (density >= 0).all()


@given(lit_surfaces(*SCATTERING))
def test_light_from_above_is_reflected(case):
    """On fronts, and on backs that are not black; a black base under a coat shines."""
    surface, wi = case
    points, materials = surface.points, surface.table
    lit = points.front | materials.two_sided[points.material]
    lit &= (dot(points.normal, wi) > 0) & table.can_scatter(materials, points)
    base = materials.kind[points.material] == Kind.SMOOTH_COATED
    lit &= ~base | points.color.any(axis=1)
    reflected = table.scattering(materials, points, wi).any(axis=1)
    assert not reflected[~lit].any()
    told = ~in_a_tail(surface, wi)
    assert_array_equal(reflected[told], lit[told])


def in_a_tail(surface, wi):
    """Where Beckmann's exp(−tan²θ / α²) may be nothing: its least number is e^−745.

    The other factors are above e^−55.
    """
    points, materials = surface.points, surface.table
    h = wi + points.wo
    cosine = dot(points.shading, h) / np.sqrt(dot(h, h))
    tangent = 1 / cosine**2 - 1
    alpha = materials.alpha[points.material]
    return materials.beckmann[points.material] & (tangent > 690 * alpha**2)


def test_control_a_tail_is_no_excuse_near_the_peak():
    assert np.exp(-690.0) * np.exp(-55.0) > 0
    assert np.exp(-746.0) == 0


@given(lit_surfaces())
def test_whatever_is_reflected_can_be_drawn(case):
    surface, wi = case
    value = table.scattering(surface.table, surface.points, wi)
    density = table.pdf(surface.table, surface.points, wi)
    assert (density[value.any(axis=1)] > 0).all()


@given(surfaces(), draws())
def test_what_is_drawn_is_drawn_with_its_density(surface, u):
    """The fields of a draw agree with what the table says of its direction.

    What rough glass loses it loses in directions of its other lobe.
    """
    drawn = bsdf_sampling.sample(surface.table, surface.points, u)
    assert (abs(length(drawn.wi) - 1) <= 32 * EPS).all()
    value = table.scattering(surface.table, surface.points, drawn.wi)
    density = table.pdf(surface.table, surface.points, drawn.wi)
    glass = surface.table.kind[surface.points.material] == Kind.ROUGH_DIELECTRIC
    lost = glass & (drawn.pdf == 0)
    assert_array_equal(drawn.weight[lost], 0)
    scattered = ~drawn.delta & ~lost
    assert_array_equal(drawn.pdf[scattered], density[scattered])
    assert_array_equal(drawn.pdf[drawn.delta], 0)
    # One division, and one product to undo it.
    whole = (drawn.weight * drawn.pdf[:, None])[scattered]
    assert (abs(whole - value[scattered]) <= 4 * EPS * value[scattered]).all()


@given(surfaces(Kind.LAMBERTIAN, Kind.ROUGH_CONDUCTOR), draws())
def test_a_draw_from_one_lobe_never_gains_energy(surface, u):
    """Its weight is a reflectance, times G1 of the light for metals: at most 1.

    Beckmann's normals are not drawn by the masking that weighs them.
    """
    drawn = bsdf_sampling.sample(surface.table, surface.points, u)
    smith = ~surface.table.beckmann[surface.points.material]
    assert (drawn.weight[smith] <= 1 + 16 * EPS).all()


@given(surfaces(Kind.LAMBERTIAN), draws())
def test_lambertian_weights_are_the_reflectance_itself(surface, u):
    """To the bit: noise-free scenes stay noise-free."""
    drawn = bsdf_sampling.sample(surface.table, surface.points, u)
    reflects = drawn.weight.any(axis=1)
    assert_array_equal(drawn.weight[reflects], surface.points.color[reflects])


# ---------------------------------------------------------------- determinants


@given(surfaces(Kind.LAMBERTIAN, Kind.ROUGH_CONDUCTOR, least=0.05), draws())
def test_the_density_is_1_over_the_determinant_of_the_sampler(surface, u):
    """|∂ω/∂u1 × ∂ω/∂u2| p(ω) = 1, by complex steps; see test_microfacet for 1e6 eps."""
    points, step = surface.points, 1e-100
    u1, u2 = (0.02 + 0.96 * v for v in u[1:3])
    where = bsdf_sampling.sample(surface.table, points, (u[0], u1, u2, u[3])).wi
    density = table.pdf(surface.table, points, where)

    def moved(du1, du2):
        lanes = u[0], u1 + 1j * du1, u2 + 1j * du2, u[3]
        wi = np.zeros((len(points), 3), complex)
        for kind, rows, some in table.by_kind(surface.table, points):
            part = tuple(lane[rows] for lane in lanes)
            if kind == Kind.LAMBERTIAN:
                wi[rows] = lambertian.sample(some, part)
            else:
                wi[rows] = conductor.sample_reflected(surface.table, some, part)
        return wi.imag / step

    area = length(cross(moved(step, 0), moved(0, step)))
    # Beckmann's sampler folds the square: test_microfacet unfolds it.
    possible = (density > 0) & ~surface.table.beckmann[points.material]
    assert_allclose((area * density)[possible], 1, rtol=1e6 * EPS)


# ---------------------------------------------------------------- integrals

ANGLES = [0.1, 0.4, 0.8, 1.0]


def view(material, cos_o, rows=1):
    """Rows of one point with normal z, seen under a cosine."""
    materials = tabulate([material])
    wo = np.array([np.sqrt(1 - cos_o**2), 0.0, cos_o])
    points = SurfacePoints(
        position=np.zeros((1, 3)),
        normal=np.array([[0.0, 0.0, 1.0]]),
        smooth=None,
        wo=wo[None],
        color=materials.color[:1],
        material=np.zeros(1, np.int32),
        primitive=np.zeros(1, np.int32),
        front=np.ones(1, bool),
    )
    return materials, take(points, np.zeros(rows, np.int64))


def hemisphere(heights, azimuths):
    """Directions and weights of a product rule: Gauss in cos θ, midpoints in t.

    The view lies in the xz plane, so half a turn stands for the whole; φ = π (1 - t²)
    is dense about the mirror direction, where lobes are narrow at grazing angles.
    """
    nodes, weights = np.polynomial.legendre.leggauss(heights)
    cos = (nodes + 1) / 2
    t = (np.arange(azimuths) + 0.5) / azimuths
    phi = np.pi * (1 - t * t)
    c, f = (grid.ravel() for grid in np.meshgrid(cos, phi, indexing="ij"))
    # dω = dcos dφ with dcos = dnode / 2 and, for both halves, dφ = 4π t dt.
    measure = np.outer(weights / 2, 4 * np.pi * t / azimuths).ravel()
    s = np.sqrt(1 - c * c)
    return np.stack([s * np.cos(f), s * np.sin(f), c], axis=-1), measure


FINE, COARSE = hemisphere(160, 128), hemisphere(80, 64)


def integral(function, material, cos_o):
    """∫ over the hemisphere, and how far half the resolution is from it."""
    results = []
    for wi, measure in (FINE, COARSE):
        materials, points = view(material, cos_o, len(wi))
        values = function(materials, points, wi)
        results.append(np.tensordot(measure, values, axes=1))
    return results[0], np.max(abs(results[0] - results[1]))


EVERY = [m for kind in SCATTERING for m in EXAMPLES[kind]]
every_material = pytest.mark.parametrize("material", EVERY, ids=repr)


@every_material
@pytest.mark.parametrize("cos_o", ANGLES)
def test_no_more_is_reflected_than_comes_in(material, cos_o):
    """Albedo of all lobes, the delta ones included; error of the rule by halving it."""
    albedo, error = integral(table.scattering, material, cos_o)
    materials, points = view(material, cos_o)
    if materials.kinds == (Kind.SMOOTH_COATED,):
        albedo = albedo + reflect_in_coat(materials, points)[1][0]
    assert error < 0.01
    assert (albedo <= 1 + error).all()
    assert (albedo >= 0).all()


@every_material
@pytest.mark.parametrize("cos_o", ANGLES)
def test_the_density_integrates_to_what_is_not_lost(material, cos_o):
    """∫ p = 1 less the share of draws below the surface or on the delta lobe.

    The share is counted on a lattice of 64² draws a lobe: each count is off by no more
    than the cells that a boundary crosses, 2 · 64 of them.  The lobe is picked with 16
    midpoints: off by half a sixteenth.
    """
    total, error = integral(table.pdf, material, cos_o)
    grid = (np.arange(64) + 0.5) / 64
    u = np.meshgrid((np.arange(16) + 0.5) / 16, grid, grid)
    u0, u1, u2 = (lane.ravel() for lane in u)
    materials, points = view(material, cos_o, len(u0))
    drawn = bsdf_sampling.sample(materials, points, (u0, u1, u2, u0))
    lattice = 2 / 64 + (1 / 32 if materials.kind[0] in MIXTURES else 0)
    assert error < 0.01
    assert total <= 1 + error
    assert abs(total - np.mean(drawn.pdf > 0)) <= error + lattice


MIXTURES = (Kind.ROUGH_COATED, Kind.SMOOTH_COATED)


@pytest.mark.parametrize("cos_o", ANGLES)
def test_white_lambertian_reflects_all(cos_o):
    white = type(EVERY[0])((1.0, 1.0, 1.0))
    albedo, _ = integral(table.scattering, white, cos_o)
    # The rule is exact for cos θ dω.  20,480 positive terms are added as a product of
    # matrices: in order, at worst, though their errors are random.
    assert_allclose(albedo, 1, rtol=np.sqrt(20_480) * 4 * EPS)


# ---------------------------------------------------------------- delta lobes


@given(surfaces(*WITH_DELTA), draws())
def test_draws_of_delta_lobes_have_no_density(surface, u):
    """sample_apart draws delta lobes and nothing else; the mixture marks them."""
    alone = bsdf_sampling.sample_apart(surface.table, surface.points, u)
    assert alone.delta.all()
    assert_array_equal(alone.pdf, 0)
    assert (abs(length(alone.wi) - 1) <= 32 * EPS).all()


@given(surfaces(*SCATTERING[:3]), draws())
def test_materials_without_delta_lobe_have_no_such_draws(surface, u):
    alone = bsdf_sampling.sample_apart(surface.table, surface.points, u)
    assert_array_equal(alone.weight, 0)
    assert not alone.delta.any()


@given(surfaces(Kind.SMOOTH_COATED), draws())
def test_a_smooth_coat_is_drawn_with_its_probability(surface, u):
    """Weight times probability is what the coat reflects, alone or in a mixture."""
    points = surface.points
    wi, share = reflect_in_coat(surface.table, points)
    probability = coat_probability(surface.table, points)
    drawn = bsdf_sampling.sample(surface.table, points, u)
    assert_array_equal(drawn.delta, u[0] < probability)
    coat = drawn.delta
    whole = drawn.weight * probability[:, None]
    assert (abs(whole - share)[coat] <= 2 * EPS * share[coat]).all()
    assert_array_equal(drawn.wi[coat], wi[coat])
    alone = bsdf_sampling.sample_apart(surface.table, points, u)
    assert_array_equal(alone.weight, share)


@given(surfaces(Kind.SMOOTH_CONDUCTOR), draws())
def test_a_mirror_mirrors(surface, u):
    points = surface.points
    drawn = bsdf_sampling.sample(surface.table, points, u)
    assert_array_equal(drawn.wi, reflect(points.wo, points.shading))
    lit = dot(points.normal, drawn.wi) > 0
    assert_array_equal(drawn.weight[~lit], 0)
    assert (drawn.weight <= 1 + 8 * EPS).all()


def both_ways(surface):
    """What glass reflects and what it refracts, whatever its probabilities."""
    rows = len(surface.points)
    lanes = [np.full(rows, x) for x in (0.0, 1 - 2.0**-53)]
    return [
        bsdf_sampling.sample(surface.table, surface.points, (u, u, u, u)) for u in lanes
    ]


@given(surfaces(Kind.DIELECTRIC, smooth=False))
def test_glass_loses_nothing(surface):
    """Flux F · 1 + (1 - F) · η² w = 1; refracted radiance w is scaled by 1 / η²."""
    points = surface.points
    ior = surface.table.ior[points.material]
    eta = np.where(points.front, ior, 1 / ior)
    cos_o = np.clip(dot(points.normal, points.wo), 0, 1)
    F, _ = fresnel_dielectric(cos_o, eta)
    reflected, refracted = both_ways(surface)
    up = dot(points.normal, refracted.wi) > 0
    assert_array_equal(reflected.weight, 1)
    assert_array_equal(up, F == 1)
    flux = np.where(up, 1, eta**2 * refracted.weight[:, 0])
    assert (abs(F + (1 - F) * flux - 1) <= 4 * EPS).all()


@given(surfaces(Kind.DIELECTRIC, smooth=False))
def test_glass_refracts_by_snell_in_the_plane_of_incidence(surface):
    """Sines of 10 eps; the cosine below is a root, but that is along the normal."""
    points = surface.points
    _, refracted = both_ways(surface)
    wi, n = refracted.wi, points.normal
    below = dot(n, wi) < 0
    ior = surface.table.ior[points.material]
    eta = np.where(points.front, ior, 1 / ior)
    outside, inside = cross(n, points.wo), cross(n, wi)
    # Opposite sides of the normal: η sin θ_t = - sin θ_i, as vectors.
    off = abs(eta[:, None] * inside + outside)
    assert (off[below] <= 32 * EPS).all()


@given(surfaces(Kind.DIELECTRIC, smooth=False, least=0.2))
def test_light_finds_its_way_back_through_glass(surface):
    """Refraction from the other side: the same path, and 1 / η² · η² = 1."""
    points = surface.points
    _, refracted = both_ways(surface)
    below = np.flatnonzero(dot(points.normal, refracted.wi) < -1e-3)
    assume(len(below))
    some, wi = take(points, below), refracted.wi[below]
    behind = SurfacePoints(
        some.position, -some.normal, None, wi, some.color,
        some.material, some.primitive, ~some.front,
    )  # fmt: skip
    almost_one = np.full(len(below), 1 - 2.0**-53)
    back = bsdf_sampling.sample(surface.table, behind, (almost_one,) * 4)
    # Roots of 1 - sin²: errors go as the inverse cosines, 1e3 and 5 at most.
    cosine = abs(dot(some.normal, wi))
    assert (length(back.wi - some.wo) <= 64 * EPS / cosine / 0.2).all()
    product = back.weight * refracted.weight[below]
    assert_allclose(product, 1, rtol=8 * EPS)


# ---------------------------------------------------------------- rough glass

ROUGH_GLASS = pytest.mark.parametrize(
    "material",
    [*EXAMPLES[Kind.ROUGH_DIELECTRIC], Dielectric(1.5, 0.3, "beckmann")],
    ids=repr,
)


def on_the_sphere(function, material, cos_o):
    """Integrals above and below the surface, and the errors of both together."""

    def below(table, points, wi):
        return function(table, points, wi * [1.0, 1.0, -1.0])

    sides = [integral(side, material, cos_o) for side in (function, below)]
    return sides[0][0], sides[1][0], sides[0][1] + sides[1][1]


@ROUGH_GLASS
@pytest.mark.parametrize("cos_o", ANGLES)
def test_rough_glass_passes_on_no_more_than_comes_in(material, cos_o):
    """Flux is that of radiance above, and η² times that below; little gets lost.

    What single scattering loses is at most 35 % here; a factor of η² = 2.25 that is
    missing, or doubled, would stand out on the one side or the other.
    """
    above, below, error = on_the_sphere(table.scattering, material, cos_o)
    flux = above + material.ior**2 * below
    assert error < 0.01
    # Beckmann's masking is a fit, within 0.35 % for light and viewer each.
    assert (flux <= 1 + error + 0.007).all()
    assert (flux >= 0.65).all()


@ROUGH_GLASS
@pytest.mark.parametrize("cos_o", ANGLES)
def test_rough_glass_is_drawn_from_both_sides_of_it(material, cos_o):
    """∫ p over the sphere is 1 less what is counted as lost on a lattice of draws."""
    above, below, error = on_the_sphere(table.pdf, material, cos_o)
    grid = (np.arange(32) + 0.5) / 32
    u = [lane.ravel() for lane in np.meshgrid(grid, grid, grid, (0.25, 0.75))]
    materials, points = view(material, cos_o, len(u[0]))
    drawn = bsdf_sampling.sample(materials, points, tuple(u))
    assert error < 0.01
    # Cells that a boundary crosses, 2 in 32 for each of three lanes, and both halves
    # of the last, of which no more than one turns a normal from half of its cell.
    lattice = 3 * 2 / 32
    kept = np.mean(drawn.pdf > 0)
    assert abs(above + below - kept) <= error + lattice
    up = np.mean((drawn.pdf > 0) & (drawn.wi[:, 2] > 0))
    assert abs(above - up) <= error + lattice


@given(surfaces(Kind.ROUGH_DIELECTRIC, smooth=False, least=0.1), draws())
def test_light_finds_its_way_back_through_rough_glass(surface, u):
    """Seen from wi the same light is η² times as strong, and alike if it is reflected.

    f(wo, wi) / η_o² is symmetric [Veach97].  The microfacet is found anew from the
    other side, as wo + wi η: its direction is off by some roundings over the length of
    that sum, and D by tan²/α² times that.
    """
    points = surface.points
    drawn = bsdf_sampling.sample(surface.table, points, u)
    wi, n = drawn.wi, points.normal
    eta = relative_index(surface.table, points)
    cos_i = dot(n, wi)
    through = cos_i < 0
    turn = np.where(through, -1.0, 1.0)
    behind = SurfacePoints(
        points.position, n * turn[:, None], None, wi, points.color,
        points.material, points.primitive, points.front ^ through,
    )  # fmt: skip
    there = table.scattering(surface.table, points, wi)[:, 0] / abs(cos_i)
    back = table.scattering(surface.table, behind, points.wo)[:, 0]
    back = back / dot(n, points.wo)
    scale = np.where(through, eta * eta, 1.0)
    length_h = length(points.wo + wi * np.where(through, eta, 1.0)[:, None])
    sure = (there > 1e-6) & (abs(cos_i) > 0.01) & (length_h > 0.05)
    # 1 / 0.05 of direction, 1 / α² = 11 of slope, tan² and F of some ten each.
    assert_allclose(back[sure], (scale * there)[sure], rtol=1e6 * EPS)


@given(surfaces(Kind.ROUGH_DIELECTRIC), unit_vectors())
def test_rough_glass_scatters_only_where_both_normals_agree(surface, wi):
    points = surface.points
    sides = np.sign(dot(points.normal, wi)), np.sign(dot(points.shading, wi))
    apart = sides[0] != sides[1]
    value = table.scattering(surface.table, points, wi)
    density = table.pdf(surface.table, points, wi)
    assert_array_equal(value[apart], 0)
    assert_array_equal(density[apart], 0)
    assert ((value >= 0) & np.isfinite(value)).all()
    assert_array_equal(value.any(axis=1), density > 0)


@given(surfaces(Kind.ROUGH_DIELECTRIC), draws())
def test_rough_glass_is_not_shared_but_drawn_apart(surface, u):
    """What `sample` draws of it and nothing else; all other light stays shared."""
    alone = bsdf_sampling.sample_apart(surface.table, surface.points, u)
    drawn = bsdf_sampling.sample(surface.table, surface.points, u)
    for name in ("wi", "weight", "pdf", "delta"):
        assert_array_equal(getattr(alone, name), getattr(drawn, name))
    assert not alone.delta.any()
    assert not table.is_shared(surface.table, surface.points).any()


# ---------------------------------------------------------------- what scatters


@given(surfaces(), unit_vectors())
def test_what_cannot_scatter_does_not(surface, wi):
    able = table.can_scatter(surface.table, surface.points)
    value = table.scattering(surface.table, surface.points, wi)
    assert_array_equal(value[~able], 0)


def test_a_draw_does_not_depend_on_its_neighbours_kind():
    """Each row as if it were alone, over all kinds at once."""
    examples = [m for kind in Kind for m in EXAMPLES[kind]]
    materials = tabulate(examples)
    rows = len(examples)
    wo = np.tile([[0.6, 0.0, 0.8]], (rows, 1))
    points = SurfacePoints(
        np.zeros((rows, 3)), np.tile([[0.0, 0.0, 1.0]], (rows, 1)), None, wo,
        materials.color, np.arange(rows, dtype=np.int32),
        np.arange(rows, dtype=np.int32), np.ones(rows, bool),
    )  # fmt: skip
    u = KeyedUniforms(np.arange(rows, dtype=np.uint32), 0, 0, Stream.INITIAL).draw(0)
    together = bsdf_sampling.sample(materials, points, u)
    for row, material in enumerate(examples):
        own = SurfacePoints(
            *(take(getattr(points, name), np.array([row]))
              for name in ("position", "normal")),
            None, wo[[row]], points.color[[row]], np.zeros(1, np.int32),
            points.primitive[[row]], points.front[[row]],
        )  # fmt: skip
        alone = bsdf_sampling.sample(
            tabulate([material]), own, tuple(v[[row]] for v in u)
        )
        assert_array_equal(alone.wi[0], together.wi[row])
        assert_array_equal(alone.weight[0], together.weight[row])


def test_control_an_albedo_above_1_is_found():
    """Twice the lobe of a white conductor, seen by the same integral."""
    material = EXAMPLES[Kind.ROUGH_CONDUCTOR][0]
    bright = type(material)((1.0, 1.0, 1.0), 0.3)

    def twice(*arguments):
        return 2 * table.scattering(*arguments)

    albedo, error = integral(twice, bright, 0.8)
    assert (albedo > 1 + error).all()
