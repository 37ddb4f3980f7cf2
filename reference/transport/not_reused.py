"""Light of initial paths that reconnection cannot reuse: it is shown, and no more."""

from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, divide_or_zero
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.scene.materials.bsdf_sampling import (
    APART,
    BsdfSamples,
    sample_apart,
)
from restir_gi.reference.scene.materials.parameters import Kind, MaterialTable
from restir_gi.reference.scene.materials.table import is_shared, scattering
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.path_tracer import reflected_radiance
from restir_gi.reference.transport.world import World

GlossySamples = Literal["path-traced", "as-lambertian"]
"""Sample points that are not Lambertian: shown as this frame has them, or reused."""


def split_light(
    world: World,
    points: SurfacePoints,
    source: str,
    glossy_samples: GlossySamples,
    bounces: int,
    *,
    drawn: BsdfSamples,
    met: SurfacePoints,
    omega: Vec3s,
    density: Scalars,
    radiance: Vec3s,
    speculars: Uniforms,
    tail: Scalars | None,
) -> tuple[Masks, Vec3s]:
    """Which samples can be reused, and the light of this frame's paths that cannot.

    Parameters
    ----------
    world, points, source, glossy_samples, bounces, speculars
        As of :func:`restir_gi.reference.passes.initial.initial_samples`.
    omega : (N, 3) float64; unit directions to the sample points
    density : (N,) float64, 1/sr; source density of ``omega``
    radiance : (N, 3) float64, W/(m² sr); that leaves the sample points
    tail : (N,) float64 or None; Russian roulette, as there

    Returns
    -------
    (N,) bool; the sample can be reused
    (N, 3) float64, W/(m² sr)
        Light by way of a delta lobe or a rough dielectric at the visible point, or of a
        sample point that is not Lambertian.
    """
    shared = ~drawn.delta & (density > 0)
    apart = drawn.delta
    if source == "bsdf" and world.materials.transmits:
        apart = apart | ~is_shared(world.materials, points)
    light = np.where(apart[:, None], drawn.weight * radiance, 0.0)
    if glossy_samples == "path-traced" and world.plan.glossy:
        lambertian = is_lambertian(world.materials, met)
        value = scattering(world.materials, points, omega) * radiance
        alone = (shared & ~lambertian)[:, None]
        light += np.where(alone, divide_or_zero(value, density[:, None]), 0.0)
        # A miss has no material, and no radiance.
        shared &= lambertian | ~met.hit
    if source != "bsdf" and world.plan.delta:
        first = sample_apart(world.materials, points, speculars.draw(0))
        light += reflected_radiance(
            world,
            points,
            bounces,
            speculars,
            skip_direct=True,
            first=first,
            tail=tail,
            tail_begins=1,
        )
    return shared, light


def is_lambertian(table: MaterialTable, points: SurfacePoints) -> Masks:
    """Whether the radiance that leaves a point is the same in all directions.

    Returns (N,) bool; by material.
    """
    lambertian: Masks = table.kind[points.material] == Kind.LAMBERTIAN
    return lambertian


def reuses_all(world: World, source: str, glossy_samples: GlossySamples) -> bool:
    """Whether all light of the initial paths may be reused.

    False where `split_light` may hold light.

    Parameters
    ----------
    glossy_samples : 'path-traced' or 'as-lambertian'
        What becomes of sample points that are not Lambertian.
    """
    kinds = world.materials.kinds
    lambertian = kinds == (Kind.LAMBERTIAN,)
    apart = any(kind in APART for kind in kinds)
    return lambertian or (glossy_samples == "as-lambertian" and not apart)
