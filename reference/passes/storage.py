"""How reservoirs are kept between passes: as they are, or in the paper's 48 bytes."""

from dataclasses import replace

import numpy as np

from reference.resampling.packing.paper import pack, unpack
from reference.resampling.reservoir import Reservoirs
from reference.scene.surface import SurfacePoints
from reference.settings import Storage


def stored(
    storage: Storage, points: SurfacePoints, r: Reservoirs, pixels: int
) -> Reservoirs:
    """Reservoirs as they come back from memory.

    Parameters
    ----------
    storage : 'float64' or 'paper'
        Untouched, or through 48 bytes each.
    points : SurfacePoints
        K visible points.
    r : Reservoirs
        Their reservoirs.
    pixels : int
        Of a frame.

    Returns
    -------
    Reservoirs
        K rows.

    Notes
    -----
    [Ouyang21, section 5]; errors as :func:`reference.resampling.packing.paper.pack`
    states them.  The 32 bits of the seed hold the number of the path, modulo the
    largest multiple of ``pixels`` that they can: at 1920 x 1080 pixels it repeats after
    2071 frames.  The rest of the path, which a moving scene wants too, is not counted
    among the 48 bytes and keeps its precision.
    """
    if storage == "float64":
        return r
    seed = np.zeros(len(r.W), np.uint32)
    if r.y.suffix:
        seed = (r.y.suffix.number % (2**32 // pixels * pixels)).astype(np.uint32)
    codes = pack(points.position, points.normal, r, seed)
    _, _, back, _ = unpack(codes)
    return replace(back, y=replace(back.y, suffix=r.y.suffix))
