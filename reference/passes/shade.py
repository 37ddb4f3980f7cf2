"""Shading: the estimate f(y) W of the pixel's indirect light."""

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.resampling.target import reflected
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World


def shade(world: World, points: SurfacePoints, reservoirs: Reservoirs) -> Vec3s:
    """Radiance f(y) W that visible points scatter towards the camera [Ouyang21, Eq. 8].

    Parameters
    ----------
    points : SurfacePoints; N visible points

    Returns
    -------
    (N, 3) float64, W/(m² sr); visibility of the sample is part of W
    """
    radiance: Vec3s = reflected(world.materials, points, reservoirs.y)
    return radiance * reservoirs.W[:, None]
