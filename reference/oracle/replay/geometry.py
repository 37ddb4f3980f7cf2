"""Cosines, sides and luminance, on numbers with error bounds."""

import numpy as np

from reference.oracle.replay.bounded import Bounded
from reference.oracle.replay.points import Point, Receiver
from reference.oracle.replay.verbs import inner, square_root, where_positive

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def luminance(color: Bounded) -> Bounded:
    """Luminance Y of colours, (N,).

    Parameters
    ----------
    color : Bounded; (N, 3)
    """
    unit = color.rounding.unit
    shares = np.broadcast_to(LUMINANCE, color.value.shape)
    return inner(color, Bounded(shares, unit * shares, color.rounding))


def cosine_at(x: Receiver, y: Point) -> Bounded:
    """Cosine of the sample's direction with the receiver's normal.

    Returns Bounded; (N,), negative below the horizon.
    """
    toward = y.position - x.position
    return inner(x.normal, toward) / square_root(inner(toward, toward))


def lit_at(x: Receiver, y: Point) -> Bounded:
    """Positive where the receiver is on the lit side of the sample point.

    Returns Bounded; (N,), −n_s·(x_s − x).
    """
    return -inner(y.normal, y.position - x.position)


def on_both_sides(x: Receiver, y: Point, value: Bounded) -> Bounded:
    """A value where the sample is above the horizon and lit, else 0, of the same shape.

    Parameters
    ----------
    value : Bounded; (N,) or (N, 3)
    """
    above = where_positive(inner(x.normal, y.position - x.position), value)
    return where_positive(lit_at(x, y), above)
