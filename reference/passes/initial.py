"""Algorithm 2: one new sample point a pixel."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.resampling.source import Source, sample_source, source_pdf
from restir_gi.reference.resampling.suffix import suffix_of
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import SurfacePoints, direction_and_distance
from restir_gi.reference.transport.not_reused import GlossySamples, split_light
from restir_gi.reference.transport.path_tracer import follow, reflected_radiance
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True)
class InitialSamples:
    """What the initial pass hands on, N rows.

    Attributes
    ----------
    y : Samples; sample points; nulls where a path found no light or may not be reused
    pdf : (N,) float64, 1/sr; source density of the direction to the sample point
    M : (N,) float64; 1 where a sample was drawn, nulls included; else 0
    not_reused : (N, 3) float64, W/(m² sr)
        Light of this frame's paths that cannot be reused by reconnection: by way of a
        delta lobe or a rough dielectric at the visible point, or of a sample point that
        is not Lambertian.
    """

    y: Samples
    pdf: Scalars
    M: Scalars
    not_reused: Vec3s


def initial_samples(
    world: World,
    points: SurfacePoints,
    source: Source,
    glossy_samples: GlossySamples,
    bounces: int,
    *,
    directions: Uniforms,
    paths: Uniforms,
    speculars: Uniforms,
    numbers: Indices | None = None,
    tail: Scalars | None = None,
    active: Masks | None = None,
) -> InitialSamples:
    """One new sample point for each visible point.

    [Ouyang21, Alg. 2].  Emission of the sample point is direct light of the visible
    point and stays out of L_o.

    Parameters
    ----------
    glossy_samples : 'path-traced' or 'as-lambertian'
        What becomes of sample points that are not Lambertian.
    bounces : int; bounces of indirect light, at least 1
    directions, paths, speculars : Uniforms
        N rows: for the direction, for L_o at the sample point, for what is not reused.
    numbers : (N,) int64 or None
        Of the paths, where their radiance will have to be found again.
    tail : (N,) float64 or None
        Russian roulette: weight of what lies beyond the first bounce; ``None`` for 1.
    active : (N,) bool or None; who draws a sample at all; ``None`` for everyone
    """
    M = np.ones(len(points)) if active is None else active.astype(float)
    drawn = sample_source(source, world.materials, points, directions.draw(0))  # line 3
    possible = points.hit & drawn.weight.any(axis=1) & (M > 0)
    met = follow(world, points, drawn.wi, possible, "initial")  # line 4
    radiance = reflected_radiance(world, met, bounces - 1, paths, tail=tail)  # line 5
    # The sample is the point, not the ray: density and target take the direction from
    # point to point, which differs from the ray's by Embree's rounding.
    x_s = contact(world.geometry, met)
    omega, _ = direction_and_distance(points.position, x_s)
    density = source_pdf(source, world.materials, points, omega)
    shared, not_reused = split_light(
        world,
        points,
        source,
        glossy_samples,
        bounces,
        drawn=drawn,
        met=met,
        omega=omega,
        density=density,
        radiance=radiance,
        speculars=speculars,
        tail=tail,
    )
    shining = np.where(shared[:, None], radiance, 0.0)
    # What is not reused now is not reused in another frame either.
    suffix = None if numbers is None else suffix_of(numbers, met, shared)
    y = Samples(x_s, met.normal, shining, suffix)  # line 6
    return InitialSamples(y, density, M, not_reused)
