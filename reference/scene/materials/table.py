"""All materials behind three questions: how much, how likely, and where to."""

from collections.abc import Iterator

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    zero_vectors,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials import (
    coated,
    conductor,
    lambertian,
    rough_dielectric,
)
from restir_gi.reference.scene.materials.parameters import Kind, MaterialTable
from restir_gi.reference.scene.surface import SurfacePoints


def by_kind(
    table: MaterialTable, points: SurfacePoints
) -> Iterator[tuple[Kind, Indices, SurfacePoints]]:
    """Split points by the kind of their material, so that each is paid for once.

    Parameters
    ----------
    points : SurfacePoints; N points

    Yields
    ------
    Kind, (K,) int, SurfacePoints; kind, rows, and the points of these rows
    """
    kind = table.kind[points.material]
    for k in table.kinds:
        rows = np.flatnonzero(kind == k)
        if len(rows):
            yield k, rows, take(points, rows)


def can_scatter(table: MaterialTable, points: SurfacePoints) -> Masks:
    """Whether a point scatters any light at all.

    Returns (N,) bool; False for misses and for black surfaces without a coat.
    """
    able = points.color.any(axis=1)
    coats = (Kind.ROUGH_COATED, Kind.SMOOTH_COATED)
    if any(kind in coats for kind in table.kinds):
        able = able | np.isin(table.kind[points.material], coats)
    scatters: Masks = points.hit & able
    return scatters


def is_shared(table: MaterialTable, points: SurfacePoints) -> Masks:
    """Whether light that a point scatters may be reused, delta lobes apart.

    Returns (N,) bool; False on rough dielectrics, whose light comes from both sides.
    """
    if not table.transmits:
        return np.ones(len(points), bool)
    shared: Masks = table.kind[points.material] != Kind.ROUGH_DIELECTRIC
    return shared


def scattering(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Vec3s:
    """Reflected share f(wo, wi) cos θ_i of all lobes but the delta ones.

    Parameters
    ----------
    points : SurfacePoints; N points, with their viewers ``wo``
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N, 3) float64, 1/sr
        0 below the surface unless the material refracts, on black backs, for misses and
        for delta lobes.
    """
    functions = {
        Kind.LAMBERTIAN: lambertian.scattering,
        Kind.ROUGH_CONDUCTOR: conductor.scattering,
        Kind.ROUGH_COATED: coated.scattering,
        Kind.SMOOTH_COATED: coated.base_reflection,
        Kind.ROUGH_DIELECTRIC: rough_dielectric.scattering,
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
    wi : (N, 3) float64; unit directions to the light

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
        Kind.ROUGH_DIELECTRIC: rough_dielectric.pdf,
    }
    if table.kinds == (Kind.LAMBERTIAN,):
        return lambertian.pdf(table, points, wi)
    value = np.zeros(len(wi))
    for kind, rows, some in by_kind(table, points):
        if kind in functions:
            value[rows] = functions[kind](table, some, take(wi, rows))
    return value
