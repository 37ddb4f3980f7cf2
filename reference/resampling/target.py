"""Target functions p̂ of Equations 9 and 10: how much a sample matters to a point."""

from typing import Literal

import numpy as np

from restir_gi.reference.images.image import luminance_weights
from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    saturate,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.resampling.source import Source, source_pdf
from restir_gi.reference.scene.materials.parameters import (
    Kind,
    MaterialTable,
    lit_cosine,
)
from restir_gi.reference.scene.materials.table import is_shared, scattering
from restir_gi.reference.scene.surface import SurfacePoints, direction_and_distance

Target = Literal["scattered", "outgoing"]
"""Eq. 9, light that the receiver scatters; Eq. 10, light that leaves the sample."""


def luminance(color: Vec3s) -> Scalars:
    """Luminance of linear Rec. 709 colours.

    Parameters
    ----------
    color : (N, 3); radiance or reflectance

    Returns
    -------
    (N,); in the unit of ``color``
    """
    return dot(color, np.array(luminance_weights(), color.dtype))


def reflected(table: MaterialTable, receiver: SurfacePoints, y: Samples) -> Vec3s:
    """Integrand f = f_r(ω_o, ω) cos θ L_o(x_s) of the pixel, without visibility.

    [Ouyang21, Eq. 8 and 9].

    Returns
    -------
    (N, 3), W/(m² sr²)
        0 below the receiver's horizon, on the unlit side of the sample point, and on
        rough dielectrics, whose light is not reused.
    """
    omega, _ = direction_and_distance(receiver.position, y.position)
    lit = dot(y.normal, omega) < 0
    if table.transmits:
        lit = lit & is_shared(table, receiver)
    value = scattering(table, receiver, omega) * y.radiance
    return np.where(lit[:, None], value, 0.0)


def target(
    kind: Target, table: MaterialTable, receiver: SurfacePoints, y: Samples
) -> Scalars:
    """Target p̂ of samples at receivers.

    [Ouyang21, Eq. 9 and 10].  Visibility is not in it: it costs a ray.

    Parameters
    ----------
    kind : 'scattered' or 'outgoing'; Equation 9 or 10

    Returns
    -------
    (N,)
        Luminance; 0 below the receiver's horizon and on the unlit side of the sample
        point, for both kinds, and for nulls.
    """
    lambertian = table.kinds == (Kind.LAMBERTIAN,)
    if kind == "scattered" and not lambertian:
        return luminance(reflected(table, receiver, y))
    # Neither needs a unit vector: the cosine over a distance, or its sign.
    toward = y.position - receiver.position
    with np.errstate(over="ignore", invalid="ignore"):
        cosine = np.where(
            dot(y.normal, toward) < 0, lit_cosine(table, receiver, toward), 0.0
        )
        if kind == "outgoing":
            return np.where(cosine > 0, luminance(y.radiance), 0.0)
        scale = divide_or_zero(cosine, np.pi * np.sqrt(dot(toward, toward)))
    scale = saturate(scale)
    return luminance(receiver.color * y.radiance) * scale


def target_if_drawn(
    source: Source,
    kind: Target,
    table: MaterialTable,
    points: SurfacePoints,
    y: Samples,
) -> Scalars:
    """Target of samples at points, 0 where they are never drawn.

    Returns (N,), radiance/sr; without visibility.
    """
    omega, _ = direction_and_distance(points.position, y.position)
    drawn = source_pdf(source, table, points, omega) > 0
    return np.where(drawn, target(kind, table, points, y), 0.0)


def supports(
    source: Source,
    kind: Target,
    table: MaterialTable,
    surface: SurfacePoints,
    rows: Indices,
    y: Samples,
) -> Masks:
    """Whether points draw samples and give them a target above 0.

    Parameters
    ----------
    rows : (K,) int; which of them

    Returns
    -------
    (K,) bool
        `target_if_drawn` > 0.  With the target of Equation 10 the density must be asked
        for, too.
    """
    if not table.plain:
        return target_if_drawn(source, kind, table, take(surface, rows), y) > 0
    # Every point is black or reflects all colours to its whole horizon, so that whether
    # the target is positive is a question of geometry.
    toward = y.position - take(surface.position, rows)
    holds: Masks = dot(y.normal, toward) < 0
    # A black point draws samples as others do, and Equation 10 does not mind it.
    if kind == "scattered" or source == "bsdf":
        holds &= surface.color[rows, 0] > 0
    holds &= dot(take(surface.normal, rows), toward) > 0
    if surface.smooth is not None:
        holds &= dot(take(surface.smooth, rows), toward) > 0
    return holds
