"""Known answers of the catalogue's scenes, as functions of what the camera sees."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Scalars,
    Vec3s,
    cross,
    divide_or_zero,
    dot,
    length,
)
from restir_gi.reference.scene.catalogue.spheres import ALBEDO, EMISSION, INTENSITY
from restir_gi.reference.scene.catalogue.walls import (
    FLOOR_REFLECTANCE,
    SUN,
    WALL_REFLECTANCE,
)

WALL = np.array([[-1.0, 0, 0], [1, 0, 0], [1, 2, 0], [-1, 2, 0]])
"""Corners of the sunlit wall, m."""

UPPER_PLATE = np.array([[-0.5, 1, -0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [-0.5, 1, 0.5]])
"""Corners of the upper of the two parallel plates, m."""

PLATE_COSINE = 0.5 / np.sqrt(1.25)
"""Of the sun with the upper plate."""


def polygon_form_factor(x: Vec3s, n: Vec3s, polygon: Vec3s) -> Scalars:
    """Share of the light that a surface element receives, F = ∫ cos θ dω / π.

    F = Σ Γ_i · n / 2π over the edges, where Γ_i is as long as the angle that edge i
    covers seen from x, and normal to the plane of edge and x.

    Lambert's formula [Howell10].  Not for elements that touch the edge.

    Parameters
    ----------
    x, n : (N, 3) float64, m and 1; elements, and their unit normals
    polygon : (K, 3) float64, m; corners of a convex polygon, in either order

    Returns
    -------
    (N,) float64
        0 to 1: what a polygon of radiance L sends is the irradiance π L F.  The part
        below the element's horizon is clipped away; 0 in the polygon's own plane.
    """
    corners = polygon[None] - x[:, None]
    height = np.stack([dot(n, corners[:, i]) for i in range(len(polygon))], axis=1)
    total = np.zeros(len(x))
    leave, enter = np.zeros_like(x), np.zeros_like(x)
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        a, b, h_a, h_b = corners[:, i], corners[:, j], height[:, i], height[:, j]
        # Where the edge crosses the horizon, it ends or begins there.
        share = divide_or_zero(h_a, h_a - h_b)[:, None]
        crossing = a + share * (b - a)
        sinks, rises = (h_a > 0) & (h_b <= 0), (h_a <= 0) & (h_b > 0)
        leave = np.where(sinks[:, None], crossing, leave)
        enter = np.where(rises[:, None], crossing, enter)
        start = np.where(rises[:, None], crossing, a)
        end = np.where(sinks[:, None], crossing, b)
        seen = (h_a > 0) | (h_b > 0)
        total += np.where(seen, dot(_edge_vector(start, end), n), 0.0)
    # The horizon itself closes what is left of the polygon.
    total += dot(_edge_vector(leave, enter), n)
    return np.abs(total) / (2.0 * np.pi)


def _edge_vector(a: Vec3s, b: Vec3s) -> Vec3s:
    normal = cross(a, b)
    size = length(normal)
    angle = np.arctan2(size, dot(a, b))
    vector: Vec3s = divide_or_zero(angle, size)[:, None] * normal
    return vector


def sunlit_wall_indirect(x: Vec3s, n: Vec3s) -> Vec3s:
    """Indirect light of the sunlit wall: ρ_floor ρ_wall E F(wall) / π on the floor.

    Parameters
    ----------
    x, n : (N, 3) float64, m and 1
        Visible points and their normals; 0 where nothing is seen.

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        One bounce, and exact for two, since the floor receives no sun; 0 on the wall,
        where that is true of one bounce only.
    """
    irradiance = np.multiply(SUN, WALL_REFLECTANCE)
    return _lit_by(WALL, irradiance, x, n)


def parallel_plates_indirect(x: Vec3s, n: Vec3s) -> Vec3s:
    """Indirect light of the parallel plates: ρ_lower ρ_upper E cos θ F(upper) / π.

    Parameters
    ----------
    x, n : (N, 3) float64, m and 1
        Visible points and their normals; 0 where nothing is seen.

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        One bounce, and exact for two, since the upper side of the lower plate receives
        no sun; 0 on the upper plate, where that is true of one bounce only.
    """
    irradiance = np.multiply(SUN, WALL_REFLECTANCE) * PLATE_COSINE
    return _lit_by(UPPER_PLATE, irradiance, x, n)


def _lit_by(polygon: Vec3s, exitance: Vec3s, x: Vec3s, n: Vec3s) -> Vec3s:
    lower = n[:, 1] > 0.5
    factor = np.zeros(len(x))
    factor[lower] = polygon_form_factor(x[lower], n[lower], polygon)
    color = np.multiply(FLOOR_REFLECTANCE, exitance) / np.pi
    light: Vec3s = factor[:, None] * color
    return light


def sphere_furnace(bounces: int) -> tuple[float, float, float]:
    """Light of the sphere furnace: Σ albedo^i · emission, the same in all pixels.

    Direct (i = 0 and 1), indirect (i = 2 to k + 1) and full light, W/(m² sr).

    Parameters
    ----------
    bounces : int; bounces k of indirect light, from 0
    """
    direct = EMISSION * (1.0 + ALBEDO)
    indirect = sum(EMISSION * ALBEDO**i for i in range(2, bounces + 2))
    return direct, indirect, direct + indirect


def half_lit_sphere() -> tuple[float, float]:
    """One-bounce indirect light of the half-lit sphere: the unit, and its mean.

    What a pixel shows whose samples all lie on the grey half, albedo² I / π; and its
    expectation, half of it.  With cosine-weighted samples and the target of Equation 9,
    a pixel that has seen M independent samples shows n / M units, where n is
    Binomial(M, 1/2), whatever is reused.
    """
    unit = ALBEDO**2 * INTENSITY / np.pi
    return unit, unit / 2.0
