"""Formulas of the further passes in which mistakes are made."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.further.numbers import larger

MOST_M = 65535.0


def room(tolerance: Bounded, then: Bounded, now: Bounded) -> Bounded:
    """How much more luminance may change: tolerance · max(a, b) − |a − b|.

    Parameters
    ----------
    tolerance : Bounded; (1,): relative change
    then, now : Bounded; (N,): luminance as it was stored, and found again

    Returns
    -------
    Bounded; (N,): negative where the sample is no longer what it was
    """
    return tolerance * larger(then, now) - abs(then - now)


def light(brightness: Bounded, W: Bounded) -> Bounded:
    """What the boiling filter compares: Y(radiance) · W.

    Parameters
    ----------
    brightness, W : Bounded; (N,): luminance of the radiance, and the weight

    Returns
    -------
    Bounded; (N,)
    """
    return brightness * W


def calm(light: Bounded, mean: Bounded, strength: Bounded) -> Bounded:
    """How far light is from boiling: mean · (10 − 9 strength) − light · strength.

    Parameters
    ----------
    light, mean : Bounded; (N,): of a pixel, and of its tile
    strength : Bounded; (1,): of the filter

    Returns
    -------
    Bounded; (N,): negative where the reservoir is emptied
    """
    reach = constant(10.0, strength) - constant(9.0, strength) * strength
    return mean * reach - light * strength


def boiling_tile(x: Indices, y: Indices, width: int) -> Indices:
    """Tile of the boiling filter: 16 × 16 pixels from the top left.

    Parameters
    ----------
    x, y : (N,) int; pixels

    Returns
    -------
    (N,) int; any number, the same for pixels of one tile
    """
    return y // 16 * width + x // 16


def parity(x: Indices, y: Indices, width: int, frame: int) -> Indices:
    """What is even where a pixel draws again: x + y + frame.

    Parameters
    ----------
    x, y : (N,) int; pixels

    Returns
    -------
    (N,) int; odd where it does not draw
    """
    return x + y + frame


def roulette_tile(x: Indices, y: Indices, width: int) -> Indices:
    """Tile that goes on or stops as one: ⌊y / 32⌋ · ⌈width / 64⌉ + ⌊x / 64⌋.

    Parameters
    ----------
    x, y : (N,) int; pixels

    Returns
    -------
    (N,) int; first word of the random key
    """
    return y // 32 * -(-width // 64) + x // 64


def tail_weight(probability: Bounded) -> Bounded:
    """Weight (1,) of a tail that goes on: 1 / probability.

    Parameters
    ----------
    probability : Bounded; (1,)
    """
    return constant(1.0, probability) / probability


def packed_confidence(M: Scalars) -> Scalars:
    """M in 16 bits, before it is rounded: at most 65535, at least 1 if positive.

    Parameters
    ----------
    M : (N,) float64; confidence

    Returns
    -------
    (N,) float64; a whole number is stored as it stands, any other to 1/2
    """
    held: Scalars = np.where(M > 0, np.clip(M, 1.0, MOST_M), 0.0)
    return held
