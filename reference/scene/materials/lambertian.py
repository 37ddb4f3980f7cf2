"""Lambertian reflection: f = ρ / π."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.frames import to_world
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.numerics.sampling import (
    pdf_cosine_hemisphere,
    sample_cosine_hemisphere,
)
from restir_gi.reference.scene.materials.parameters import MaterialTable, lit_cosine
from restir_gi.reference.scene.surface import SurfacePoints


def scattering(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """Reflection f cos θ_i = ρ cos θ_i / π, (N, 3) float64, 1/sr; 0 below the surface.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light
    """
    reflected: Vec3s = points.color * (lit_cosine(table, points, wi) / np.pi)[:, None]
    return reflected


def pdf(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Scalars:
    """Density of :func:`sample`, cos θ_i / π.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N,) float64, 1/sr; 0 where nothing is reflected
    """
    return pdf_cosine_hemisphere(lit_cosine(table, points, wi))


def sample(points: SurfacePoints, u: Draw) -> Vec3s:
    """Directions with density cos θ_i / π about the shading normal.

    Parameters
    ----------
    u : four (N,) float64; lanes 1 and 2 are used

    Returns
    -------
    (N, 3) float64; unit vectors
    """
    return to_world(sample_cosine_hemisphere(u[1], u[2]), points.shading)
