"""All materials behind three questions: how much, how likely, and where to."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reference.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    zero_vectors,
)
from reference.records import take
from reference.rng import Draw
from reference.scene.materials import coated, conductor, dielectric, lambertian
from reference.scene.materials.microfacet import reflect
from reference.scene.materials.parameters import Kind, MaterialTable, lit_cosine
from reference.scene.surface import SurfacePoints

DELTA_ONLY = (Kind.SMOOTH_CONDUCTOR, Kind.DIELECTRIC)
"""Kinds that scatter into single directions alone."""

HAS_DELTA = (Kind.SMOOTH_CONDUCTOR, Kind.SMOOTH_COATED, Kind.DIELECTRIC)
"""Kinds that scatter into single directions, among others."""


@dataclass(frozen=True, slots=True)
class BsdfSamples:
    """Directions drawn from materials, N rows.

    Attributes
    ----------
    wi : (N, 3) float64
        Unit directions to the light.
    weight : (N, 3) float64
        f cos θ_i / pdf; for a delta lobe its albedo over the probability of the lobe.
    pdf : (N,) float64, 1/sr
        0 for a delta lobe.
    delta : (N,) bool
        Drawn from a delta lobe.
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    delta: Masks


def by_kind(
    table: MaterialTable, points: SurfacePoints
) -> Iterator[tuple[Kind, Indices, SurfacePoints]]:
    """Split points by the kind of their material, so that each is paid for once.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points.

    Yields
    ------
    Kind, (K,) int, SurfacePoints
        Kind, rows, and the points of these rows.
    """
    kind = table.kind[points.material]
    for k in table.kinds:
        rows = np.flatnonzero(kind == k)
        if len(rows):
            yield k, rows, take(points, rows)


def can_scatter(table: MaterialTable, points: SurfacePoints) -> Masks:
    """Whether a point scatters any light at all.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points.

    Returns
    -------
    (N,) bool
        False for misses and for black surfaces without a coat.
    """
    able = points.color.any(axis=1)
    coats = (Kind.ROUGH_COATED, Kind.SMOOTH_COATED)
    if any(kind in coats for kind in table.kinds):
        able = able | np.isin(table.kind[points.material], coats)
    scatters: Masks = points.hit & able
    return scatters


def scattering(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """Reflected share f(wo, wi) cos θ_i of all lobes but the delta ones.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points, with their viewers ``wo``.
    wi : (N, 3) float64
        Unit directions to the light.

    Returns
    -------
    (N, 3) float64, 1/sr
        0 below the surface, on black backs, for misses and for delta lobes.
    """
    functions = {
        Kind.LAMBERTIAN: lambertian.scattering,
        Kind.ROUGH_CONDUCTOR: conductor.scattering,
        Kind.ROUGH_COATED: coated.scattering,
        Kind.SMOOTH_COATED: coated.base_reflection,
    }
    if table.kinds == (Kind.LAMBERTIAN,):
        return lambertian.scattering(table, points, wi)
    value = zero_vectors(len(wi))
    for kind, rows, some in by_kind(table, points):
        if kind in functions:
            value[rows] = functions[kind](table, some, take(wi, rows))
    return value


def pdf(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Scalars:
    """Density with which :func:`sample` draws a direction, delta lobes apart.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points.
    wi : (N, 3) float64
        Unit directions to the light.

    Returns
    -------
    (N,) float64, 1/sr
        Summed over the lobes, each times its probability; 0 where nothing is
        reflected.
    """
    functions = {
        Kind.LAMBERTIAN: lambertian.pdf,
        Kind.ROUGH_CONDUCTOR: conductor.pdf_reflected,
        Kind.ROUGH_COATED: coated.pdf,
        Kind.SMOOTH_COATED: coated.pdf,
    }
    if table.kinds == (Kind.LAMBERTIAN,):
        return lambertian.pdf(table, points, wi)
    value = np.zeros(len(wi))
    for kind, rows, some in by_kind(table, points):
        if kind in functions:
            value[rows] = functions[kind](table, some, take(wi, rows))
    return value


def sample(table: MaterialTable, points: SurfacePoints, u: Draw) -> BsdfSamples:
    """Draw directions in proportion to what they reflect, as far as that is possible.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points.
    u : four (N,) float64
        Lane 0 picks the lobe, 1 and 2 the direction.

    Returns
    -------
    BsdfSamples
        Weight 0 where the direction reflects nothing.
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


def sample_delta(table: MaterialTable, points: SurfacePoints, u: Draw) -> BsdfSamples:
    """Draw directions from the delta lobes alone, and nothing where there is none.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points.
    u : four (N,) float64
        Lane 0 picks between reflection and refraction.

    Returns
    -------
    BsdfSamples
        Weight 0 on materials without delta lobe.
    """
    size = len(points)
    wi, weight = zero_vectors(size), zero_vectors(size)
    delta = np.zeros(size, bool)
    for kind, rows, some in by_kind(table, points):
        if kind not in HAS_DELTA:
            continue
        if kind == Kind.SMOOTH_COATED:
            wi[rows], weight[rows] = coated.reflect_in_coat(table, some)
        else:
            part = _sample_kind(kind, table, some, _rows_of(u, rows))
            wi[rows], weight[rows] = part.wi, part.weight
        delta[rows] = True
    return BsdfSamples(wi, weight, np.zeros(size), delta)


def _sample_kind(
    kind: Kind, table: MaterialTable, points: SurfacePoints, u: Draw
) -> BsdfSamples:
    if kind == Kind.SMOOTH_CONDUCTOR:
        return _mirror(table, points)
    if kind == Kind.DIELECTRIC:
        return BsdfSamples(*dielectric.sample(table, points, u))
    if kind == Kind.SMOOTH_COATED:
        return BsdfSamples(*coated.sample_smooth(table, points, u))
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
