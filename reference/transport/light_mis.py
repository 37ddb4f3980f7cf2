"""MIS weights of light sampling and of BSDF sampling, by the balance heuristic."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    plus,
)
from restir_gi.reference.scene.materials.table import pdf
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World


def light_sampling_weight(
    world: World, points: SurfacePoints, wi: Vec3s, pdf_light: Scalars
) -> Scalars:
    """MIS weight of light sampling against BSDF sampling.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light
    pdf_light : (N,) float64, 1/sr; density of light sampling

    Returns
    -------
    (N,) float64; 1 where no ray can hit a light
    """
    if world.emitters is None or not world.emitters.can_be_hit:
        return np.ones(len(points))
    return balance(pdf_light, pdf(world.materials, points, wi))


def bsdf_sampling_weight(
    pdf_bsdf: Scalars, delta: Masks, pdf_light: Scalars
) -> Scalars:
    """MIS weight of BSDF sampling, for an emitter hit, against light sampling.

    Parameters
    ----------
    pdf_bsdf, pdf_light : (N,) float64, 1/sr
        Densities of BSDF sampling and of light sampling.
    delta : (N,) bool; the ray left by a delta lobe, which light sampling cannot find

    Returns
    -------
    (N,) float64; 1 for delta lobes
    """
    return np.where(delta, 1.0, balance(pdf_bsdf, pdf_light))


def balance(mine: Scalars, other: Scalars) -> Scalars:
    """Balance heuristic p / (p + p'), and 1 for a strategy without density.

    Parameters
    ----------
    mine, other : (N,) float
        Densities of the sample under the strategy that drew it and the other one; a
        density of 0 for ``mine`` means a delta distribution.

    Returns
    -------
    (N,) float; 0 to 1; the two weights of one sample sum to 1
    """
    weight: Scalars = np.where(mine > 0, divide_or_zero(mine, plus(mine, other)), 1.0)
    return weight
