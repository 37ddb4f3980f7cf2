"""Algorithm 2: one new sample point a pixel."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices, Masks, Scalars, Vec3s, divide_or_zero, vectors
from reference.frames import to_world
from reference.path_tracer import follow, reflected_radiance
from reference.resampling.reservoir import Samples
from reference.resampling.suffix import Suffix
from reference.rng import Draw, Uniforms
from reference.sampling import (
    pdf_cosine_hemisphere,
    pdf_uniform_hemisphere,
    sample_cosine_hemisphere,
    sample_uniform_hemisphere,
)
from reference.scene.materials.bsdf_sampling import (
    APART,
    BsdfSamples,
    sample,
    sample_apart,
)
from reference.scene.materials.parameters import Kind, MaterialTable, lit_cosine
from reference.scene.materials.table import can_scatter, is_shared, pdf, scattering
from reference.scene.origins import contact
from reference.scene.surface import SurfacePoints, direction_and_distance
from reference.settings import GlossySamples, Source
from reference.world import World


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
    # Sample a direction (line 3) and trace it to the sample point (line 4).
    drawn = sample_source(source, world.materials, points, directions.draw(0))
    possible = points.hit & drawn.weight.any(axis=1)
    if active is not None:
        possible &= active
    met = follow(world, points, drawn.wi, possible, "initial")
    # Estimate the radiance that leaves it (line 5).
    radiance = reflected_radiance(world, met, bounces - 1, paths, tail=tail)
    # The sample is the point, not the ray: density and target take the direction from
    # point to point, which differs from the ray's by Embree's rounding.
    x_s = contact(world.geometry, met)
    omega, _ = direction_and_distance(points.position, x_s)
    density = source_pdf(source, world.materials, points, omega)
    shared = ~drawn.delta & (density > 0)
    apart = drawn.delta
    if source == "bsdf" and world.materials.transmits:
        apart = apart | ~is_shared(world.materials, points)
    not_reused = np.where(apart[:, None], drawn.weight * radiance, 0.0)
    if glossy_samples == "path-traced" and world.plan.glossy:
        lambertian = is_lambertian(world.materials, met)
        value = scattering(world.materials, points, omega) * radiance
        alone = (shared & ~lambertian)[:, None]
        not_reused += np.where(alone, divide_or_zero(value, density[:, None]), 0.0)
        # A miss has no material, and no radiance.
        shared &= lambertian | ~met.hit
    if source != "bsdf" and world.plan.delta:
        first = sample_apart(world.materials, points, speculars.draw(0))
        not_reused += reflected_radiance(
            world,
            points,
            bounces,
            speculars,
            skip_direct=True,
            first=first,
            tail=tail,
            tail_begins=1,
        )
    suffix = None
    if numbers is not None:
        # What is not reused now is not reused in another frame either.
        kept = replace(met, primitive=np.where(shared, met.primitive, -1))
        suffix = Suffix(numbers, kept)
    shining = np.where(shared[:, None], radiance, 0.0)
    y = Samples(x_s, met.normal, shining, suffix)
    M = np.ones(len(points)) if active is None else active.astype(float)
    return InitialSamples(y, density, M, not_reused)


def is_lambertian(table: MaterialTable, points: SurfacePoints) -> Masks:
    """Whether the radiance that leaves a point is the same in all directions.

    Returns (N,) bool; by material.
    """
    lambertian: Masks = table.kind[points.material] == Kind.LAMBERTIAN
    return lambertian


def reuses_all(world: World, source: Source, glossy_samples: GlossySamples) -> bool:
    """Whether all light of the initial paths may be reused.

    False where `InitialSamples.not_reused` may hold light.

    Parameters
    ----------
    glossy_samples : 'path-traced' or 'as-lambertian'
        What becomes of sample points that are not Lambertian.
    """
    kinds = world.materials.kinds
    lambertian = kinds == (Kind.LAMBERTIAN,)
    apart = any(kind in APART for kind in kinds)
    return lambertian or (glossy_samples == "as-lambertian" and not apart)
