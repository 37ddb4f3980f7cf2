"""Limits that implementations put on the Jacobian."""

import numpy as np

from reference.arrays import Scalars
from reference.oracle.replay.bounded import Bounded, constant
from reference.oracle.replay.formulas import jacobian
from reference.oracle.replay.points import Point, Receiver
from reference.oracle.replay.verbs import choose


def _within(J: Bounded, least: float, most: float) -> Bounded:
    value: Scalars = np.clip(J.value, least, most)
    # The limit is a literal, rounded as such, of another size than J.
    return Bounded(value, J.error + J.rounding.unit * value, J.rounding)


def clamped_3(x_from: Receiver, x_to: Receiver, y: Point) -> Bounded:
    """Jacobian of Equation 11, clamped to [1/3, 3].

    Parameters
    ----------
    x_from, x_to : Receiver
        N visible points each.
    y : Point
        N sample points.

    Returns
    -------
    Bounded
        (N,)
    """
    return _within(jacobian(x_from, x_to, y), 1 / 3, 3.0)


def clamped_2(x_from: Receiver, x_to: Receiver, y: Point) -> Bounded:
    """Jacobian of Equation 11, clamped to [1/2, 2].

    Parameters
    ----------
    x_from, x_to : Receiver
        N visible points each.
    y : Point
        N sample points.

    Returns
    -------
    Bounded
        (N,)
    """
    return _within(jacobian(x_from, x_to, y), 1 / 2, 2.0)


def clamped_8(x_from: Receiver, x_to: Receiver, y: Point) -> Bounded:
    """Jacobian of Equation 11, at most 8.

    Parameters
    ----------
    x_from, x_to : Receiver
        N visible points each.
    y : Point
        N sample points.

    Returns
    -------
    Bounded
        (N,)
    """
    return _within(jacobian(x_from, x_to, y), 0.0, 8.0)


def clamped_10(x_from: Receiver, x_to: Receiver, y: Point) -> Bounded:
    """Jacobian of Equation 11, at most 10.

    Parameters
    ----------
    x_from, x_to : Receiver
        N visible points each.
    y : Point
        N sample points.

    Returns
    -------
    Bounded
        (N,)
    """
    return _within(jacobian(x_from, x_to, y), 0.0, 10.0)


def rejected_beyond_10(x_from: Receiver, x_to: Receiver, y: Point) -> Bounded:
    """Jacobian of Equation 11, or 0 where it is beyond a limit that is in wide use.

    Parameters
    ----------
    x_from, x_to : Receiver
        N visible points each.
    y : Point
        N sample points.

    Returns
    -------
    Bounded
        (N,), 0 outside of [1/10, 10].
    """
    J = jacobian(x_from, x_to, y)
    none = constant(0.0, J)
    return choose((J.value >= 0.1) & (J.value <= 10), J, none)


def rejected_2(x_from: Receiver, x_to: Receiver, y: Point) -> Bounded:
    """Jacobian of Equation 11, or 0 where it is above 2.

    Parameters
    ----------
    x_from, x_to : Receiver
        N visible points each.
    y : Point
        N sample points.

    Returns
    -------
    Bounded
        (N,)
    """
    J = jacobian(x_from, x_to, y)
    return choose(J.value <= 2, J, constant(0.0, J))
