"""Lights that end paths: those that are chosen, and those that are met by chance."""

from dataclasses import dataclass, replace

import numpy as np

from extensions.paths import Paths, Technique
from extensions.walking import Leaving, Step
from reference.arrays import Indices, Masks, Scalars, Vec3s
from reference.direct_light import choose_light, met_lights
from reference.light_shares import share_of_chance
from reference.records import scatter, where
from reference.resampling.reservoir import Candidates, merge
from reference.resampling.target import luminance
from reference.rng import Draw, Uniforms
from reference.world import World


def find_lights(
    world: World, step: Step, vertex: int, uniforms: Uniforms, leaving: Leaving | None
) -> Candidates:
    """One light for each path at x_v, chosen or met.

    Parameters
    ----------
    uniforms : Uniforms
        N rows; dimension 2 (v - 1) + 1 chooses the light, lane 3 of the one before
        between the two.
    leaving : Leaving or None; rays that left x_v; ``None`` where none may meet a light

    Returns
    -------
    Candidates
        Of `Lights`; the two are other integrals, so that w = p̂, and M counts none.
    """
    lights = _chosen(world, step, uniforms.draw(2 * vertex - 1))
    if leaving is not None:
        other = uniforms.draw(2 * (vertex - 1))[3]
        lights = merge(lights, _met(world, step, leaving), other)
    return lights


@dataclass(frozen=True, slots=True)
class Lights:
    """Lights that end N paths, as their last points receive them.

    Attributes
    ----------
    technique : (N,) int8; how they were found
    joins : (N,) bool; the last point may be a reconnection vertex
    wi : (N, 3) float64; unit directions to them
    radiance : (N, 3) float64
        Radiance, over the density of the choice where they were chosen.
    reflected : (N, 3) float64, W/(m² sr)
        By the last point, over its density, and weighted.
    pdf_light : (N,) float64, 1/sr; with which next-event estimation chooses them
    pdf : (N,) float64, 1/sr
        With which the path chose its direction to the light, 1 where the light itself
        was chosen.
    """

    technique: Indices
    joins: Masks
    wi: Vec3s
    radiance: Vec3s
    reflected: Vec3s
    pdf_light: Scalars
    pdf: Scalars


def _chosen(world: World, step: Step, u: Draw) -> Candidates:
    """Lights by next-event estimation."""
    light, size = choose_light(world, step.points, u), len(step.points)
    found = Lights(
        technique=np.full(size, Technique.NEXT_EVENT, np.int8),
        joins=step.joinable,
        wi=light.wi,
        radiance=np.where(light.seen[:, None], light.weight, 0.0),
        reflected=light.value,
        pdf_light=light.pdf,
        pdf=np.ones(size),
    )
    return _competing(step, found)


def _met(world: World, step: Step, leaving: Leaving) -> Candidates:
    """Lights that the rays met."""
    bsdf, size = leaving.bsdf, len(step.points)
    rows, some, by_choice = met_lights(world, step.points, bsdf, leaving.hits)
    radiance, pdf_light = scatter(rows, some, size), scatter(rows, by_choice, size)
    share = share_of_chance(bsdf.pdf, bsdf.delta, pdf_light)
    found = Lights(
        technique=np.full(size, Technique.CHANCE, np.int8),
        joins=step.joinable & ~bsdf.delta,
        wi=bsdf.wi,
        radiance=radiance,
        reflected=bsdf.weight * radiance * share[:, None],
        pdf_light=pdf_light,
        pdf=bsdf.pdf,
    )
    return _competing(step, found)


def _competing(step: Step, lights: Lights) -> Candidates:
    p_hat = luminance(step.throughput * lights.reflected)
    return Candidates(lights, p_hat, p_hat, np.zeros(len(p_hat)))


def ended(step: Step, paths: Paths, vertex: int, lights: Lights) -> Paths:
    """Paths with a light after x_v, which is the reconnection vertex if it can be.

    Parameters
    ----------
    paths : Paths
        What is known of them, ``incoming`` being the product of weights beyond the
        reconnection vertex.
    """
    size = len(step.points)
    end, value = np.full(size, vertex, np.int8), step.throughput * lights.reflected
    known = paths.joint > 0
    here = lights.joins & ~known
    surface, wi, pdf_light = paths.surface, paths.wi, paths.pdf_light
    joint, density = paths.joint, paths.density
    incoming = paths.incoming * lights.reflected
    if here.any():
        surface = where(known, surface, step.points)
        joint = np.where(here, end, joint)
        wi, incoming, pdf_light, density = (
            where(here, a, b)
            for a, b in (
                (lights.wi, wi),
                (lights.radiance, incoming),
                (lights.pdf_light, pdf_light),
                (density_at(step, lights.pdf), density),
            )
        )
    return replace(
        paths,
        end=end,
        technique=lights.technique,
        joint=joint,
        surface=surface,
        wi=wi,
        incoming=incoming,
        pdf_light=pdf_light,
        density=density,
        value=value,
    )


def density_at(step: Step, pdf: Scalars) -> Scalars:
    """Density of both ends of a joint at x_v.

    Parameters
    ----------
    step : Step; N paths at x_v, that came from x_(v-1)
    pdf : (N,) float64, 1/sr; with which x_v is left; 1 where the light was chosen

    Returns
    -------
    (N,) float64; p(ω_(v-1)) cos φ_v / d² p(ω_v)
    """
    assert step.came is not None
    density: Scalars = step.pdf * step.came.spread * pdf
    return density
