"""Metal: microfacets, or a smooth mirror."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    normalize,
    vectors,
)
from restir_gi.reference.numerics.frames import normal_frames, to_world
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.scene.materials.coat import specular_lobe
from restir_gi.reference.scene.materials.fresnel import (
    fresnel_conductor,
    fresnel_schlick,
)
from restir_gi.reference.scene.materials.microfacet import reflect
from restir_gi.reference.scene.materials.parameters import MaterialTable, lit_cosine
from restir_gi.reference.scene.surface import SurfacePoints


def reflectance(table: MaterialTable, points: SurfacePoints, cos: Scalars) -> Vec3s:
    """Fresnel term times the material's colour.

    Parameters
    ----------
    points : SurfacePoints; N points on conductors
    cos : (N,) float64; cosine of the light with the (microfacet) normal, 0 to 1

    Returns
    -------
    (N, 3) float64; the colour alone where the material has no Fresnel term
    """
    value = points.color
    eta, schlick = table.eta[points.material], table.schlick[points.material]
    has_index = eta[:, 0] > 0
    if has_index.any():
        fresnel = fresnel_conductor(cos, eta, table.k[points.material])
        value = np.where(has_index[:, None], value * fresnel, value)
    if schlick.any():
        fitted = fresnel_schlick(cos, points.color)
        value = np.where(schlick[:, None], fitted, value)
    return value


def scattering(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """Reflection f cos θ_i = F D G1(wi) G1(wo) / (4 cos θ_o) of a rough conductor.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N, 3) float64, 1/sr; 0 below the surface [Walter07, Eq. 20]
    """
    h = normalize(points.wo + wi)
    cos_o = np.maximum(dot(points.shading, points.wo), 0.0)
    cos_d = np.clip(dot(wi, h), 0.0, 1.0)
    cos_i = lit_cosine(table, points, wi)
    facets = table.facets(points.material)
    lobe = specular_lobe(cos_i, cos_o, dot(points.shading, h), facets)
    return reflectance(table, points, cos_d) * lobe[:, None]


def pdf_reflected(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Scalars:
    """Density of :func:`sample_reflected`, D(h) / (4 cos θ_o) times what is shown.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N,) float64, 1/sr; 0 where nothing is reflected
    """
    h = normalize(points.wo + wi)
    cos_o = dot(points.shading, points.wo)
    cos_h, facets = dot(points.shading, h), table.facets(points.material)
    seen = facets.density(cos_h) * facets.shown(cos_h, cos_o, dot(points.wo, h))
    possible = (lit_cosine(table, points, wi) > 0) & (cos_o > 0)
    return divide_or_zero(np.where(possible, seen, 0.0), 4.0 * np.abs(cos_o))


def sample_reflected(table: MaterialTable, points: SurfacePoints, u: Draw) -> Vec3s:
    """Mirror images of the viewer in visible microfacets.

    Parameters
    ----------
    u : four (N,) float64; lanes 0 to 2 are used

    Returns
    -------
    (N, 3) float64; unit vectors; some are below the surface, and then reflect nothing
    """
    return reflect(points.wo, sample_normal(table, points, u)[0])


def sample_normal(
    table: MaterialTable, points: SurfacePoints, u: Draw
) -> tuple[Vec3s, Scalars]:
    """Normals of microfacets, mostly those that the viewer sees.

    Parameters
    ----------
    u : four (N,) float64; lanes 0 to 2 are used

    Returns
    -------
    (N, 3), (N,) float64
        Unit vectors above the surface, in the world; and a number in [0, 1) that is
        left of lane 0.
    """
    n = points.shading
    tangent, bitangent = normal_frames(n)
    wo = points.wo
    local = vectors(dot(wo, tangent), dot(wo, bitangent), dot(wo, n))
    # A viewer below the shading normal sees no microfacet; lift it to keep the
    # arithmetic finite: the pdf is 0 there.
    local[:, 2] = np.maximum(local[:, 2], 1e-9)
    normals, left = table.facets(points.material).sample(local, u)
    return to_world(normals, n), left
