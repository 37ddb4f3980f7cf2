"""Exact enumeration: run whole-array code on every outcome of its random numbers.

A program takes N rows of an outcome and a source of uniforms, and returns N rows.  Its
uniforms are symbols of which only their answers so far are known.  Each comparison that
they cannot answer yet splits a row in two, with rational probabilities, so that kernels
meant for arrays of floats are integrated without a single rounding.

>>> def program(rows, uniform):
...     return np.where(uniform() * Fraction(3) < rows, "taken", "left")
>>> law = explore(program, Law.certain(Fraction(2)))
>>> [(str(row), str(p)) for (row,), p in law.as_dict().items()]
[('taken', '2/3'), ('left', '1/3')]
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from restir_gi.reference.numerics.records import concatenate, map_rows, take

ZERO, ONE = Fraction(0), Fraction(1)


@dataclass(frozen=True, slots=True)
class Law:
    """Distribution with finitely many outcomes.

    Attributes
    ----------
    outcomes : record or array
        N rows, all different.
    probability : (N,) object
        Positive ``Fraction``; their sum is 1.
    """

    outcomes: Any
    probability: Any

    @classmethod
    def certain(cls, outcome):
        """Law of something that is no accident: one row, of an array."""
        row = np.empty(1, object)
        row[0] = outcome
        return cls(row, np.array([ONE]))

    def mean(self, values):
        """Expectation Σ p v of the numbers that rows have."""
        return sum((p * v for p, v in zip(self.probability, values, strict=True)), ZERO)

    def as_dict(self):
        """Probability of each outcome, by the tuple of its fields."""
        keys = zip(*flatten(self.outcomes), strict=True)
        return dict(zip(keys, self.probability, strict=True))


def explore(program, start):
    """Law of what a program returns.

    Parameters
    ----------
    program : callable
        ``program(rows, uniform)`` takes N rows of the start's outcomes and a function
        that makes N fresh uniforms at each call; it returns N rows.  What it does with
        a row may depend on that row alone.
    start : Law
        Where it begins.

    Returns
    -------
    Law
        Equal outcomes are one row.

    Notes
    -----
    Rows are replayed with longer and longer lists of given answers.  A decision beyond
    the list is answered with yes, and the same row is put into the next batch with a
    no.  So each path runs once, and the kernels always see arrays.
    """
    parts, probabilities = [], []
    rows, scripts = list(range(len(start.probability))), [()] * len(start.probability)
    while rows:
        paths = [_Path(script) for script in scripts]
        index = np.array(rows)
        parts.append(program(take(start.outcomes, index), _uniforms(paths)))
        weight = np.array([path.probability for path in paths], object)
        probabilities.append(start.probability[index] * weight)
        branches = [(r, s) for r, p in zip(rows, paths, strict=True) for s in p.others]
        rows, scripts = [r for r, _ in branches], [s for _, s in branches]
    law = _collapse(Law(concatenate(parts), np.concatenate(probabilities)))
    assert sum(law.probability) == 1
    return law


def flatten(record):
    """Columns of a record: its fields' arrays, nested ones included."""
    columns = []

    def keep(array):
        columns.append(array)
        return array

    map_rows(keep, record)
    return columns


def _collapse(law):
    first, total = {}, []
    for row, key in enumerate(zip(*flatten(law.outcomes), strict=True)):
        place = first.setdefault(key, len(total))
        if place == len(total):
            total.append([row, ZERO])
        total[place][1] += law.probability[row]
    rows = np.array([row for row, _ in total])
    return Law(take(law.outcomes, rows), np.array([p for _, p in total], object))


# ---------------------------------------------------------------- symbolic uniforms


@dataclass(slots=True)
class _Path:
    """One way through the program: its answers, and where others branch off."""

    script: tuple[bool, ...]
    asked: list[bool] = field(default_factory=list)
    others: list[tuple[bool, ...]] = field(default_factory=list)
    probability: Fraction = ONE

    def answer(self, yes: Fraction) -> bool:
        """Answer a question whose answer is yes with a given probability."""
        if len(self.asked) < len(self.script):
            given = self.script[len(self.asked)]
        else:
            given = True
            self.others.append((*self.asked, False))
        self.asked.append(given)
        self.probability *= yes if given else 1 - yes
        return given


@dataclass(slots=True, eq=False)
class Uniform:
    """Number uniform on [0, 1), of which each comparison tells a little more.

    It lies in [low, high): a program that asks the same number twice gets answers
    that fit together.
    """

    path: _Path
    low: Fraction = ZERO
    high: Fraction = ONE

    def __mul__(self, factor: Fraction) -> "_Scaled":
        """Return u · factor, for comparison with another number."""
        return _Scaled(self, factor)

    __rmul__ = __mul__

    def __lt__(self, bound: Fraction) -> bool:
        """Whether u < bound; splits the row where that is still open."""
        if bound >= self.high or bound <= self.low:
            return bound >= self.high
        share = (bound - self.low) / (self.high - self.low)
        below = self.path.answer(share)
        if below:
            self.high = Fraction(bound)
        else:
            self.low = Fraction(bound)
        return below

    def __le__(self, bound: Fraction) -> bool:
        """Whether u <= bound: as ``<``, but on a set of measure 0."""
        return self < bound

    def __ge__(self, bound: Fraction) -> bool:
        """Whether u >= bound."""
        return not self < bound

    def __gt__(self, bound: Fraction) -> bool:
        """Whether u > bound."""
        return not self <= bound


@dataclass(slots=True, eq=False)
class _Scaled:
    """u · factor, waiting to be compared."""

    u: Uniform
    factor: Fraction

    def __lt__(self, bound: Fraction) -> bool:
        if self.factor == 0:
            return bound > 0
        return self.u < Fraction(bound) / self.factor

    def __le__(self, bound: Fraction) -> bool:
        if self.factor == 0:
            return bound >= 0
        return self.u <= Fraction(bound) / self.factor

    def __ge__(self, bound: Fraction) -> bool:
        return not self < bound

    def __gt__(self, bound: Fraction) -> bool:
        return not self <= bound


def _uniforms(paths: list[_Path]) -> Callable[[], Any]:
    def uniform():
        rows = np.empty(len(paths), object)
        rows[:] = [Uniform(path) for path in paths]
        return rows

    return uniform


def draw(u, probabilities):
    """Index drawn by inversion of a table, one symbolic uniform a row.

    Parameters
    ----------
    u : (N,) Uniform
        One each.
    probabilities : sequence of Fraction
        What is left to 1 is the probability of one index more.

    Returns
    -------
    (N,) int
        From 0 to ``len(probabilities)``.
    """
    cumulative = np.cumsum(np.array(probabilities, object))

    def invert(v):
        return next((i for i, c in enumerate(cumulative) if v < c), len(cumulative))

    return np.array([invert(v) for v in u])
