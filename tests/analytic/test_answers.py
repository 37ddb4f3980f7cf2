"""The catalogue's known answers against quadrature that shares nothing with them.

SciPy integrates the rendering equation over the area of what lights the point.  The
tolerance is the error that the outer quadrature reports, plus what was asked of the
inner ones, plus rounding of some hundred operations.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from restir_gi.reference.scene.catalogue.answers import (
    UPPER_PLATE,
    WALL,
    half_lit_sphere,
    parallel_plates_indirect,
    polygon_form_factor,
    sphere_furnace,
    sunlit_wall_indirect,
)
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.catalogue.spheres import ALBEDO, EMISSION, INTENSITY
from restir_gi.reference.scene.geometry import world_corners
from tests.analytic.rendering import what_is_seen, world_of

ROUNDING = 100 * 2.0**-52
ASKED = 1e-10


def form_factor(x, n, corner, u, v):
    """∫ n · ω |n' · ω| / (π d²) dA over the parallelogram, and its error.

    The horizon n · d = 0 is a line in (s, t): the integral ends there, and is cut where
    that line meets a side, so that each part is smooth.
    """
    normal = np.cross(u, v)
    h, h_u, h_v = n @ (corner - x), n @ u, n @ v

    def integrand(t, s):
        d = corner + s * u + t * v - x
        d2 = d @ d
        return (n @ d) * abs(normal @ d) / (np.pi * d2 * d2)

    def bounds(s):
        edge = np.clip(-(h + s * h_u) / h_v, 0.0, 1.0)
        return (edge, 1.0) if h_v > 0 else (0.0, edge)

    cuts = [0.0, *sorted(np.clip([-h / h_u, -(h + h_v) / h_u], 0.0, 1.0)), 1.0]
    parts = [
        dblquad(
            integrand,
            start,
            end,
            lambda s: bounds(s)[0],
            lambda s: bounds(s)[1],
            epsabs=ASKED,
            epsrel=ASKED,
        )
        for start, end in pairwise(cuts)
    ]
    value, error = np.sum(parts, axis=0)
    return value, error + ASKED


def elements(seed, count=6):
    """Points and normals around the sunlit wall, some of which it straddles."""
    rng = np.random.default_rng(seed)
    x = rng.uniform([-2, -1, 0.3], [2, 3, 3], (count, 3))
    n = rng.normal(size=(count, 3))
    return x, n / np.linalg.norm(n, axis=1, keepdims=True)


def test_form_factor_equals_quadrature():
    x, n = elements(1)
    computed = polygon_form_factor(x, n, WALL)
    heights = np.einsum("nki,ni->nk", WALL[None] - x[:, None], n)
    # The horizon clips some, spares one and hides one.
    clipped = (heights > 0).any(axis=1) & (heights < 0).any(axis=1)
    assert clipped.sum() >= 2
    for i in range(len(x)):
        expected, error = form_factor(
            x[i], n[i], WALL[0], WALL[1] - WALL[0], WALL[3] - WALL[0]
        )
        assert abs(computed[i] - expected) <= error + ROUNDING


def test_control_a_form_factor_without_clipping_is_found():
    """Lambert's sum over all edges counts what is below the horizon as negative."""
    x, n = elements(1)
    corners = WALL[None] - x[:, None]
    total = np.zeros(len(x))
    for a, b in zip(range(4), (1, 2, 3, 0), strict=True):
        normal = np.cross(corners[:, a], corners[:, b])
        size = np.linalg.norm(normal, axis=1)
        inner = np.einsum("ij,ij->i", corners[:, a], corners[:, b])
        total += np.arctan2(size, inner) * np.einsum("ij,ij->i", normal, n) / size
    naive = np.abs(total) / (2 * np.pi)
    assert np.abs(naive - polygon_form_factor(x, n, WALL)).max() > 1e-3


def test_faces_of_a_box_share_all_light():
    """Closure: from a point of its floor, the other five faces fill the hemisphere."""
    low, high = np.array([-1.0, 0, -2]), np.array([3.0, 2, 1])
    rng = np.random.default_rng(3)
    x = rng.uniform(low + 0.1, high - 0.1, (20, 3))
    x[:, 1] = 0.0
    up = np.tile([0.0, 1, 0], (20, 1))
    total = np.zeros(20)
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        for side in (low, high):
            face = np.tile(side, (4, 1))
            for k, (a, b) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
                face[k, others[0]] = (low, high)[a][others[0]]
                face[k, others[1]] = (low, high)[b][others[1]]
            total += polygon_form_factor(x, up, face)
    assert np.abs(total - 1.0).max() < ROUNDING


def test_a_corner_above_an_element_has_the_textbook_value():
    """Parallel rectangle a x b at height c over one of its corners."""
    a, b, c = 1.5, 0.7, 1.2
    rectangle = np.array([[0, c, 0], [a, c, 0], [a, c, b], [0, c, b]])
    X, Y = a / c, b / c
    rx, ry = np.hypot(1, X), np.hypot(1, Y)
    expected = (X / rx * np.arctan(Y / rx) + Y / ry * np.arctan(X / ry)) / (2 * np.pi)
    computed = polygon_form_factor(np.zeros((1, 3)), np.array([[0.0, 1, 0]]), rectangle)
    assert abs(computed[0] - expected) < ROUNDING


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 2, 1, 0], [2, 3, 0, 1]])
def test_the_order_of_the_corners_does_not_matter(order):
    x, n = elements(2, 50)
    first = polygon_form_factor(x, n, WALL)
    assert np.abs(polygon_form_factor(x, n, WALL[order]) - first).max() < ROUNDING


def test_an_element_in_the_plane_of_the_polygon_receives_nothing():
    x = np.array([[3.0, 1, 0], [-2, 0, 0]])
    n = np.array([[0.0, 0, 1], [0, 1, 0]])
    assert np.array_equal(polygon_form_factor(x, n, WALL), [0.0, 0.0])


# ---------------------------------------------------------------- scenes


def reflected(scene, lit, x, n, floor, wall):
    """Radiance of a diffuse point that a sunlit diffuse parallelogram lights."""
    (sun,) = scene.suns
    corners = world_corners(lit).reshape(-1, 3)
    corner, u, v = corners[0], corners[1] - corners[0], corners[5] - corners[0]
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    irradiance = np.array(sun.irradiance) * abs(normal @ sun.direction)
    # Never exactly upright, so that the horizon meets every side's line somewhere.
    share, error = form_factor(x, n + 1e-13, corner, u, v)
    color = np.multiply(floor, wall) * irradiance / np.pi
    return share * color, error * color


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("sunlit-wall", sunlit_wall_indirect),
        ("parallel-plates", parallel_plates_indirect),
    ],
)
def test_answer_is_the_rendering_equation_of_the_scene(name, answer):
    """Geometry, sun and reflectances come from the scene, not from the answer."""
    scene = find_scene(name)
    lower, upper = scene.meshes
    world = world_of(scene, 16)
    seen = what_is_seen(world)
    # A step before the surface, which is 2⁻¹⁹ of a scene some metres wide.
    computed = answer(seen.position, seen.normal)
    on_lower = np.flatnonzero(seen.hit & (seen.primitive < 2))
    assert len(on_lower) > 30
    others = np.setdiff1d(np.arange(len(seen)), on_lower)
    assert not computed[others].any()
    for i in on_lower[:: len(on_lower) // 6]:
        expected, error = reflected(
            scene,
            upper,
            seen.position[i],
            seen.normal[i],
            lower.material.reflectance,
            upper.material.reflectance,
        )
        assert (np.abs(computed[i] - expected) <= error + ROUNDING * 10).all()


def test_the_polygons_are_those_of_the_scenes():
    for name, polygon in (("sunlit-wall", WALL), ("parallel-plates", UPPER_PLATE)):
        corners = world_corners(find_scene(name).meshes[1]).reshape(-1, 3)
        assert set(map(tuple, polygon)) == set(map(tuple, corners))


def test_furnace_solves_its_own_equation():
    """L = e + ρ ∫ L cos θ / π dω: the integral of cos θ / π, by quadrature, is 1."""
    hemisphere, error = quad(lambda t: 2 * np.cos(t) * np.sin(t), 0, np.pi / 2)
    for k in range(6):
        shallow, deep = sphere_furnace(k)[2], sphere_furnace(k + 1)[2]
        assert abs(deep - (EMISSION + ALBEDO * shallow * hemisphere)) < 10 * error
    direct, indirect, full = sphere_furnace(3)
    assert full == direct + indirect
    assert sphere_furnace(0)[1] == 0


@pytest.mark.parametrize("tilt", [0.0, 0.4, 1.3])
def test_half_lit_sphere_reflects_half_a_unit(tilt):
    """From the south pole, over the part of the sphere with y above a tilted equator.

    The light in the centre gives the irradiance I everywhere (radius 1); what the grey
    half reflects reaches the pole by cos θ cos θ' / d² = 1 / 4, wherever it comes from.
    """
    lit = ALBEDO * INTENSITY / np.pi

    def integrand(phi, theta):
        y = np.array(
            [np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)]
        )
        d = y - np.array([0.0, -1.0, 0.0])
        cosines = (d[1]) * (d @ y) / (d @ d)
        return lit * cosines / (d @ d) * np.sin(theta)

    # The grey half, a hemisphere about (sin tilt, cos tilt, 0): its azimuths at theta.
    def widest(theta):
        if tilt == 0.0:
            return np.pi if theta < np.pi / 2 else 0.0
        edge = -np.cos(theta) * np.cos(tilt) / (np.sin(theta) * np.sin(tilt))
        return np.arccos(np.clip(edge, -1.0, 1.0))

    upper = np.pi / 2 if tilt == 0.0 else np.pi - 1e-9
    half, error = dblquad(
        integrand, 1e-9, upper, lambda t: -widest(t), widest, epsabs=1e-8, epsrel=1e-8
    )
    unit, mean = half_lit_sphere()
    # 1e-8 for each of at most π wide inner integrals, and for the caps cut off.
    assert abs(ALBEDO / np.pi * half - mean) < error + 4e-8
    assert unit == 2 * mean
