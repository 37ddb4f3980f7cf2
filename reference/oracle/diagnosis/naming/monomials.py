"""Products of powers of a row's own factors, fitted to wrong numbers over right ones.

Where a number is a product, a wrong power of one of its factors, or a constant too
many, leaves a quotient of wrong over right that is such a product again: its logarithm
is linear in those of the factors.  Exponents are multiples of 1/2, so that the fit is
exact: a few rows give them, and all others must agree to rounding.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, product
from math import exp, gcd, log, pi

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE, Claim
from restir_gi.reference.oracle.diagnosis.naming.numbers import (
    ROUNDINGS,
    Numbers,
    Prediction,
)

MOST_FACTORS, MOST_EXPONENT = 4, 4.0
SAMPLE, POOL, TRIES = 240, 32, 12
"""Wrong numbers that the exponents are tried on; twice how many they are solved from;
and small sets of these for each set of factors: with one row in ten of another kind,
most sets of four have none."""

SIMPLE = 0.99
"""Share of the rows that a product of factors and squares explains, after which no
longer one is sought."""

SURE = 1e-3
"""Largest relative error of a number from which exponents can be told."""

ITSELF = "the right one"
POWERS = {0.5: "the root of", 2.0: "the square of", -1.0: "1 over"}

_FRACTIONS = {
    f"{a}" if b == 1 else f"{a}/{b}": a / b
    for a, b in product(range(1, 17), repeat=2)
    if gcd(a, b) == 1 and (1 in (a, b) or max(a, b) <= 6)
}
_PIS = {"π": pi, "2π": 2 * pi, "3π": 3 * pi, "4π": 4 * pi, "8π": 8 * pi, "π²": pi**2}
_ROOTS = {"√2": 2**0.5, "√π": pi**0.5, "√(2π)": (2 * pi) ** 0.5}
_OVER = {f"1/{name}": 1 / value for name, value in (_PIS | _ROOTS).items()}
CONSTANTS: dict[str, float] = {
    **_FRACTIONS,
    **_PIS,
    **_ROOTS,
    **_OVER,
    "π/2": pi / 2,
    "2/π": 2 / pi,
}
"""Numbers that are told by their names."""


@dataclass(frozen=True, slots=True)
class Monomial:
    """A constant times powers of factors.

    Attributes
    ----------
    constant : float; what the powers are multiplied by, with its sign
    exponents : tuple of (str, float); of factors by name, none of them 0
    """

    constant: float
    exponents: tuple[tuple[str, float], ...]

    def __call__(self, n: Numbers) -> Prediction:
        """The right numbers times this."""
        value, share = np.full(len(n.right), self.constant), np.zeros(len(n.right))
        for name, exponent in self.exponents:
            factor, error = _factor(n, name)
            value = value * factor**exponent
            share = share + abs(exponent) * error
        value = np.where(n.right == 0, 0.0, value * n.right)
        room = n.rounded(value) + np.abs(value) * share
        return value, np.where(n.right == 0, 0.0, room + n.rounding.tiny)

    @property
    def cost(self) -> float:
        """Factors, and halves among the exponents, which are as rare; then exponents.

        A constant that has no name counts as half a factor.
        """
        free = 0.0 if abs(self.constant) in CONSTANTS.values() else 1.0
        sizes = [(abs(e), e % 1) for _, e in self.exponents]
        powers = sum(0.1 * e + 2.0 * half + (e > 2) for e, half in sizes)
        return 2.0 + 2.0 * len(self.exponents) + powers + free

    @property
    def text(self) -> str:
        """What is said of the number."""
        powers = dict(self.exponents)
        itself = powers.pop(ITSELF, 0.0) + 1
        above = [_power(name, e) for name, e in powers.items() if e > 0]
        below = [_power(name, -e) for name, e in powers.items() if e < 0]
        size = abs(self.constant)
        if above and self.constant > 0 and number(size).startswith("1/"):
            below.insert(0, number(size)[2:])
        elif self.constant != 1:
            above.insert(0, ("−" if self.constant < 0 else "") + number(size))
        if itself == 1 and not above:
            return f"is right divided by {' and '.join(below)}"
        under = " · ".join(below)
        under = f" / ({under})" if len(below) > 1 else f" / {under}" if below else ""
        if itself == 0:
            return f"is {' · '.join(above) or '1'}{under}"
        product = f"{' · '.join(above) or '1'}{under}"
        if itself == 1:
            return f"is right times {product}"
        times = "" if product == "1" else f", times {product}"
        power = POWERS.get(itself, f"the power {itself:g} of")
        return f"is {power} what is right{times}"


def _power(name: str, exponent: float) -> str:
    if exponent == 1:
        return name
    if " " in name and name[0] != "(" and not name.startswith("cos "):
        name = f"({name})"
    if exponent == 0.5:
        return f"√{name}"
    marks = {2.0: "²", 3.0: "³", 4.0: "⁴"}
    if name.startswith("cos "):
        return f"cos{marks.get(exponent, f'^{exponent:g}')} {name[4:]}"
    return name + marks.get(exponent, f"^{exponent:g}")


def number(value: float) -> str:
    """A number, by its name if it has one."""
    near = [k for k, c in CONSTANTS.items() if abs(c - value) <= 1e-6 * c]
    return near[0] if near else f"{value:.4g}"


def _factor(n: Numbers, name: str) -> tuple[Scalars, Scalars]:
    """Values and relative errors."""
    if name == ITSELF:
        return n.right, np.zeros(len(n.right))
    factor = n.factors[name]
    return factor.value, np.abs(factor.error / factor.value)


def monomials(n: Numbers) -> Iterator[Claim]:
    """What the quotient of wrong over right may be, the fewest factors first."""
    quotient = n.found / n.right
    sure = n.wrong & (n.allowed < SURE * np.abs(n.right)) & (quotient != 0)
    sure &= np.isfinite(quotient)
    rows: Indices = np.flatnonzero(sure)
    if not len(rows):
        return
    sign = 1.0 if np.median(np.sign(quotient[rows])) >= 0 else -1.0
    rows = rows[quotient[rows] * sign > 0]
    names, rows = _usable(n, rows)
    rows = rows[:: max(1, len(rows) // SAMPLE)]
    if not len(rows):
        return
    ratio = np.log(quotient[rows] * sign)
    table = np.array([np.log(_factor(n, name)[0][rows]) for name in names])
    errors = np.array([_factor(n, name)[1][rows] for name in names])
    room = n.allowed[rows] / np.abs(n.right[rows]) + ROUNDINGS * n.rounding.unit
    fit = _Table(ratio, table.reshape(-1, len(rows)), errors, room)
    for size in range(min(MOST_FACTORS, len(names)) + 1):
        simple = False
        for share, constant, exponents in fit.of(size):
            monomial = Monomial(sign * constant, _named(names, exponents))
            # Of two that hold, that of the factors which are named first.
            places = 0.001 * float(np.flatnonzero(exponents).sum())
            yield Claim(monomial.text, monomial, monomial.cost + places)
            usual = np.isin(np.abs(exponents), (0.0, 1.0, 2.0)).all()
            simple |= share > SIMPLE and bool(usual)
        if simple:
            return


def _named(names: list[str], exponents: Scalars) -> tuple[tuple[str, float], ...]:
    return tuple(
        (name, float(e)) for name, e in zip(names, exponents, strict=True) if e
    )


def _usable(n: Numbers, rows: Indices) -> tuple[list[str], Indices]:
    """Factors that are positive and known, vary, and are no powers of earlier ones.

    One that is the right number itself goes by that name.
    """
    known: dict[str, Masks] = {}
    for name in (*n.factors, ITSELF):
        values, errors = _factor(n, name)
        if name != ITSELF and np.allclose(values[rows], n.right[rows], 1e-5, 0.0):
            continue
        ok = (values[rows] > 0) & np.isfinite(values[rows]) & (errors[rows] < SURE)
        if len(rows) and ok.mean() >= SHARE:
            known[name] = ok
    if known:
        rows = rows[np.all(list(known.values()), axis=0)]
    kept: list[Scalars] = []
    names: list[str] = []
    if len(rows) < 2:
        return names, rows
    for name in known:
        values = np.log(_factor(n, name)[0][rows])
        spread = float(np.ptp(values))
        if spread < SURE:
            continue
        centred = values - values.mean()
        centred /= np.linalg.norm(centred)
        if any(abs(float(centred @ other)) > 1 - 1e-9 for other in kept):
            continue
        kept.append(centred)
        names.append(name)
    return names, rows


@dataclass(frozen=True, slots=True, eq=False)
class _Table:
    """Logarithms of wrong over right, and of F factors, in R rows.

    Attributes
    ----------
    ratio : (R,) float64
    factors, errors : (F, R) float64; and their relative errors
    room : (R,) float64; what rounding may do to the quotient
    """

    ratio: Scalars
    factors: Scalars
    errors: Scalars
    room: Scalars

    def of(self, size: int) -> Iterator[tuple[float, float, Scalars]]:
        """Shares of rows, constants and (F,) exponents, of which ``size`` are not 0."""
        for exponents in self._exponents(size):
            rest = self.ratio - exponents @ self.factors
            room = self.room + np.abs(exponents) @ self.errors
            # Where nine in ten agree, the median is one of them.
            constant = _snapped(float(np.median(rest)), float(np.median(room)))
            inside = np.abs(rest - log(constant)) <= room
            if inside.mean() < SHARE:
                continue
            # Few different quotients could be met by accident.
            different = len(np.unique(np.round(self.ratio[inside], 4)))
            free = constant not in CONSTANTS.values()
            if size and different < size + 1 + 2 * free + (constant != 1):
                continue
            yield float(inside.mean()), constant, exponents

    def _pool(self) -> Indices:
        """Some rows, half of them unlike: where most are alike, these alone tell."""
        _, unlike = np.unique(np.round(self.ratio, 4), return_index=True)
        every = np.arange(len(self.ratio))
        some = [rows[:: max(1, len(rows) // POOL)] for rows in (every, unlike)]
        return np.unique(np.concatenate(some))

    def _exponents(self, size: int) -> Scalars:
        """(C, F): candidates, from small sets of rows."""
        count = len(self.factors)
        none = np.zeros((1, count))
        if size == 0:
            return none
        pool = self._pool()
        if len(pool) < size + 1:
            return none[:0]
        rng = np.random.default_rng(size)
        supports = np.array(list(combinations(range(count), size)))
        orders = np.argsort(rng.random((len(supports) * TRIES, len(pool))), axis=1)
        picked = pool[orders[:, : size + 1]]
        supports = np.repeat(supports, TRIES, axis=0)
        A = self.factors[supports[:, :, None], picked[:, None, :]].transpose(0, 2, 1)
        A = np.concatenate([A, np.ones((*A.shape[:2], 1))], axis=2)
        regular = np.abs(np.linalg.det(A)) > 1e-6
        A, supports, b = A[regular], supports[regular], self.ratio[picked[regular]]
        solved = np.linalg.solve(A, b[:, :, None])[:, :size, 0]
        halves = np.round(2 * solved) / 2
        near = (np.abs(halves - solved) < 0.02) & (halves != 0)
        near &= np.abs(halves) <= MOST_EXPONENT
        ok = near.all(axis=1)
        found = np.zeros((int(ok.sum()), count))
        np.put_along_axis(found, supports[ok], halves[ok], axis=1)
        return np.unique(found, axis=0)


def _snapped(at: float, room: float) -> float:
    """The constant of the list that a logarithm is that of, or its own."""
    near = min(CONSTANTS.values(), key=lambda c: abs(log(c) - at))
    return near if abs(log(near) - at) <= 2 * room else exp(at)
