"""Sample validation: whether stored samples are still what they were."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Masks, dot
from restir_gi.reference.options.replay import Replay
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import SurfacePoints, direction_and_distance
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.caster import STOP
from restir_gi.reference.transport.path_tracer import follow
from restir_gi.reference.transport.world import World


def validates(frame: FrameContext[Settings]) -> bool:
    """In this frame samples are traced again, and none drawn where there is one."""
    s = frame.settings
    asked = s.motion == "as-stored" and frame.changes == "scene"
    every = s.validate_every
    return asked and every > 0 and frame.number % every == every - 1


def validated(
    world: World, points: SurfacePoints, r: Reservoirs, replay: Replay, tolerance: float
) -> Reservoirs:
    """Empty the reservoirs whose sample is no longer what it was.

    [Ouyang21, section 4.3].  Biased: whether M survives depends on the sample's value,
    and of a scene that has changed in part the samples that survive were drawn for more
    light than there is now.  Of the nulls that M counts, only the one that was kept
    last is asked.

    Parameters
    ----------
    points : SurfacePoints
        N visible points that own the reservoirs, where they are in this frame.
    r : Reservoirs; as they were stored, with the suffix of each sample
    replay : Replay; finds radiance again, with the same random numbers
    tolerance : float; largest relative change of luminance, |a - b| / max(a, b)

    Returns
    -------
    Reservoirs
        W = 0 and M = 0 where the ray no longer meets the sample point, or the radiance
        that leaves it has changed; nulls too, where there is light now.
    """
    y, suffix = r.y, r.y.suffix
    assert suffix is not None
    # A path that met nothing meets nothing: there is no point to look at.
    met_something = suffix.surface.hit
    there = _is_met(world, points, y, met_something)
    now = luminance(replay.radiance(world, suffix, there))
    then = luminance(y.radiance)
    same = np.abs(now - then) <= tolerance * np.maximum(now, then)
    valid = ~met_something | (there & same)
    return replace(r, W=np.where(valid, r.W, 0.0), M=np.where(valid, r.M, 0.0))


def _is_met(world: World, points: SurfacePoints, y: Samples, active: Masks) -> Masks:
    """Whether rays to sample points find them there, and nothing before them."""
    omega, _ = direction_and_distance(points.position, y.position)
    met = follow(world, points, omega, active, "validation")
    # The plane of the sample point is met: a shape that has moved away or come between
    # is further off than rays are from where they were aimed.
    off = dot(y.normal, contact(world.geometry, met) - y.position)
    found: Masks = met.hit & (np.abs(off) <= STOP * world.geometry.extent)
    return found
