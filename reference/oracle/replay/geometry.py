"""Cosines, sides and luminance, on numbers with error bounds."""

import numpy as np

from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.verbs import inner, square_root, where_positive

LUMINANCE = (0.2126, 0.7152, 0.0722)


def luminance(color: Bounded) -> Bounded:
    """Luminance Y of colours, (N,).

    Parameters
    ----------
    color : Bounded; (N, 3)
    """
    return sum_of_shares(color, LUMINANCE)


def sum_of_shares(color: Bounded, shares: tuple[float, float, float]) -> Bounded:
    """Sum of the channels, each times its share, which the type may have to round.

    Parameters
    ----------
    color : Bounded; (N, 3)

    Returns
    -------
    Bounded; (N,)
    """
    rounding = color.rounding
    of_rows = np.broadcast_to(shares, color.value.shape)
    return inner(color, Bounded(of_rows, rounding.unit * of_rows, rounding))


def cosine_at(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    """Cosine of the sample's direction with the receiver's normal.

    Returns Bounded; (N,), negative below the horizon.
    """
    toward = y.position - x.position
    return inner(x.normal, toward) / square_root(inner(toward, toward))


def lit_at(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    """Positive where the receiver is on the lit side of the sample point.

    Returns Bounded; (N,), −n_s·(x_s − x).
    """
    return -inner(y.normal, y.position - x.position)


def on_both_sides(x: ReceiverPoint, y: SamplePoint, value: Bounded) -> Bounded:
    """A value where the sample is above the horizon and lit, else 0, of the same shape.

    Parameters
    ----------
    value : Bounded; (N,) or (N, 3)
    """
    above = where_positive(inner(x.normal, y.position - x.position), value)
    return where_positive(lit_at(x, y), above)


def open_at_zero(side: Bounded, value: Bounded) -> Bounded:
    """A value on both sides of a plane, and either that or 0 in the plane itself.

    Parameters
    ----------
    side : Bounded; (N,), positive on one of them
    value : Bounded; (N,)
    """
    sure = side.surely_positive | (side.value < -side.error)
    error = np.where(sure, value.error, np.abs(value.value) + value.error)
    return Bounded(value.value, error, value.rounding)
