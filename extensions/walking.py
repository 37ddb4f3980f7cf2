"""One step of a walk, drawn from random numbers: the same for base and offset paths."""

from dataclasses import dataclass, replace

import numpy as np

from extensions.connection import Criterion, Segment, segment
from reference.arrays import Masks, Scalars, Vec3s, divide_or_zero, dot, zero_vectors
from reference.records import where
from reference.rng import Uniforms
from reference.scene.hits import Hits, surface_points
from reference.scene.materials.bsdf_sampling import BsdfSamples, sample
from reference.scene.materials.table import pdf, scattering
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True)
class Step:
    """A point x_v of N walks, and how they came to it.

    Attributes
    ----------
    points : SurfacePoints; x_v; misses where a walk has ended
    throughput : (N, 3) float64; product of f cos θ / p of x_1 to x_(v-1)
    weight : (N, 3) float64; the last of these factors
    came : Segment or None; from x_(v-1); ``None`` at x_1
    joinable : (N,) bool
        x_v may be a reconnection vertex, if it is left by no delta lobe.
    pdf : (N,) float64, 1/sr
        Density of the direction in which x_(v-1) was left; 0 for a delta lobe.
    """

    points: SurfacePoints
    throughput: Vec3s
    weight: Vec3s
    came: Segment | None
    joinable: Masks
    pdf: Scalars


@dataclass(frozen=True, slots=True)
class Leaving:
    """Directions in which N walks leave a point, and what they meet."""

    bsdf: BsdfSamples
    hits: Hits


def start(points: SurfacePoints) -> Step:
    """Walks that have not left their visible points.

    Parameters
    ----------
    points : SurfacePoints; N visible points x_1
    """
    size = len(points)
    return Step(
        points,
        1.0 + zero_vectors(size),
        1.0 + zero_vectors(size),
        None,
        np.zeros(size, bool),
        np.zeros(size),
    )


def leave(
    world: World, step: Step, vertex: int, uniforms: Uniforms, active: Masks
) -> Leaving:
    """Draw directions and trace them.

    Parameters
    ----------
    uniforms : Uniforms; N rows; dimension 2 (v - 1) draws the direction
    active : (N,) bool; which walks go on
    """
    bsdf = sample(world.materials, step.points, uniforms.draw(2 * (vertex - 1)))
    goes_on = active & step.points.hit & (dot(bsdf.weight, bsdf.weight) > 0)
    hits = world.caster.from_surface(step.points, bsdf.wi, goes_on, "bounce")
    return Leaving(bsdf, hits)


def arrive(
    world: World, criterion: Criterion, step: Step, vertex: int, leaving: Leaving
) -> Step:
    """Go on to what the rays met.

    Returns Step; x_(v+1).
    """
    bsdf = leaving.bsdf
    met = surface_points(world.geometry, leaving.hits, step.points.position, bsdf.wi)
    seen, came = segment(criterion, world.geometry, step.points, met)
    joinable = came.joinable & ~bsdf.delta & (vertex < criterion.last_joint)
    weight, density = bsdf.weight, bsdf.pdf
    if joinable.any():
        # What may be joined is the point, not the ray.
        wo, position = (
            where(joinable, a, b)
            for a, b in ((seen.wo, met.wo), (seen.position, met.position))
        )
        met = replace(met, wo=wo, position=position)
        value = scattering(world.materials, step.points, -wo)
        density = np.where(joinable, pdf(world.materials, step.points, -wo), density)
        exact = divide_or_zero(value, density[:, None])
        weight = where(joinable, exact, weight)
    return Step(met, step.throughput * weight, weight, came, joinable, density)
