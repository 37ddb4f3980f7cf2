"""Light through a clear coat: what it reflects, what it lets pass, what it keeps in."""

import functools

import numpy as np

from reference.arrays import Scalars, Vec3s, divide_or_zero
from reference.scene.materials.fresnel import fresnel_dielectric
from reference.scene.materials.microfacet import (
    ggx_density,
    reflect,
    sample_visible_normal,
    smith_g1,
)

NODES = 64
"""Cosines at which the transmittance of a coat is tabulated."""


def directional_albedo(
    cos_o: Scalars, alpha: float, ior: float
) -> tuple[Scalars, Scalars]:
    """Shares of the light from a direction that a coat reflects and lets pass.

    Parameters
    ----------
    cos_o : (N,) float
        Cosines of incidence, 0 to 1.
    alpha : float
        GGX width; 0 is smooth.
    ior : float
        Index of refraction behind the coat over that before it.

    Returns
    -------
    (N,), (N,) float
        Reflected and transmitted; what single scattering loses between the
        microfacets is in neither.

    Notes
    -----
    ∫ F(wo·h) G1(wi) p(h) dh and ∫ (1 - F(wo·h)) G1(wt) p(h) dh over the visible
    normals, wi reflected and wt refracted at h, by a midpoint rule on the unit square
    of [Heitz18], 64 x 64.
    """
    cos_o = np.maximum(cos_o, 1e-6)
    if alpha == 0:
        fresnel, _ = fresnel_dielectric(cos_o, np.full_like(cos_o, ior))
        return fresnel, 1.0 - fresnel
    grid = (np.arange(64) + 0.5) / 64
    u1, u2 = (u.ravel() for u in np.meshgrid(grid, grid))
    means = [_mean_albedo(float(c), alpha, ior, u1, u2) for c in cos_o]
    reflected, transmitted = np.array(means).T
    return reflected, transmitted


def _mean_albedo(
    cos_o: float, alpha: float, ior: float, u1: Scalars, u2: Scalars
) -> tuple[float, float]:
    wo = np.broadcast_to([np.sqrt(1 - cos_o * cos_o), 0.0, cos_o], (len(u1), 3))
    width = np.full_like(u1, alpha)
    h = sample_visible_normal(wo, width, u1, u2)
    cos_d = np.clip(wo[:, 0] * h[:, 0] + wo[:, 2] * h[:, 2], 0.0, 1.0)
    fresnel, cos_t = fresnel_dielectric(cos_d, np.full_like(u1, ior))
    up = reflect(wo, h)[:, 2]
    down = -(h[:, 2] * (cos_d / ior - cos_t) - wo[:, 2] / ior)
    reflected = np.mean(fresnel * smith_g1(up, width))
    transmitted = np.mean((1.0 - fresnel) * smith_g1(down, width))
    return float(reflected), float(transmitted)


@functools.cache
def transmittance_table(alpha: float, ior: float) -> tuple[float, ...]:
    """What a coat lets pass, at evenly spaced cosines from 0 to 1.

    Parameters
    ----------
    alpha : float
        GGX width; 0 is smooth.
    ior : float
        Index of refraction of the coat over that of the outside.

    Returns
    -------
    tuple of float
        ``NODES`` values.
    """
    return tuple(directional_albedo(np.linspace(0, 1, NODES), alpha, ior)[1])


@functools.cache
def internal_reflectance(alpha: float, ior: float) -> float:
    """Share of diffuse light from below that a coat sends back, 2 ∫ E(μ) μ dμ.

    Parameters
    ----------
    alpha : float
        GGX width; 0 is smooth.
    ior : float
        Index of refraction of the coat over that of the outside.

    Returns
    -------
    float
        Seen from inside the index is 1 / ior; most of it is total reflection.

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
        return float(2.0 * np.mean(directional_albedo(mu, alpha, 1.0 / ior)[0] * mu))
    nodes, weights = np.polynomial.legendre.leggauss(128)
    mu = 0.5 * (nodes + 1.0)
    outside, _ = directional_albedo(mu, alpha, ior)
    return float(1.0 - (1.0 - np.sum(outside * mu * weights)) / ior**2)


def transmittance(cos: Scalars, table: Scalars) -> Scalars:
    """Transmittance between the tabulated cosines, linearly.

    Parameters
    ----------
    cos : (N,) float
        Cosines, 0 to 1.
    table : (N, NODES) or (NODES,) float
        A table a row, or one for all.

    Returns
    -------
    (N,) float
        0 to 1.
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
    color : (N, 3) float
        Reflectance ρ of the base.
    keep : (N,) float
        Internal reflectance K of the coat.
    nonlinear : (N,) bool
        Whether the base colours every bounce.

    Returns
    -------
    (N, 3) float
        Factor on what enters.
    """
    colored = np.where(nonlinear[:, None], color, 1.0)
    return divide_or_zero(color, 1.0 - colored * keep[:, None])


def specular_lobe(
    cos_i: Scalars, cos_o: Scalars, cos_h: Scalars, alpha: Scalars
) -> Scalars:
    """GGX reflection without its Fresnel term, times cos θ_i: D G1 G1 / (4 cos θ_o).

    Parameters
    ----------
    cos_i, cos_o, cos_h : (N,) float
        Cosines with the surface normal of light, viewer and the vector half between.
    alpha : (N,) float
        Width.

    Returns
    -------
    (N,) float, 1/sr
        0 where the light or the viewer is below the surface.
    """
    shape = ggx_density(cos_h, alpha) * smith_g1(cos_i, alpha) * smith_g1(cos_o, alpha)
    above = (cos_i > 0) & (cos_o > 0)
    return divide_or_zero(np.where(above, shape, 0.0), 4.0 * cos_o)
