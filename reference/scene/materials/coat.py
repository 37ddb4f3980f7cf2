"""Light through a clear coat: what it reflects, what it lets pass, what it keeps in."""

import functools

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, divide_or_zero, vectors
from restir_gi.reference.scene.materials.facets import Facets
from restir_gi.reference.scene.materials.fresnel import fresnel_dielectric
from restir_gi.reference.scene.materials.kinds import Distribution
from restir_gi.reference.scene.materials.microfacet import (
    reflect,
    sample_visible_normal,
)

NODES = 64
"""Cosines at which the transmittance of a coat is tabulated."""


def directional_albedo(
    cos_o: Scalars, alpha: float, ior: float, distribution: Distribution = "ggx"
) -> tuple[Scalars, Scalars]:
    """Shares of the light from a direction that a coat reflects and lets pass.

    ∫ F(wo·h) G1(wi) p(h) dh and ∫ (1 - F(wo·h)) G1(wt) p(h) dh over the visible
    normals, wi reflected and wt refracted at h, by a midpoint rule on the unit square,
    64 x 64: of [Heitz18] for GGX, of all normals with their areas for Beckmann.

    Parameters
    ----------
    cos_o : (N,) float; cosines of incidence, 0 to 1
    alpha : float; width; 0 is smooth
    ior : float; index of refraction behind the coat over that before it

    Returns
    -------
    (N,), (N,) float
        Reflected and transmitted; what single scattering loses between the
        microfacets is in neither.
    """
    cos_o = np.maximum(cos_o, 1e-6)
    if alpha == 0:
        fresnel, _ = fresnel_dielectric(cos_o, np.full_like(cos_o, ior))
        return fresnel, 1.0 - fresnel
    rows = [_mean_albedo(float(c), alpha, ior, distribution) for c in cos_o]
    reflected, transmitted = np.array(rows).T
    return reflected, transmitted


def _mean_albedo(
    cos_o: float, alpha: float, ior: float, distribution: Distribution
) -> tuple[float, float]:
    grid = (np.arange(64) + 0.5) / 64
    u1, u2 = (u.ravel() for u in np.meshgrid(grid, grid))
    wo = np.broadcast_to([np.sqrt(1 - cos_o * cos_o), 0.0, cos_o], (len(u1), 3))
    width = np.full_like(u1, alpha)
    facets = Facets(width, None if distribution == "ggx" else np.ones(len(u1), bool))
    if distribution == "ggx":
        h = sample_visible_normal(wo, width, u1, u2)
    else:
        h = _beckmann_normals(alpha, u1, u2)
    cos_d = np.clip(wo[:, 0] * h[:, 0] + wo[:, 2] * h[:, 2], 0.0, 1.0)
    fresnel, cos_t = fresnel_dielectric(cos_d, np.full_like(u1, ior))
    up = reflect(wo, h)[:, 2]
    down = -(h[:, 2] * (cos_d / ior - cos_t) - wo[:, 2] / ior)
    reflected = fresnel * facets.masking(up)
    transmitted = (1.0 - fresnel) * facets.masking(down)
    if distribution == "ggx":
        return float(np.mean(reflected)), float(np.mean(transmitted))
    # Each normal counts as the area of its microfacets that the viewer sees.
    area = cos_d / h[:, 2]
    area = area / area.sum()
    return float(np.sum(area * reflected)), float(np.sum(area * transmitted))


def _beckmann_normals(alpha: float, u1: Scalars, u2: Scalars) -> Vec3s:
    slope = alpha * np.sqrt(-np.log1p(-u1))
    phi, cos_h = 2.0 * np.pi * u2, 1.0 / np.sqrt(1.0 + slope * slope)
    across = slope * cos_h
    return vectors(across * np.cos(phi), across * np.sin(phi), cos_h)


@functools.cache
def transmittance_table(
    alpha: float, ior: float, distribution: Distribution = "ggx"
) -> tuple[float, ...]:
    """What a coat lets pass, at evenly spaced cosines from 0 to 1.

    Parameters
    ----------
    alpha : float; width; 0 is smooth
    ior : float; index of refraction of the coat over that of the outside
    """
    nodes = np.linspace(0, 1, NODES)
    return tuple(directional_albedo(nodes, alpha, ior, distribution)[1])


@functools.cache
def internal_reflectance(
    alpha: float, ior: float, distribution: Distribution = "ggx"
) -> float:
    """Share of diffuse light from below that a coat sends back, 2 ∫ E(μ) μ dμ.

    Seen from inside the index is 1 / ior; most of it is total reflection.

    Parameters
    ----------
    alpha : float; width; 0 is smooth
    ior : float; index of refraction of the coat over that of the outside

    Notes
    -----
    A smooth coat's comes from the outside, by reciprocity 1 - K = (1 - K_outside) / η²:
    there the integrand has no kink at a critical angle.

    A rough coat's is the plain mean over the ``NODES`` cosines of the table, 1.5 %
    below the integral, because Mitsuba defines it so: with the integral, images of
    rough coats could not be compared.
    """
    if alpha > 0:
        mu = np.linspace(0, 1, NODES)
        inside, _ = directional_albedo(mu, alpha, 1.0 / ior, distribution)
        return float(2.0 * np.mean(inside * mu))
    nodes, weights = np.polynomial.legendre.leggauss(128)
    mu = 0.5 * (nodes + 1.0)
    outside, _ = directional_albedo(mu, alpha, ior)
    return float(1.0 - (1.0 - np.sum(outside * mu * weights)) / ior**2)


def transmittance(cos: Scalars, table: Scalars) -> Scalars:
    """Transmittance between the tabulated cosines, linearly, (N,) float; 0 to 1.

    Parameters
    ----------
    cos : (N,) float; cosines, 0 to 1
    table : (N, NODES) or (NODES,) float; a table a row, or one for all
    """
    place = np.clip(cos, 0.0, 1.0) * (NODES - 1)
    left = np.minimum(place.astype(np.int64), NODES - 2)
    share = place - left
    if table.ndim == 1:
        below, above = table[left], table[left + 1]
    else:
        rows = np.arange(len(cos))
        below, above = table[rows, left], table[rows, left + 1]
    between: Scalars = below + share * (above - below)
    return between


def base_scattering(color: Vec3s, keep: Scalars, nonlinear: Scalars) -> Vec3s:
    """Series of bounces between the base and the coat, ρ / (1 - ρ K) or ρ / (1 - K).

    Parameters
    ----------
    color : (N, 3) float; reflectance ρ of the base
    keep : (N,) float; internal reflectance K of the coat
    nonlinear : (N,) bool; whether the base colours every bounce

    Returns
    -------
    (N, 3) float; factor on what enters
    """
    colored = np.where(nonlinear[:, None], color, 1.0)
    return divide_or_zero(color, 1.0 - colored * keep[:, None])


def specular_lobe(
    cos_i: Scalars, cos_o: Scalars, cos_h: Scalars, facets: Facets
) -> Scalars:
    """Reflection without its Fresnel term, times cos θ_i: D G1 G1 / (4 cos θ_o).

    Parameters
    ----------
    cos_i, cos_o, cos_h : (N,) float
        Cosines with the surface normal of light, viewer and the vector half between.

    Returns
    -------
    (N,) float, 1/sr; 0 where the light or the viewer is below the surface
    """
    shape = facets.density(cos_h) * facets.masking(cos_i) * facets.masking(cos_o)
    above = (cos_i > 0) & (cos_o > 0)
    return divide_or_zero(np.where(above, shape, 0.0), 4.0 * cos_o)
