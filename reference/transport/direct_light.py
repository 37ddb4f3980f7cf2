"""Direct light at surface points: light sampling and emitter hits, weighted."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    plus,
    zero_vectors,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.scene.emitters import emitted, may_emit, pdf_light
from restir_gi.reference.scene.hits import Hits, surface_points
from restir_gi.reference.scene.light_sampling import LightSamples, sample_light
from restir_gi.reference.scene.materials.bsdf_sampling import BsdfSamples
from restir_gi.reference.scene.materials.table import pdf, scattering
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True)
class ChosenLight:
    """Points drawn on lights, as N surface points receive them.

    Attributes
    ----------
    wi : (N, 3) float64; unit directions to them
    weight : (N, 3) float64
        Radiance over the density of the choice, whether or not it is seen.
    pdf : (N,) float64, 1/sr
        Density of the choice; 0 where only this strategy finds the light.
    seen : (N,) bool; nothing lies between; false where nothing would be reflected
    value : (N, 3) float64, W/(m² sr)
        Reflected towards the viewer, times the MIS weight of light sampling;
        0 where it is not seen.
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    seen: Masks
    value: Vec3s


def choose_light(
    world: World, points: SurfacePoints, u: Draw, active: Masks | None = None
) -> ChosenLight:
    """Draw a point on a light for each surface point, and look whether it is seen.

    Balance heuristic [Veach95, Eq. 8].  A light that no ray can hit, and a
    surface whose lobes are all narrower than any light, keep their whole weight.

    Parameters
    ----------
    u : four (N,) float64; lane 0 chooses the light, 1 and 2 the point on it
    active : (N,) bool, optional; who asks; by default everyone
    """
    if world.emitters is None or len(points) == 0:
        none, size = zero_vectors(len(points)), len(points)
        return ChosenLight(none, none, np.zeros(size), np.zeros(size, bool), none)
    light = sample_light(world.emitters, world.geometry, points.position, u)
    value = scattering(world.materials, points, light.wi) * light.weight
    if world.emitters.can_be_hit:
        value *= light_sampling_weight(world, points, light.wi, light.pdf)[:, None]
    shines = np.any(value, axis=1)
    if active is not None:
        shines = shines & active
    seen = sees_light(world, points, light, shines)
    value = np.where(seen[:, None], value, 0.0)
    return ChosenLight(light.wi, light.weight, light.pdf, seen, value)


def sees_light(
    world: World, points: SurfacePoints, light: LightSamples, active: Masks
) -> Masks:
    """Whether nothing lies between surface points and points on lights.

    Parameters
    ----------
    light : LightSamples; N points on lights
    active : (N,) bool; who asks

    Returns
    -------
    (N,) bool; False for those who do not ask
    """
    near, far = active & ~light.distant, active & light.distant
    seen = world.caster.visible(points, light.x_to, light.n_to, near, "shadow")
    if far.any():
        seen = seen | world.caster.escapes(points, light.wi, far, "shadow")
    return seen


def next_event(world: World, points: SurfacePoints, u: Draw) -> Vec3s:
    """Light from a point drawn on a light, times the MIS weight of light sampling.

    Estimates ∫ f L_e cos θ m_light dω with one sample.

    Parameters
    ----------
    u : four (N,) float64; lane 0 chooses the light, 1 and 2 the point on it

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        Reflected towards the viewer; 0 on misses and where the light is hidden.
    """
    return choose_light(world, points, u).value


def emitter_hits(
    world: World, points: SurfacePoints, bsdf: BsdfSamples, hits: Hits
) -> tuple[Indices, Vec3s, Scalars]:
    """Lights that rays drawn from the material met.

    Returns
    -------
    (K,) int, (K, 3) float64, (K,) float64
        Rows that met a light; its radiance in W/(m² sr), without any weight; and the
        density with which next-event estimation would have chosen it, in 1/sr.
    """
    if world.emitters is None:
        return np.zeros(0, np.int64), zero_vectors(0), np.zeros(0)
    rows = np.flatnonzero(may_emit(world.emitters, hits.primitive))
    if len(rows) == 0:
        return rows, zero_vectors(0), np.zeros(0)
    x, wi = take(points.position, rows), take(bsdf.wi, rows)
    met = surface_points(world.geometry, take(hits, rows), x, wi)
    radiance = emitted(world.emitters, world.geometry, met)
    return rows, radiance, pdf_light(world.emitters, world.geometry, x, met)


def weighted_emitter_hits(
    world: World, points: SurfacePoints, bsdf: BsdfSamples, hits: Hits
) -> tuple[Indices, Vec3s]:
    """Light that rays drawn from the material met, weighted against next-event.

    Returns
    -------
    (K,) int, (K, 3) float64
        Rows that met a light; its radiance in W/(m² sr) times the weight of this
        strategy, not yet times ``bsdf.weight``.
    """
    rows, radiance, p_light = emitter_hits(world, points, bsdf, hits)
    weight = bsdf_sampling_weight(bsdf.pdf[rows], bsdf.delta[rows], p_light)
    return rows, radiance * weight[:, None]


# --------------------------- MIS weights of light sampling and of BSDF sampling


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
