"""Smooth boundary between clear media."""

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, dot, vectors
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.scene.materials.fresnel import fresnel_dielectric
from restir_gi.reference.scene.materials.microfacet import reflect
from restir_gi.reference.scene.materials.parameters import MaterialTable
from restir_gi.reference.scene.surface import SurfacePoints


def relative_index(table: MaterialTable, points: SurfacePoints) -> Scalars:
    """Index of refraction behind surfaces, as their viewers see them, over that before.

    Parameters
    ----------
    points : SurfacePoints; N points on dielectrics

    Returns
    -------
    (N,) float64; the inverse on backs
    """
    ior = table.ior[points.material]
    return np.where(points.front, ior, 1.0 / ior)


def sample(
    table: MaterialTable, points: SurfacePoints, u: Draw
) -> tuple[Vec3s, Vec3s, Scalars, Masks]:
    """Reflect with the probability of the Fresnel term, else refract.

    Parameters
    ----------
    points : SurfacePoints; N points on dielectrics
    u : four (N,) float64; lane 0 decides

    Returns
    -------
    (N, 3), (N, 3), (N,), (N,)
        Fields of ``BsdfSamples``.  Refracted radiance is divided by the square of the
        relative index, since it spreads over another solid angle [Veach97, Eq. 5.2].
    """
    n, wo = points.shading, points.wo
    eta = relative_index(table, points)
    cos_o = np.clip(dot(n, wo), 0.0, 1.0)
    reflectance, cos_t = fresnel_dielectric(cos_o, eta)
    refracted = n * (cos_o / eta - cos_t)[:, None] - wo / eta[:, None]
    reflects = u[0] < reflectance
    wi = np.where(reflects[:, None], reflect(wo, n), refracted)
    weight = np.where(reflects, 1.0, 1.0 / (eta * eta))
    size = len(points)
    weights = vectors(weight, weight, weight)
    return wi, weights, np.zeros(size), np.ones(size, bool)
