"""Light at a point of a path, with all that its weight hangs on."""

from dataclasses import dataclass

import numpy as np

from reference.arrays import Masks, Scalars, Vec3s, zero_vectors
from reference.direct_light import balance
from reference.records import take
from reference.rng import Draw
from reference.scene.emitters import emitted, may_emit, pdf_light
from reference.scene.hits import Hits, surface_points
from reference.scene.light_sampling import sample_light
from reference.scene.materials.bsdf_sampling import BsdfSamples
from reference.scene.materials.table import pdf, scattering
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True)
class Light:
    """Light that reaches N points.

    Attributes
    ----------
    wi : (N, 3) float64
        Unit directions to it.
    radiance : (N, 3) float64, W/(m² sr)
        Over the density of the choice, if it was chosen; 0 where it is hidden.
    pdf_light : (N,) float64, 1/sr
        Density with which next-event estimation chooses it; 0 where only that can.
    """

    wi: Vec3s
    radiance: Vec3s
    pdf_light: Scalars


def chosen_light(world: World, points: SurfacePoints, u: Draw, active: Masks) -> Light:
    """Light from points that are drawn on lights.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N points.
    u : four (N,) float64
        Lane 0 chooses the light, 1 and 2 the point on it.
    active : (N,) bool
        Who asks.

    Returns
    -------
    Light
        N rows.
    """
    if world.emitters is None:
        none = zero_vectors(len(points))
        return Light(none, none, np.zeros(len(points)))
    light = sample_light(world.emitters, world.geometry, points.position, u)
    value = scattering(world.materials, points, light.wi) * light.weight
    shines = value.any(axis=1) & active
    near, far = shines & ~light.distant, shines & light.distant
    seen = world.caster.visible(points, light.x_to, light.n_to, near, "shadow")
    if far.any():
        seen = seen | world.caster.escapes(points, light.wi, far, "shadow")
    radiance = np.where((seen & shines)[:, None], light.weight, 0.0)
    return Light(light.wi, radiance, light.pdf)


def light_by_chance(
    world: World, points: SurfacePoints, bsdf: BsdfSamples, hits: Hits
) -> Light:
    """Light that rays drawn from the material met.

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
    Light
        N rows.
    """
    radiance, density = zero_vectors(len(points)), np.zeros(len(points))
    if world.emitters is not None:
        rows = np.flatnonzero(may_emit(world.emitters, hits.primitive))
        x, wi = take(points.position, rows), take(bsdf.wi, rows)
        met = surface_points(world.geometry, take(hits, rows), x, wi)
        radiance[rows] = emitted(world.emitters, world.geometry, met)
        density[rows] = pdf_light(world.emitters, world.geometry, x, met)
    return Light(bsdf.wi, radiance, density)


def share_of_choice(
    world: World, points: SurfacePoints, wi: Vec3s, pdf_light: Scalars
) -> Scalars:
    """Weight of next-event estimation against the chance of meeting the light.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N points.
    wi : (N, 3) float64
        Unit directions to the light.
    pdf_light : (N,) float64, 1/sr
        Density of the choice.

    Returns
    -------
    (N,) float64
        Balance heuristic [Veach95, Eq. 8].
    """
    if world.emitters is None or not world.emitters.can_be_hit:
        return np.ones(len(points))
    return balance(pdf_light, pdf(world.materials, points, wi))
