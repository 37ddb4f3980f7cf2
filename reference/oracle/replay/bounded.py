"""Numbers with a bound on how far rounding may have taken them.

A backend calculates the contract's formulas in its own order and number type.  Each
operation rounds by at most ``unit`` of its result, and what is below ``tiny`` may
become 0; the bounds are carried through by the rules of running error analysis
[Higham02, section 3.3].  So a tolerance is never chosen: it follows from the row's own
numbers, wide where they cancel and narrow everywhere else.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.contract.fields import Precision

ORDERS = 4.0
"""Roundings allowed for each one of ours.  A direction that is normalized before its
cosine is taken, a quotient of squares in place of the square of a quotient, a division
as a product with a reciprocal: none has more than four for one."""


@dataclass(frozen=True, slots=True)
class Rounding:
    """How a backend rounds.

    Attributes
    ----------
    unit : float; relative error of an operation
    tiny : float; absolute error of an operation: results below it may be flushed to 0
    """

    unit: float
    tiny: float


def rounding_of(precision: Precision) -> Rounding:
    """Rounding of IEEE arithmetic, in any sensible order, subnormals kept or not.

    The unit is `ORDERS` half units in the last place; twice that in float64, in which
    the replay itself calculates.
    """
    info = np.finfo(precision)
    own = 2.0 if precision == "float64" else 1.0
    return Rounding(float(info.eps) / 2 * ORDERS * own, float(info.tiny))


@dataclass(frozen=True, slots=True, eq=False)
class Bounded:
    """Arrays of numbers and of bounds on their error.

    Attributes
    ----------
    value : array of float64; exact arithmetic on the given numbers, to 2⁻⁵³
    error : array of float64; a backend's number differs by no more
    """

    value: Scalars
    error: Scalars
    rounding: Rounding

    def __add__(self, other: "Bounded") -> "Bounded":
        return self._result(self.value + other.value, self.error + other.error)

    def __sub__(self, other: "Bounded") -> "Bounded":
        return self._result(self.value - other.value, self.error + other.error)

    def __mul__(self, other: "Bounded") -> "Bounded":
        a, b = np.abs(self.value), np.abs(other.value)
        with np.errstate(invalid="ignore", over="ignore"):
            error = a * other.error + self.error * (b + other.error)
            unknown = np.isnan(error)
            if unknown.any():
                # Of an exact 0 nothing is left, even times what is not known at all.
                none = (a == 0) & (self.error == 0) | (b == 0) & (other.error == 0)
                error = np.where(unknown, np.where(none, 0.0, np.inf), error)
            flushed = self.rounding.tiny * ((a > 0) & (b > 0))
            error = error + flushed + self.rounding.unit * (a * b)
            return Bounded(self.value * other.value, error, self.rounding)

    def __truediv__(self, other: "Bounded") -> "Bounded":
        """Quotient; 0 over an exact 0, and a bound of infinity over what may be 0."""
        least = np.abs(other.value) - other.error
        none = (other.value == 0) & (other.error == 0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            value = np.where(other.value != 0, self.value / other.value, 0.0)
            error = (self.error + np.abs(value) * other.error) / least
        error = np.where(least > 0, error, np.inf)
        error = np.where(value != 0, error + self.rounding.tiny, error)
        result = self._result(value, error)
        return Bounded(
            np.where(none, 0.0, result.value),
            np.where(none, 0.0, result.error),
            self.rounding,
        )

    def __abs__(self) -> "Bounded":
        return Bounded(np.abs(self.value), self.error, self.rounding)

    def __neg__(self) -> "Bounded":
        return Bounded(-self.value, self.error, self.rounding)

    def __getitem__(self, key: Any) -> "Bounded":
        return Bounded(self.value[key], self.error[key], self.rounding)

    def _result(self, value: Scalars, error: Scalars) -> "Bounded":
        with np.errstate(invalid="ignore", over="ignore"):
            return Bounded(
                value, error + self.rounding.unit * np.abs(value), self.rounding
            )

    @property
    def surely_positive(self) -> Masks:
        """Whether every number within the bound is above 0, (N,) bool."""
        sure: Masks = self.value > self.error
        return sure

    @property
    def surely_not_positive(self) -> Masks:
        """Whether none is, (N,) bool."""
        sure: Masks = self.value <= -self.error
        return sure


def exact(values: NDArray[Any], rounding: Rounding) -> Bounded:
    """Numbers that the backend was given, or that it gave, without error.

    Parameters
    ----------
    values : array; any type that float64 holds
    """
    wide = np.asarray(values).astype(np.float64)
    return Bounded(wide, np.zeros_like(wide), rounding)


def constant(value: float, like: Bounded) -> Bounded:
    """A number that a backend writes as a literal, rounded once.

    A small whole number is not rounded.

    Parameters
    ----------
    like : Bounded; gives shape and rounding
    """
    values = np.full(like.value.shape, float(value))
    whole = float(value).is_integer() and abs(value) < 2**11
    error = np.zeros_like(values) if whole else like.rounding.unit * np.abs(values)
    return Bounded(values, error, like.rounding)
