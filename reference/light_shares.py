"""Two ways to find a light, chosen or met by chance, and what each is weighted by."""

import numpy as np

from reference.arrays import Masks, Scalars, Vec3s, divide_or_zero, plus
from reference.scene.materials.table import pdf
from reference.scene.surface import SurfacePoints
from reference.world import World


def share_of_choice(
    world: World, points: SurfacePoints, wi: Vec3s, by_choice: Scalars
) -> Scalars:
    """Weight of next-event estimation against the chance of meeting the light.

    Parameters
    ----------
    wi : (N, 3) float64; unit directions to the light
    by_choice : (N,) float64, 1/sr; density of the choice

    Returns
    -------
    (N,) float64; 1 where no light can be met by chance
    """
    if world.emitters is None or not world.emitters.can_be_hit:
        return np.ones(len(points))
    return balance(by_choice, pdf(world.materials, points, wi))


def share_of_chance(by_chance: Scalars, delta: Masks, by_choice: Scalars) -> Scalars:
    """Weight of meeting a light by chance against next-event estimation.

    Parameters
    ----------
    by_chance, by_choice : (N,) float64, 1/sr; densities of both
    delta : (N,) bool; the ray left by a delta lobe, for which no light can be chosen

    Returns
    -------
    (N,) float64; 1 for delta lobes
    """
    return np.where(delta, 1.0, balance(by_chance, by_choice))


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
    share: Scalars = np.where(mine > 0, divide_or_zero(mine, plus(mine, other)), 1.0)
    return share
