"""Source densities of section 4.1: where initial directions come from."""

from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, vectors
from restir_gi.reference.numerics.frames import to_world
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.numerics.sampling import (
    pdf_cosine_hemisphere,
    pdf_uniform_hemisphere,
    sample_cosine_hemisphere,
    sample_uniform_hemisphere,
)
from restir_gi.reference.scene.materials.bsdf_sampling import BsdfSamples, sample
from restir_gi.reference.scene.materials.parameters import MaterialTable, lit_cosine
from restir_gi.reference.scene.materials.table import can_scatter, is_shared, pdf
from restir_gi.reference.scene.surface import SurfacePoints

Source = Literal["uniform", "cosine", "bsdf"]
"""Of initial directions: over the hemisphere, by its cosine, or as the BSDF has it."""


def source_pdf(
    source: Source, table: MaterialTable, points: SurfacePoints, omega: Vec3s
) -> Scalars:
    """Source density p_q of initial directions.

    Parameters
    ----------
    omega : (N, 3) float64; unit directions

    Returns
    -------
    (N,) float64, 1/sr
        0 below the horizon, for black points that draw by their BSDF, and on rough
        dielectrics: such a draw is a null, or not reused.
    """
    if source == "bsdf":
        able = can_scatter(table, points) & is_shared(table, points)
        return np.where(able, pdf(table, points, omega), 0.0)
    cosine = lit_cosine(table, points, omega)
    if table.transmits:
        cosine = np.where(is_shared(table, points), cosine, 0.0)
    if source == "cosine":
        return pdf_cosine_hemisphere(cosine)
    return np.where(cosine > 0, pdf_uniform_hemisphere(cosine), 0.0)


def sample_source(
    source: Source, table: MaterialTable, points: SurfacePoints, u: Draw
) -> BsdfSamples:
    """Draw initial directions.

    Parameters
    ----------
    u : four (N,) float64; lane 0 picks a lobe, 1 and 2 the direction

    Returns
    -------
    BsdfSamples; ``delta`` where ``source`` is the BSDF and it chose a delta lobe
    """
    if source == "bsdf":
        return sample(table, points, u)
    hemisphere = (
        sample_cosine_hemisphere if source == "cosine" else sample_uniform_hemisphere
    )
    wi = to_world(hemisphere(u[1], u[2]), points.shading)
    density = source_pdf(source, table, points, wi)
    weight = vectors(*[np.where(density > 0, 1.0, 0.0)] * 3)
    return BsdfSamples(wi, weight, density, np.zeros(len(points), bool))
