"""Radiance found again: the same path with the same random numbers at another time."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.numerics.rng import Stream, Uniforms
from restir_gi.reference.options.roulette import tail_weights
from restir_gi.reference.resampling.suffix import Suffix
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.path_tracer import reflected_radiance
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True)
class Replay:
    """How the radiance of sample points follows from the numbers of their paths.

    Attributes
    ----------
    bounces : int; of indirect light at the visible points, at least 1
    uniforms : callable; random numbers of the paths that have the given numbers
    tail : callable or None; weight of what lies beyond the first bounce; ``None`` for 1
    """

    bounces: int
    uniforms: Callable[[Indices], Uniforms]
    tail: Callable[[Indices], Scalars] | None = None

    def radiance(self, world: World, suffix: Suffix, active: Masks) -> Vec3s:
        """Radiance L_o that leaves sample points in a world.

        [Ouyang21, section 4.3]: "the same random numbers".  As a map of the path's
        random numbers it is the identity, whose Jacobian is 1.

        Parameters
        ----------
        suffix : Suffix; N sample points, where they are in that frame
        active : (N,) bool; whose radiance is wanted

        Returns
        -------
        (N, 3) float64, W/(m² sr)
            Bit for bit what it was, if nothing has changed; 0 where not wanted.
        """
        primitive = np.where(active, suffix.surface.primitive, -1)
        surface = replace(suffix.surface, primitive=primitive)
        weight = self.tail(suffix.number) if self.tail else None
        uniforms = self.uniforms(suffix.number)
        return reflected_radiance(
            world, surface, self.bounces - 1, uniforms, tail=weight
        )


def replay_of(frame: FrameContext[Settings]) -> Replay:
    """How the radiance of any sample of the run follows from its path's number."""

    def uniforms(numbers: Indices) -> Uniforms:
        return frame.uniforms_of(Stream.PATH, numbers)

    return Replay(frame.bounces, uniforms, tail_weights(frame))
