"""Paths as samples: what is kept of one, so that another pixel can take it over."""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from reference.arrays import Indices, Masks, Scalars, Vec3s, zero_vectors
from reference.scene.surface import SurfacePoints


class Technique(IntEnum):
    """How a path found its light."""

    NOTHING = 0
    NEXT_EVENT = 1
    CHANCE = 2


@dataclass(frozen=True, slots=True)
class Paths:
    """N paths x1 - x2 - ... - x_end - light, x1 being what the pixel sees.

    Attributes
    ----------
    number : (N,) int64
        Key of the random numbers: with them, and x1, the path can be drawn again.
    end : (N,) int8; index of the last surface point, at least 2; 0 for no path
    technique : (N,) int8; `Technique` by which x_end found its light
    joint : (N,) int8
        Index c of the reconnection vertex x_c, from which on the path is shared; 0
        where there is none, and the whole path is replayed.
    surface : SurfacePoints; x_c, as it was seen from x_(c-1)
    wi : (N, 3) float64; unit direction from x_c to the next point, or to the light
    incoming : (N, 3) float64
        What arrives at x_c from there.  Where light follows x_c: its radiance, for
        next-event estimation over the density of the choice, W/(m² sr).  Else all
        that comes after x_c, each factor over its density.
    pdf_light : (N,) float64, 1/sr
        Where light follows x_c: density with which next-event estimation chooses it.
    density : (N,) float64
        With which x_(c-1) and x_c chose their directions: p(ω_(c-1)) cos φ_c / d² of
        the one, per area, times p(ω_c) of the other, which is 1 for next-event
        estimation.
    value : (N, 3) float64, W/(m² sr)
        Contribution f / p at the pixel: integrand in primary sample space.
    """

    number: Indices
    end: Indices
    technique: Indices
    joint: Indices
    surface: SurfacePoints
    wi: Vec3s
    incoming: Vec3s
    pdf_light: Scalars
    density: Scalars
    value: Vec3s

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.number)

    @property
    def there(self) -> Masks:
        """(N,) bool: there is a path at all."""
        found: Masks = self.end > 0
        return found

    def moved(self, value: Vec3s, jacobian: Scalars) -> "Paths":
        """The same paths from other pixels.

        Parameters
        ----------
        value : (N, 3) float64; there
        jacobian : (N,) float64, sr/sr; of the shift

        Returns
        -------
        Paths; densities at the joint change as the Jacobian says
        """
        joined = self.joint > 0
        density = np.where(joined, self.density * jacobian, self.density)
        return replace(self, value=value, density=density)


def no_paths(points: SurfacePoints, number: Indices) -> Paths:
    """Nulls, N rows without light.

    Parameters
    ----------
    points : SurfacePoints; N points, that stand for those of the paths
    number : (N,) int64; keys
    """
    size = len(number)
    none = np.zeros(size, np.int8)
    return Paths(
        number=number,
        end=none,
        technique=none,
        joint=none,
        surface=points,
        wi=zero_vectors(size),
        incoming=zero_vectors(size),
        pdf_light=np.zeros(size),
        density=np.zeros(size),
        value=zero_vectors(size),
    )
