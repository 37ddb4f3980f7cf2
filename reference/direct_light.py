"""Direct light at surface points: next-event estimation and chance hits, weighted."""

import numpy as np

from reference.arrays import Indices, Scalars, Vec3s, divide_or_zero, zero_vectors
from reference.records import take
from reference.rng import Draw
from reference.scene.emitters import emitted, may_emit, pdf_light
from reference.scene.hits import Hits, surface_points
from reference.scene.light_sampling import sample_light
from reference.scene.materials.bsdf_sampling import BsdfSamples
from reference.scene.materials.table import pdf, scattering
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
    if world.emitters is None or len(points) == 0:
        return zero_vectors(len(points))
    light = sample_light(world.emitters, world.geometry, points.position, u)
    value = scattering(world.materials, points, light.wi) * light.weight
    if world.emitters.can_be_hit:
        by_chance = pdf(world.materials, points, light.wi)
        value *= balance(light.pdf, by_chance)[:, None]
    shines = value.any(axis=1)
    near, far = shines & ~light.distant, shines & light.distant
    seen = world.caster.visible(points, light.x_to, light.n_to, near, "shadow")
    if far.any():
        seen = seen | world.caster.escapes(points, light.wi, far, "shadow")
    return np.where(seen[:, None], value, 0.0)


def found_by_chance(
    world: World, points: SurfacePoints, bsdf: BsdfSamples, hits: Hits
) -> tuple[Indices, Vec3s]:
    """Light that rays drawn from the material met, weighted against next-event.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N points that the rays left.
    bsdf : BsdfSamples
        How the rays were drawn.
    hits : Hits
        What they met.

    Returns
    -------
    (K,) int, (K, 3) float64
        Rows that met a light; its radiance in W/(m² sr) times the weight of this
        strategy, not yet times ``bsdf.weight``.
    """
    if world.emitters is None:
        return np.zeros(0, np.int64), zero_vectors(0)
    rows = np.flatnonzero(may_emit(world.emitters, hits.primitive))
    if len(rows) == 0:
        return rows, zero_vectors(0)
    x, wi = take(points.position, rows), take(bsdf.wi, rows)
    met = surface_points(world.geometry, take(hits, rows), x, wi)
    radiance = emitted(world.emitters, world.geometry, met)
    by_choice = pdf_light(world.emitters, world.geometry, x, met)
    mine = balance(bsdf.pdf[rows], by_choice)
    share = np.where(bsdf.delta[rows], 1.0, mine)
    return rows, radiance * share[:, None]


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
