"""Layers beside the picture: what the camera sees, and what the reservoirs keep."""

from collections.abc import Callable

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.transport.world import World

GBUFFER = {
    "depth": "distance along the camera's axis, m",
    "normal": "unit shading normal",
    "albedo": "reflectance of the material",
    "position": "point in the world, m",
}
RESERVOIRS = {
    "M": "confidence of the pixel's reservoir",
    "W": "its unbiased contribution weight, sr",
    "radiance": "radiance that leaves the kept sample point",
    "sample_position": "where the kept sample point lies, m",
    "sample_normal": "unit geometric normal there",
}


def gbuffer_layers(
    world: World, schedule: Schedule, names: tuple[str, ...]
) -> dict[str, Scalars]:
    """Layers of what is seen through the centre of each pixel.

    Parameters
    ----------
    names : tuple of str; which; others than those of `GBUFFER` are passed over

    Returns
    -------
    dict of str to (N,) or (N, 3) float64; 0 where nothing is seen
    """
    wanted = [name for name in names if name in GBUFFER]
    if not wanted:
        return {}
    x, y = pixel_centers(world.camera.width, world.camera.height)
    visible = in_bands(schedule, len(x), lambda r: visible_points(world, x[r], y[r]))
    hit = visible.surface.hit
    layer: dict[str, Callable[[VisiblePoints], Scalars]] = {
        "depth": lambda v: v.depth,
        "normal": lambda v: v.surface.shading,
        "albedo": lambda v: v.surface.color,
        "position": lambda v: contact(world.geometry, v.surface),
    }
    return {name: _zero_unless(hit, layer[name](visible)) for name in wanted}


def reservoir_layers(
    reservoirs: Reservoirs, names: tuple[str, ...]
) -> dict[str, Scalars]:
    """Layers of what the reservoirs of a frame keep.

    Parameters
    ----------
    names : tuple of str; which; others than those of `RESERVOIRS` are passed over

    Returns
    -------
    dict of str to (N,) or (N, 3) float64; the sample is 0 where the reservoir is empty
    """
    full, y = reservoirs.W > 0, reservoirs.y
    layer: dict[str, Callable[[], Scalars]] = {
        "M": lambda: reservoirs.M,
        "W": lambda: reservoirs.W,
        "radiance": lambda: _zero_unless(full, y.radiance),
        "sample_position": lambda: _zero_unless(full, y.position),
        "sample_normal": lambda: _zero_unless(full, y.normal),
    }
    return {name: layer[name]() for name in names if name in RESERVOIRS}


def _zero_unless(mask: Scalars, values: Scalars) -> Scalars:
    return np.where(mask if values.ndim == 1 else mask[:, None], values, 0.0)
