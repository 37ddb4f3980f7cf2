"""Russian roulette by tiles: few pixels follow long paths, side by side."""

from collections.abc import Callable

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.settings import Settings

TILE_WIDTH, TILE_HEIGHT = 64, 32
"""Pixels that live or die together, so that threads side by side do the same."""


def tail_weight(
    pixel: Indices, width: int, probability: float, frame: int | Indices, seed: int
) -> Scalars:
    """Weight of all that lies beyond the first bounce.

    [Ouyang21, section 5].  Only the tail is reweighted: each tile estimates the first
    bounce, which 1 / probability would count too often.

    Parameters
    ----------
    pixel : (N,) int; y · width + x
    probability : float; above 0, to 1: share of the tiles whose paths go on
    frame : int or (N,) int; when the path is, or was, drawn

    Returns
    -------
    (N,) float64; 1 / probability where the pixel's tile goes on in that frame, else 0
    """
    x, y = pixel % width, pixel // width
    across = -(-width // TILE_WIDTH)
    tile = (y // TILE_HEIGHT * across + x // TILE_WIDTH).astype(np.uint32)
    u = KeyedUniforms(tile, frame, seed, Stream.ROULETTE).draw(0)[0]
    return np.where(u < probability, 1.0 / probability, 0.0)


def tail_weights(
    frame: FrameContext[Settings],
) -> Callable[[Indices], Scalars] | None:
    """From the numbers of paths to the weights of their tails; ``None`` for 1."""
    probability, width = frame.settings.roulette, frame.world.camera.width
    if probability == 1 or frame.bounces == 1:
        return None

    def weights(numbers: Indices) -> Scalars:
        drawn_in, pixel = np.divmod(numbers, frame.pixels)
        return tail_weight(pixel, width, probability, drawn_in, frame.seed)

    return weights
