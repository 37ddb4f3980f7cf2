"""Rough boundary between clear media: microfacets that reflect and refract."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    normalize,
)
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.scene.materials.conductor import sample_normal
from restir_gi.reference.scene.materials.dielectric import relative_index
from restir_gi.reference.scene.materials.facets import Facets
from restir_gi.reference.scene.materials.fresnel import fresnel_dielectric
from restir_gi.reference.scene.materials.microfacet import reflect
from restir_gi.reference.scene.materials.parameters import MaterialTable
from restir_gi.reference.scene.surface import SurfacePoints


@dataclass(frozen=True, slots=True)
class _Crossing:
    """How light passes from wi to wo by way of one microfacet, N rows."""

    facets: Facets
    cos_o: Scalars
    cos_i: Scalars
    cos_h: Scalars
    cos_d: Scalars
    share: Scalars
    possible: Masks


def _crossing(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> _Crossing:
    """Cosines, and per area of microfacets the density of wi over that of h.

    ``share`` is the Fresnel term times |∂h/∂wi| max(0, wo·h): F / 4 for what is
    reflected and (1 - F) η² (wo·h) |wi·h| / (wo·h + η wi·h)² for what is refracted.
    """
    n, wo = points.shading, points.wo
    eta = relative_index(table, points)
    cos_o, cos_i = dot(n, wo), dot(n, wi)
    # The geometric normal decides on which side the light is, with the shading normal.
    aside = dot(points.normal, wi)
    reflects, refracts = (cos_i > 0) & (aside > 0), (cos_i < 0) & (aside < 0)
    h = normalize(wo + wi * np.where(reflects, 1.0, eta)[:, None])
    h = h * np.where(dot(n, h) < 0, -1.0, 1.0)[:, None]
    cos_d, cos_e = dot(wo, h), dot(wi, h)
    front = (cos_o > 0) & (cos_d > 0)
    possible = front & ((reflects & (cos_e > 0)) | (refracts & (cos_e < 0)))
    fresnel, _ = fresnel_dielectric(np.clip(cos_d, 0.0, 1.0), eta)
    stretch = cos_d + eta * cos_e
    spread = eta * eta * np.abs(cos_d * cos_e)
    spread = divide_or_zero(spread, stretch * stretch)
    share = np.where(reflects, 0.25 * fresnel, (1.0 - fresnel) * spread)
    facets = table.facets(points.material)
    return _Crossing(facets, cos_o, np.abs(cos_i), dot(n, h), cos_d, share, possible)


def scattering(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """Reflection and refraction f |cos θ_i|, of radiance.

    [Walter07], refraction divided by η² since radiance spreads over
    another solid angle [Veach97, Eq. 5.2].

    Parameters
    ----------
    points : SurfacePoints; N points on rough dielectrics
    wi : (N, 3) float64; unit directions to the light, to either side

    Returns
    -------
    (N, 3) float64, 1/sr; 0 where shading and geometric normal do not agree on the side
    """
    p, eta = _crossing(table, points, wi), relative_index(table, points)
    lobe = p.facets.density(p.cos_h)
    lobe = lobe * p.facets.masking(p.cos_i) * p.facets.masking(p.cos_o) * p.share
    lobe = np.where(dot(points.shading, wi) < 0, lobe / (eta * eta), lobe)
    value = divide_or_zero(np.where(p.possible, lobe, 0.0), np.abs(p.cos_o))
    return np.repeat(value[:, None], 3, axis=1)


def pdf(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Scalars:
    """Density of :func:`sample`, (N,) float64, 1/sr; 0 where nothing is scattered.

    [Walter07]: that of the microfacet's normal times |∂h/∂wi|.

    Parameters
    ----------
    points : SurfacePoints; N points on rough dielectrics
    wi : (N, 3) float64; unit directions to the light, to either side
    """
    p = _crossing(table, points, wi)
    lobe = p.facets.density(p.cos_h) * p.facets.shown(p.cos_h, p.cos_o, p.cos_d)
    return divide_or_zero(np.where(p.possible, lobe * p.share, 0.0), np.abs(p.cos_o))


def sample(
    table: MaterialTable, points: SurfacePoints, u: Draw
) -> tuple[Vec3s, Vec3s, Scalars]:
    """Reflect in a microfacet with the probability of its Fresnel term, else refract.

    Parameters
    ----------
    points : SurfacePoints; N points on rough dielectrics
    u : four (N,) float64
        Lanes 0 to 2 choose the microfacet, and what is left of lane 0 decides.

    Returns
    -------
    (N, 3), (N, 3), (N,)
        Unit directions, weights and densities of ``BsdfSamples``.  Both are 0 where
        light is reflected to below the surface or refracted to above it, and lost:
        :func:`pdf` is that of the other lobe there.
    """
    (h, left), eta = sample_normal(table, points, u), relative_index(table, points)
    cos_d = np.clip(dot(points.wo, h), 0.0, 1.0)
    fresnel, cos_t = fresnel_dielectric(cos_d, eta)
    refracted = h * (cos_d / eta - cos_t)[:, None] - points.wo / eta[:, None]
    reflects = left < fresnel
    wi = np.where(reflects[:, None], reflect(points.wo, h), refracted)
    wi = normalize(wi)
    kept = (dot(points.shading, wi) > 0) == reflects
    density = np.where(kept, pdf(table, points, wi), 0.0)
    weight = divide_or_zero(scattering(table, points, wi), density[:, None])
    return wi, weight, density
