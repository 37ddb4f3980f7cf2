"""Direct light at surface points: next-event estimation and chance hits, weighted."""

import numpy as np

from reference.arrays import Scalars, Vec3s, divide_or_zero
from reference.records import take
from reference.rng import Draw
from reference.scene.emitters import emitted, pdf_light
from reference.scene.light_sampling import sample_light
from reference.scene.materials.table import BsdfSamples, pdf, scattering
from reference.scene.surface import SurfacePoints
from reference.world import World


def next_event(world: World, points: SurfacePoints, u: Draw) -> Vec3s:
    """Light from a point drawn on a light, weighted against the chance of hitting it.

    Estimates ∫ f L_e cos θ m_light dω with one sample.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N points.
    u : four (N,) float64
        Lane 0 chooses the light, 1 and 2 the point on it.

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        Reflected towards the viewer; 0 on misses and where the light is hidden.

    Notes
    -----
    Balance heuristic [Veach95, Eq. 8].  A light that no ray can meet by chance, and a
    surface whose lobes are all narrower than any light, keep their whole weight.
    """
    radiance = np.zeros((len(points), 3))
    if world.emitters is None or len(points) == 0:
        return radiance
    light = sample_light(world.emitters, world.geometry, points.position, u)
    value = scattering(world.materials, points, light.wi) * light.weight
    rows = np.flatnonzero(value.any(axis=1))
    if len(rows) == 0:
        return radiance
    some, light, value = take(points, rows), take(light, rows), value[rows]
    if world.emitters.can_be_hit:
        by_chance = pdf(world.materials, some, light.wi)
        value = value * balance(light.pdf, by_chance)[:, None]
    if light.distant.all():
        seen = world.caster.escapes(some, light.wi, "shadow")
    elif not light.distant.any():
        seen = world.caster.visible(some, light.x_to, light.n_to, "shadow")
    else:
        seen = np.zeros(len(rows), bool)
        far, near = np.flatnonzero(light.distant), np.flatnonzero(~light.distant)
        seen[far] = world.caster.escapes(take(some, far), light.wi[far], "shadow")
        seen[near] = world.caster.visible(
            take(some, near), light.x_to[near], light.n_to[near], "shadow"
        )
    radiance[rows] = np.where(seen[:, None], value, 0.0)
    return radiance


def found_by_chance(
    world: World, points: SurfacePoints, bsdf: BsdfSamples, met: SurfacePoints
) -> Vec3s:
    """Light that rays drawn from the material met, weighted against next-event.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N points that the rays left.
    bsdf : BsdfSamples
        How the rays were drawn.
    met : SurfacePoints
        Where they ended.

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        Radiance times the weight of this strategy, not yet times ``bsdf.weight``.
    """
    radiance = emitted(world.emitters, world.geometry, met)
    if world.emitters is None or not radiance.any():
        return radiance
    by_choice = pdf_light(world.emitters, world.geometry, points.position, met)
    share = np.where(bsdf.delta, 1.0, balance(bsdf.pdf, by_choice))
    weighted: Vec3s = radiance * share[:, None]
    return weighted


def balance(mine: Scalars, other: Scalars) -> Scalars:
    """Balance heuristic p / (p + p'), and 1 for a strategy without density.

    Parameters
    ----------
    mine, other : (N,) float
        Densities of the sample under the strategy that drew it and the other one; a
        density of 0 for ``mine`` means a delta distribution.

    Returns
    -------
    (N,) float
        0 to 1.  The two weights of one sample sum to 1.
    """
    share: Scalars = np.where(mine > 0, divide_or_zero(mine, mine + other), 1.0)
    return share
