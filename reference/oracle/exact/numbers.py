"""Exact numbers that know how far a floating-point type may end from them.

The value is exact to 2400 bits; the bound follows by the rules of running error
analysis [Higham02, section 3.3] from the operations that led to it.  So no tolerance is
chosen: a small difference of large numbers is allowed what its operands' roundings make
of it, and everything else next to nothing.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import MPContext

EXACT = MPContext()
EXACT.prec = 2400
"""Bits that hold sums of products of float64 down to 2⁻¹⁰⁷⁴ beside 1."""

ZERO = EXACT.mpf(0)
INFINITE = EXACT.mpf("inf")

LIBRARY = 2
"""Units by which NumPy's sine, cosine and exponential are off at most: its own tests
hold them to two in the last place in single precision, one in half.  Below 1 a place is
a unit."""


class UndecidedError(Exception):
    """A decision that rounding leaves open: the type may take either way."""


@dataclass(frozen=True, slots=True)
class Type:
    """A floating-point type.

    Attributes
    ----------
    name : str; 'float16', 'float32' or 'float64'
    unit : mpf
        Largest relative error of an operation, half the distance of 1 to the next.
    least : mpf; smallest positive number: largest absolute error of what underflows
    most : mpf; largest number
    """

    name: str
    unit: Any
    least: Any
    most: Any


def type_of(dtype: Any) -> Type:
    """What a NumPy type can hold."""
    info = np.finfo(dtype)
    found = (float(info.eps) / 2, float(info.smallest_subnormal), float(info.max))
    return Type(np.dtype(dtype).name, *(EXACT.mpf(x) for x in found))


@dataclass(frozen=True, slots=True)
class Exact:
    """An exact number, and a bound on the error of the type's.

    Attributes
    ----------
    error : mpf
        Whoever did the same operations in the type is no farther off; infinite where
        an operand may have been 0 or beyond the largest number.
    """

    value: Any
    error: Any
    type: Type

    def __add__(self, other: "Exact | int") -> "Exact":
        other = self._like(other)
        return self._rounded(self.value + other.value, self.error + other.error)

    def __sub__(self, other: "Exact | int") -> "Exact":
        return self + -self._like(other)

    def __rsub__(self, other: int) -> "Exact":
        return self._like(other) - self

    def __mul__(self, other: "Exact | int") -> "Exact":
        other = self._like(other)
        if self._nothing or other._nothing:
            return self._like(0)
        value = self.value * other.value
        if EXACT.isinf(self.error + other.error):
            return Exact(value, INFINITE, self.type)
        error = abs(self.value) * other.error + self.error * abs(other.value)
        return self._rounded(value, error + self.error * other.error, True)

    __rmul__ = __mul__
    __radd__ = __add__

    def __truediv__(self, other: "Exact | int") -> "Exact":
        """Quotient, and 0 over an exact 0."""
        other = self._like(other)
        if other._nothing or self._nothing:
            return self._like(0)
        least = abs(other.value) - other.error
        value = self.value / other.value if other.value else ZERO
        if least <= 0:
            return Exact(value, INFINITE, self.type)
        error = (self.error + abs(value) * other.error) / least
        return self._rounded(value, error, True)

    def __rtruediv__(self, other: int) -> "Exact":
        return self._like(other) / self

    def __abs__(self) -> "Exact":
        return Exact(abs(self.value), self.error, self.type)

    def __neg__(self) -> "Exact":
        return Exact(-self.value, self.error, self.type)

    def __gt__(self, other: "Exact | int") -> bool:
        other = self._like(other)
        apart = self.value - other.value
        error = self.error + other.error
        if error > 0 and abs(apart) <= error:
            raise UndecidedError
        return bool(apart > 0)

    def __le__(self, other: "Exact | int") -> bool:
        return not self > other

    def __lt__(self, other: "Exact | int") -> bool:
        return self._like(other) > self

    def __ge__(self, other: "Exact | int") -> bool:
        return not self < other

    def sqrt(self) -> "Exact":
        """Square root; of what is not positive by the error at most, 0 or near it."""
        value = EXACT.sqrt(max(self.value, ZERO))
        if self.error == 0:
            return self._rounded(value, ZERO)
        least = self.value - self.error
        error = (
            self.error / (value + EXACT.sqrt(least))
            if least > 0
            else EXACT.sqrt(abs(self.value) + self.error)
        )
        return self._rounded(value, error)

    def exp(self) -> "Exact":
        """Exponential, of a number that itself is off by its error."""
        value = EXACT.exp(self.value)
        if EXACT.isinf(self.error):
            return Exact(value, INFINITE, self.type)
        moved = value * EXACT.expm1(self.error)
        library = LIBRARY * self.type.unit * (value + moved)
        return Exact(value, moved + library + self.type.least, self.type)

    def cos(self) -> "Exact":
        """Cosine, of an angle that itself is off by its error."""
        return self._of_library(EXACT.cos(self.value))

    def sin(self) -> "Exact":
        """Sine, of an angle that itself is off by its error."""
        return self._of_library(EXACT.sin(self.value))

    def _of_library(self, value: Any) -> "Exact":
        return Exact(value, self.error + LIBRARY * self.type.unit, self.type)

    @property
    def _nothing(self) -> bool:
        return bool(self.value == 0 and self.error == 0)

    def _like(self, other: "Exact | int") -> "Exact":
        return other if isinstance(other, Exact) else exact(other, self.type)

    def _rounded(self, value: Any, error: Any, underflows: bool = False) -> "Exact":
        size = abs(value) + error
        if size > self.type.most:
            return Exact(value, INFINITE, self.type)
        rounding = self.type.unit * size
        # Sums of subnormal numbers are exact: products and quotients are not.
        if underflows:
            rounding += self.type.least
        return Exact(value, error + rounding, self.type)


WHOLE = MPContext()
WHOLE.prec = 2**15
"""Bits that hold all of a sum of products of four float64: the exponents of such
products span less than 2¹⁴."""

DIGITS = MPContext()
DIGITS.dps = 50

UNROUNDED = Type("exact", ZERO, ZERO, INFINITE)
"""The type of `Unrounded`."""


class Unrounded(Exact):
    """A number that nothing rounds but quotients, roots, sines and cosines.

    Sums and products are those of `WHOLE`, and so are the signs of differences; the
    others have 50 digits.
    """

    __slots__ = ()
    error, type = ZERO, UNROUNDED

    def __init__(self, value: Any) -> None:
        object.__setattr__(self, "value", value)

    def __add__(self, other: Exact | int) -> Exact:
        return Unrounded(self.value + _value(other))

    def __sub__(self, other: Exact | int) -> Exact:
        return Unrounded(self.value - _value(other))

    def __rsub__(self, other: int) -> Exact:
        return Unrounded(other - self.value)

    def __mul__(self, other: Exact | int) -> Exact:
        return Unrounded(self.value * _value(other))

    def __truediv__(self, other: Exact | int) -> Exact:
        """Quotient, and 0 over 0."""
        below = _value(other)
        if not below:
            return Unrounded(WHOLE.zero)
        return _of_digits(DIGITS.convert(self.value) / DIGITS.convert(below))

    __radd__ = __add__
    __rmul__ = __mul__

    def __abs__(self) -> Exact:
        return Unrounded(abs(self.value))

    def __neg__(self) -> Exact:
        return Unrounded(-self.value)

    def __gt__(self, other: Exact | int) -> bool:
        return bool(self.value > _value(other))

    def __lt__(self, other: Exact | int) -> bool:
        return bool(self.value < _value(other))

    def sqrt(self) -> Exact:
        """Square root of a number that is not negative."""
        return _of_digits(DIGITS.sqrt(DIGITS.convert(self.value)))

    def cos(self) -> Exact:
        """Cosine."""
        return _of_digits(DIGITS.cos(DIGITS.convert(self.value)))

    def sin(self) -> Exact:
        """Sine."""
        return _of_digits(DIGITS.sin(DIGITS.convert(self.value)))


def _value(number: Exact | int) -> Any:
    return number.value if isinstance(number, Exact) else number


def _of_digits(value: Any) -> Exact:
    return Unrounded(WHOLE.convert(value))


def exact(value: Any, type_: Type) -> Exact:
    """A number that a kernel was given, without an error.

    Parameters
    ----------
    value : float or mpf; finite
    """
    if type_ is UNROUNDED:
        return Unrounded(WHOLE.convert(value))
    return Exact(EXACT.mpf(value), ZERO, type_)


def exactly(value: Any, type_: Type) -> Any:
    """What a kernel was given in one row, without an error.

    Parameters
    ----------
    value : number, or k of them; finite
    """
    if isinstance(value, list | np.ndarray):
        return tuple(exact(float(component), type_) for component in value)
    return exact(float(value), type_)


def literal(value: Any, type_: Type) -> Exact:
    """A number that the type can only round, as π."""
    number = EXACT.mpf(value)
    if type_ is UNROUNDED:
        return Unrounded(WHOLE.convert(number))
    return Exact(number, abs(number) * type_.unit, type_)
