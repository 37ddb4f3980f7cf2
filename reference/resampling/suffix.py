"""The rest of a sample's path: what finds its radiance again in another frame."""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.scene.surface import SurfacePoints


@dataclass(frozen=True, slots=True)
class Suffix:
    """How the radiance of N sample points was found.

    Attributes
    ----------
    number : (N,) int64
        Of the path: frame · pixels + pixel, both of when and where it was drawn.  It is
        the key of its random numbers, and its age.
    surface : SurfacePoints
        The sample points as the rays met them, where the rest of the path begins.
    """

    number: Indices
    surface: SurfacePoints


def suffix_of(number: Indices, met: SurfacePoints, kept: Masks) -> Suffix:
    """Suffixes of paths with numbers, (N,); no light where not ``kept``, (N,)."""
    primitive = np.where(kept, met.primitive, -1)
    return Suffix(number, replace(met, primitive=primitive))


def age(suffix: Suffix, frame: int, pixels: int) -> Scalars:
    """Frames that samples have survived, (N,) float64; 0 for samples of this frame."""
    ages: Scalars = frame - (suffix.number // pixels).astype(float)
    return ages
