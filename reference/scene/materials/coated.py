"""Diffuse base under a clear coat, rough or smooth."""

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
from restir_gi.reference.numerics.sampling import left_of, pdf_cosine_hemisphere
from restir_gi.reference.scene.materials import conductor, lambertian
from restir_gi.reference.scene.materials.coat import (
    base_scattering,
    specular_lobe,
    transmittance,
)
from restir_gi.reference.scene.materials.fresnel import fresnel_dielectric
from restir_gi.reference.scene.materials.microfacet import reflect
from restir_gi.reference.scene.materials.parameters import MaterialTable, lit_cosine
from restir_gi.reference.scene.surface import SurfacePoints


def base_reflection(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """What the base reflects through the coat, f cos θ_i.

    f = T(cos θ_i) T(cos θ_o) / (π η²) · ρ / (1 - ρ K), without ρ in the denominator
    where the material is linear.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N, 3) float64, 1/sr; 0 where the viewer or the light is below the surface
    """
    m = points.material
    cos_i = lit_cosine(table, points, wi)
    cos_o = np.maximum(dot(points.shading, points.wo), 0.0)
    through = transmittance(cos_i, table.transmittance[m])
    through = through * transmittance(cos_o, table.transmittance[m])
    factor = np.where(cos_o > 0, cos_i * through, 0.0) / (np.pi * table.ior[m] ** 2)
    base = base_scattering(points.color, table.keep[m], table.nonlinear[m])
    return base * factor[:, None]


def scattering(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """Reflection of base and rough coat together, f cos θ_i.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N, 3) float64, 1/sr; 0 below the surface
    """
    m = points.material
    h = normalize(points.wo + wi)
    fresnel, _ = fresnel_dielectric(np.clip(dot(wi, h), 0.0, 1.0), table.ior[m])
    cos_i = lit_cosine(table, points, wi)
    cos_o = np.maximum(dot(points.shading, points.wo), 0.0)
    lobe = specular_lobe(cos_i, cos_o, dot(points.shading, h), table.facets(m))
    coat: Vec3s = table.specular[m] * (fresnel * lobe)[:, None]
    return base_reflection(table, points, wi) + coat


def coat_probability(table: MaterialTable, points: SurfacePoints) -> Scalars:
    """Probability of drawing from the coat: its share of the albedo.

    Returns (N,) float64; between 0 and 1; 1 over a black base.
    """
    m = points.material
    cos_o = np.clip(dot(points.shading, points.wo), 0.0, 1.0)
    through = transmittance(cos_o, table.transmittance[m])
    coat = (1.0 - through) * table.specular[m].mean(axis=-1)
    base = through * points.color.mean(axis=-1)
    return divide_or_zero(coat, coat + base)


def pdf(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Scalars:
    """Density of :func:`sample`: both lobes, each times its probability.

    Parameters
    ----------
    table : MaterialTable; materials; the delta lobe of a smooth coat is left out
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N,) float64, 1/sr; 0 where nothing is reflected
    """
    probability = coat_probability(table, points)
    base = pdf_cosine_hemisphere(lit_cosine(table, points, wi))
    density = (1.0 - probability) * base
    if table.alpha[points.material].all():
        density = density + probability * conductor.pdf_reflected(table, points, wi)
    visible = dot(points.shading, points.wo) > 0
    return np.where(visible, density, 0.0)


def sample(table: MaterialTable, points: SurfacePoints, u: Draw) -> Vec3s:
    """Directions from the rough coat or from the base, (N, 3) float64; unit vectors.

    Parameters
    ----------
    points : SurfacePoints; N points on rough coats
    u : four (N,) float64
        Lane 0 picks the lobe, and what is left of it, 1 and 2 the direction.
    """
    probability = coat_probability(table, points)
    within = left_of(u[0], probability), *u[1:]
    return np.where(
        (u[0] < probability)[:, None],
        conductor.sample_reflected(table, points, within),
        lambertian.sample(points, u),
    )


def sample_smooth(
    table: MaterialTable, points: SurfacePoints, u: Draw
) -> tuple[Vec3s, Vec3s, Scalars, Masks]:
    """Mirror direction of a smooth coat, or a direction from its base.

    Parameters
    ----------
    points : SurfacePoints; N points on smooth coats
    u : four (N,) float64; lane 0 picks the lobe, 1 and 2 the direction

    Returns
    -------
    (N, 3), (N, 3), (N,), (N,); fields of ``BsdfSamples``
    """
    probability = coat_probability(table, points)
    from_coat = u[0] < probability
    wi_base = lambertian.sample(points, u)
    density = pdf(table, points, wi_base)
    base = divide_or_zero(base_reflection(table, points, wi_base), density[:, None])
    wi_coat, coat = reflect_in_coat(table, points)
    coat = divide_or_zero(coat, probability[:, None])
    wi = np.where(from_coat[:, None], wi_coat, wi_base)
    weight = np.where(from_coat[:, None], coat, base)
    return wi, weight, np.where(from_coat, 0.0, density), from_coat


def reflect_in_coat(table: MaterialTable, points: SurfacePoints) -> tuple[Vec3s, Vec3s]:
    """Mirror direction of a smooth coat and the share that it reflects.

    Parameters
    ----------
    points : SurfacePoints; N points on smooth coats

    Returns
    -------
    (N, 3), (N, 3) float64; unit directions; Fresnel term, 0 on black backs
    """
    m = points.material
    wi = reflect(points.wo, points.shading)
    cos_o = np.clip(dot(points.shading, points.wo), 0.0, 1.0)
    fresnel, _ = fresnel_dielectric(cos_o, table.ior[m])
    share = table.specular[m] * fresnel[:, None]
    lit = lit_cosine(table, points, wi) > 0
    return wi, np.where(lit[:, None], share, 0.0)
