"""Directions drawn from materials."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    zero_vectors,
)
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.scene.materials import (
    coated,
    conductor,
    dielectric,
    lambertian,
    rough_dielectric,
)
from restir_gi.reference.scene.materials.microfacet import reflect
from restir_gi.reference.scene.materials.parameters import (
    Kind,
    MaterialTable,
    lit_cosine,
)
from restir_gi.reference.scene.materials.table import by_kind
from restir_gi.reference.scene.surface import SurfacePoints

HAS_DELTA = (Kind.SMOOTH_CONDUCTOR, Kind.SMOOTH_COATED, Kind.DIELECTRIC)
"""Kinds that scatter into single directions, among others."""

APART = (*HAS_DELTA, Kind.ROUGH_DIELECTRIC)
"""Kinds of which some light is never reused: that of delta lobes, and all that rough
dielectrics scatter, to both sides."""


@dataclass(frozen=True, slots=True)
class BsdfSamples:
    """Directions drawn from materials, N rows.

    Attributes
    ----------
    wi : (N, 3) float64; unit directions to the light
    weight : (N, 3) float64
        f cos θ_i / pdf; for a delta lobe its albedo over the probability of the lobe.
    pdf : (N,) float64, 1/sr; 0 for a delta lobe
    delta : (N,) bool; drawn from a delta lobe
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    delta: Masks


def sample(table: MaterialTable, points: SurfacePoints, u: Draw) -> BsdfSamples:
    """Draw directions in proportion to what they reflect, as far as that is possible.

    Parameters
    ----------
    u : four (N,) float64; lane 0 picks the lobe, and with 1 and 2 the direction

    Returns
    -------
    BsdfSamples; weight 0 where the direction reflects nothing
    """
    if table.kinds == (Kind.LAMBERTIAN,):
        return _sample_kind(Kind.LAMBERTIAN, table, points, u)
    parts = [
        (rows, _sample_kind(kind, table, some, _rows_of(u, rows)))
        for kind, rows, some in by_kind(table, points)
    ]
    if not parts:
        return _sample_kind(Kind.LAMBERTIAN, table, points, u)
    size = len(points)
    wi, weight = zero_vectors(size), zero_vectors(size)
    density, delta = np.zeros(size), np.zeros(size, bool)
    for rows, part in parts:
        wi[rows], weight[rows] = part.wi, part.weight
        density[rows], delta[rows] = part.pdf, part.delta
    return BsdfSamples(wi, weight, density, delta)


def sample_apart(table: MaterialTable, points: SurfacePoints, u: Draw) -> BsdfSamples:
    """Draw directions of light that is never reused, and nothing where there is none.

    Parameters
    ----------
    u : four (N,) float64
        Lane 0 picks between reflection and refraction, and with 1 and 2 a microfacet.

    Returns
    -------
    BsdfSamples
        From the delta lobe alone where there is one; weight 0 on materials that are
        not among ``APART``.
    """
    size = len(points)
    wi, weight = zero_vectors(size), zero_vectors(size)
    density, delta = np.zeros(size), np.zeros(size, bool)
    for kind, rows, some in by_kind(table, points):
        if kind not in APART:
            continue
        if kind == Kind.SMOOTH_COATED:
            wi[rows], weight[rows] = coated.reflect_in_coat(table, some)
            delta[rows] = True
        else:
            part = _sample_kind(kind, table, some, _rows_of(u, rows))
            wi[rows], weight[rows] = part.wi, part.weight
            density[rows], delta[rows] = part.pdf, part.delta
    return BsdfSamples(wi, weight, density, delta)


def _sample_kind(
    kind: Kind, table: MaterialTable, points: SurfacePoints, u: Draw
) -> BsdfSamples:
    if kind == Kind.SMOOTH_CONDUCTOR:
        return _mirror(table, points)
    if kind == Kind.DIELECTRIC:
        return BsdfSamples(*dielectric.sample(table, points, u))
    if kind == Kind.SMOOTH_COATED:
        return BsdfSamples(*coated.sample_smooth(table, points, u))
    if kind == Kind.ROUGH_DIELECTRIC:
        drawn = rough_dielectric.sample(table, points, u)
        return BsdfSamples(*drawn, np.zeros(len(points), bool))
    if kind == Kind.LAMBERTIAN:
        wi = lambertian.sample(points, u)
        density = lambertian.pdf(table, points, wi)
        # ρ exactly, not ρ cos / cos: noise-free scenes stay noise-free.
        weight = np.where((density > 0)[:, None], points.color, 0.0)
        return BsdfSamples(wi, weight, density, np.zeros(len(points), bool))
    if kind == Kind.ROUGH_CONDUCTOR:
        wi = conductor.sample_reflected(table, points, u)
        density = conductor.pdf_reflected(table, points, wi)
        value = conductor.scattering(table, points, wi)
    else:
        wi = coated.sample(table, points, u)
        density = coated.pdf(table, points, wi)
        value = coated.scattering(table, points, wi)
    weight = divide_or_zero(value, density[:, None])
    return BsdfSamples(wi, weight, density, np.zeros(len(points), bool))


def _mirror(table: MaterialTable, points: SurfacePoints) -> BsdfSamples:
    wi = reflect(points.wo, points.shading)
    cos = np.clip(dot(points.shading, points.wo), 0.0, 1.0)
    weight = conductor.reflectance(table, points, cos)
    weight = np.where((lit_cosine(table, points, wi) > 0)[:, None], weight, 0.0)
    size = len(points)
    return BsdfSamples(wi, weight, np.zeros(size), np.ones(size, bool))


def _rows_of(u: Draw, rows: Indices) -> Draw:
    return u[0][rows], u[1][rows], u[2][rows], u[3][rows]
