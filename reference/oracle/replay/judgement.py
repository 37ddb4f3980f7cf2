"""What a replay finds: numbers side by side, and decisions within rounding."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import pdtr, pdtrik

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded

BUDGET_ALARM = 1e-6
"""Probability that a right backend has more open decisions than its budget."""


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """One buffer beside what it should be, N rows.

    Attributes
    ----------
    found : (N, ...) array; by the backend
    expected : (N, ...) array; by the contract, from the same inputs
    allowed : (N, ...) array; largest difference that rounding explains
    """

    name: str
    found: NDArray[Any]
    expected: NDArray[Any]
    allowed: NDArray[Any]

    @property
    def excess(self) -> Scalars:
        """(N,): largest difference of a row, in units of what is allowed."""
        difference = np.abs(self.found.astype(np.float64) - self.expected)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(difference > 0, difference / self.allowed, 0.0)
        # Column by column: a row has few numbers, which is slow along the last axis.
        largest = np.zeros(len(ratio))
        for column in ratio.reshape(len(ratio), -1).T:
            largest = np.maximum(largest, column)
        return largest


@dataclass(frozen=True, slots=True, eq=False)
class Decisions:
    """Choices that the rows made, N rows.

    Attributes
    ----------
    illegal : (N,) bool; no rounding explains the choice
    differing : int; choices that differ from the exact rule within rounding
    expected : float
        Mean number of decisions that rounding leaves open, if u are random.
    what : str; that was decided, for messages
    """

    illegal: Masks
    differing: int
    expected: float
    what: str = "which sample was kept"

    @property
    def budget(self) -> int:
        """Differing choices that a right backend exceeds at rate `BUDGET_ALARM`."""
        return poisson_quantile(1 - BUDGET_ALARM, self.expected)


def poisson_quantile(probability: float, mean: float) -> int:
    """Least k with P(X ≤ k) ≥ p, of a Poisson distribution.

    By its own functions: all of ``scipy.stats`` takes as long to import as a quick
    check to run.
    """
    if mean == 0:
        return 0
    above = int(np.ceil(pdtrik(probability, mean)))
    below = max(above - 1, 0)
    return below if pdtr(below, mean) >= probability else above


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """All that the replay of a case has found.

    Attributes
    ----------
    compared : tuple of Compared; every output of the pass
    terms : mapping of str to (N,) or (N, ...) array
        What the expected values are made of, for the report.
    decisions : Decisions or None; of passes that choose
    counted : bool
        Differing choices count against the budget: the decisions were random.
    """

    compared: tuple[Compared, ...]
    terms: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    decisions: Decisions | None = None
    counted: bool = False

    @property
    def wrong(self) -> Masks:
        """(N,) bool: rows that no rounding explains."""
        bad: Masks = np.any([c.excess > 1 for c in self.compared], axis=0)
        if self.decisions is not None:
            bad = bad | self.decisions.illegal
        return bad

    @property
    def over_budget(self) -> bool:
        """More choices lean on rounding than rounding leaves open."""
        if self.decisions is None or not self.counted:
            return False
        return self.decisions.differing > self.decisions.budget

    @property
    def passed(self) -> bool:
        """No row is wrong, and the differing choices are within their budget."""
        return not self.over_budget and not self.wrong.any()


def beside(name: str, found: NDArray[Any], expected: Bounded) -> Compared:
    """A buffer beside bounded numbers, whose bound is what is allowed.

    Parameters
    ----------
    expected : Bounded; of the same shape
    found : (N, ...) array; by the backend
    """
    return Compared(name, found, expected.value, expected.error)


def of_light(compared: Compared, light: NDArray[Any]) -> Compared:
    """Weights that are looked at where there is light to weigh.

    The target of a null is 0 wherever it is reused, and so is what it shows: nothing
    tells its W, as long as that is no less than 0.

    Parameters
    ----------
    light : (N, 3) array; radiance of the sample that W belongs to
    """
    unseen = ~light.any(axis=1) & (compared.found >= 0)
    return replace(compared, allowed=np.where(unseen, np.inf, compared.allowed))


def exactly(name: str, found: NDArray[Any], expected: NDArray[Any]) -> Compared:
    """A buffer beside numbers that leave no room: nothing is allowed.

    Parameters
    ----------
    found, expected : (N, ...) array; by the backend, and by the contract
    """
    wide = expected.astype(np.float64)
    return Compared(name, found, wide, np.zeros_like(wide))


def between(
    name: str, found: NDArray[Any], least: NDArray[Any], most: NDArray[Any]
) -> Compared:
    """Whole numbers, of which rounding may leave open whether they are one or another.

    Parameters
    ----------
    found : (N, ...) array; by the backend
    least, most : (N, ...) array; the first and the last that are right
    """
    return Compared(name, found, (least + most) / 2, (most - least) / 2)


def in_rows(rows: Masks, compared: Compared) -> Compared:
    """The same in some rows; the others are not looked at.

    Parameters
    ----------
    rows : (N,) bool; that are looked at
    """
    looked_at = rows.reshape(rows.shape + (1,) * (compared.allowed.ndim - 1))
    return replace(compared, allowed=np.where(looked_at, compared.allowed, np.inf))


def either(name: str, found: NDArray[Any], positive: Bounded) -> Compared:
    """A flag beside the number whose sign it tells.

    Parameters
    ----------
    found : (N,) array; 0 or 1, by the backend
    positive : Bounded; (N,), above 0 where the flag is 1

    Returns
    -------
    Compared; both are allowed where the sign is within the bound of error
    """
    sure = positive.surely_positive | positive.surely_not_positive
    expected = (positive.value > 0).astype(np.float64)
    return Compared(name, found, expected, np.where(sure, 0.0, 1.0))
