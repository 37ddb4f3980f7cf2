"""Limits that implementations put on the Jacobian."""

from collections.abc import Callable

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.formulas import jacobian
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.verbs import choose

JacobianFormula = Callable[[ReceiverPoint, ReceiverPoint, SamplePoint], Bounded]


def clamped(least: float, most: float) -> JacobianFormula:
    """Formula of the Jacobian, Equation 11, clamped between two limits."""

    def limited(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
        J = jacobian(x_from, x_to, y)
        value: Scalars = np.clip(J.value, least, most)
        # The limit is a literal, rounded as such, of another size than J.
        return Bounded(value, J.error + J.rounding.unit * value, J.rounding)

    return limited


def rejected(least: float, most: float) -> JacobianFormula:
    """Formula of the Jacobian, Equation 11, or 0 outside of two limits.

    Parameters
    ----------
    least, most : float; the limits, which belong to what is kept
    """

    def limited(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
        J = jacobian(x_from, x_to, y)
        inside = (J.value >= least) & (J.value <= most)
        return choose(inside, J, constant(0.0, J))

    return limited
