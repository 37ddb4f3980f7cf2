"""Initial candidates: points on lights by power, of which one is kept by its light."""

from dataclasses import replace

from hashgrid.light_settings import LightSettings
from hashgrid.lights import draw_lights, reflected
from reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    finalize,
    initial_candidates,
    merge,
)
from reference.resampling.target import luminance
from reference.rng import Uniforms
from reference.scene.surface import SurfacePoints
from reference.world import World


def keep_one(
    world: World, points: SurfacePoints, settings: LightSettings, uniforms: Uniforms
) -> Reservoirs:
    """Resampled importance sampling of the lights that surface points may see.

    [Boisse21, Alg. 1], RIS.

    Parameters
    ----------
    uniforms : Uniforms; N rows, a dimension for each candidate

    Returns
    -------
    Reservoirs; of `hashgrid.lights.LightPoints`; M is the number of candidates
    """
    kept: Candidates | None = None
    for k in range(settings.candidates):
        u = uniforms.draw(k)
        lights, density = draw_lights(world.emitters, u)
        value = reflected(world, points, lights, settings.chance)
        drawn = initial_candidates(
            replace(lights, value=value), luminance(value), density
        )
        kept = drawn if kept is None else merge(kept, drawn, u[3])
    assert kept is not None
    return finalize(kept, kept.M)
