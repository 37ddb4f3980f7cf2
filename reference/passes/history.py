"""What the last frame hands on to the resampling of this one."""

from dataclasses import dataclass

from reference.resampling.reservoir import Reservoirs
from reference.scene.surface import SurfacePoints


@dataclass(frozen=True, slots=True)
class History:
    """What the last frame left, N rows: a row for each pixel of this frame.

    Attributes
    ----------
    points : SurfacePoints
        Visible points of the last frame, at which the reservoirs stand; those of this
        frame while neither the camera nor the scene moves.
    reservoirs : Reservoirs
        Temporal or spatial reservoirs of the last frame.
    """

    points: SurfacePoints
    reservoirs: Reservoirs
