"""Pixels that resample, and what they ask of a sample."""

from dataclasses import dataclass

from reference.arrays import Masks, Scalars
from reference.resampling.reservoir import Samples
from reference.resampling.target import target
from reference.scene.surface import SurfacePoints, Viewpoints
from reference.settings import Settings
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class Receivers:
    """Pixels that resample, K rows.

    Attributes
    ----------
    world : World
        Of this frame.
    points : SurfacePoints
        Their visible points.
    settings : Settings
        Of the algorithm.
    """

    world: World
    points: SurfacePoints
    settings: Settings

    def target(self, y: Samples) -> Scalars:
        """Target p̂ of samples at the receivers.

        Parameters
        ----------
        y : Samples
            K samples.

        Returns
        -------
        (K,) float64
            Without visibility; see :func:`reference.resampling.target.target`.
        """
        kind = self.settings.target
        return target(kind, self.world.materials, self.points, y)

    def see(self, y: Samples, active: Masks) -> Masks:
        """Whether the receivers see samples: one ray each.

        Parameters
        ----------
        y : Samples
            K samples.
        active : (K,) bool
            Who looks.

        Returns
        -------
        (K,) bool
            False where nobody looks.
        """
        return sees(self.world, self.points, y, active)


def sees(
    world: World, points: SurfacePoints | Viewpoints, y: Samples, active: Masks
) -> Masks:
    """Whether visible points see sample points: one ray each.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints or Viewpoints
        N visible points.
    y : Samples
        N sample points.
    active : (N,) bool
        Who looks.

    Returns
    -------
    (N,) bool
        Nothing lies between; false where nobody looks.
    """
    return world.caster.visible(points, y.position, y.normal, active, "reuse")
