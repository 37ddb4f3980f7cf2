"""Domains D_n: which samples a visible point could have drawn, hidden or not."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, dot
from restir_gi.reference.numerics.records import take
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.resampling.source import Source, source_pdf
from restir_gi.reference.resampling.target import Target, target
from restir_gi.reference.scene.materials.parameters import MaterialTable
from restir_gi.reference.scene.surface import SurfacePoints, direction_and_distance


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
