"""Numbers of many rows beside what they should be, with what is known of each."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.naming.factors import RowFacts
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, rounding_of

CLEAR = 0.01
"""Share of a number that rounding may change: beyond, nobody knows what is right."""

ROUNDINGS = 16
"""Of a backend that calculates a product of factors in place of the right number."""

# Numbers, and how far rounding may take a backend's from them.
Prediction = tuple[Scalars, Scalars]


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """A number of each row beside what it should be; R of them, of all cases.

    Attributes
    ----------
    name : str; in the words of the contract
    found, right, allowed : (R,) float64
        By the backend, by the contract, and the difference that rounding explains.
    factors : mapping of str to (R,) Bounded; what the right number is made of
    conditions : mapping of str to (R,) bool; what may be so in a row
    other_rows : mapping of str to (R,) float64; the right numbers of other rows
    row : (R,) int; to which row of which case a number belongs
    rounding : Rounding; of the backend's arithmetic
    most : float; the largest number of its type
    clear, wrong : (R,) bool
        Where rounding leaves the right number as it is, and where that was missed.
    """

    name: str
    found: Scalars
    right: Scalars
    allowed: Scalars
    factors: Mapping[str, Bounded]
    conditions: Mapping[str, Masks]
    other_rows: Mapping[str, Scalars]
    row: Indices
    rounding: Rounding
    most: float
    clear: Masks = field(init=False)
    wrong: Masks = field(init=False)

    def __post_init__(self) -> None:
        """Which right numbers are known well, and which of these are missed."""
        clear = self.allowed <= CLEAR * np.abs(self.right)
        object.__setattr__(self, "clear", clear)
        wrong = clear & (np.abs(self.found - self.right) > self.allowed)
        object.__setattr__(self, "wrong", wrong)

    @property
    def wrong_rows(self) -> int:
        """How many rows have a wrong number."""
        return len(np.unique(self.row[self.wrong]))

    def rounded(self, value: Scalars, roundings: float = ROUNDINGS) -> Scalars:
        """Room for some roundings of numbers, and for what is allowed of the right one.

        Parameters
        ----------
        value : (R,) float64; in place of the right numbers

        Returns
        -------
        (R,) float64
        """
        share = np.abs(self.allowed / self.right)
        share = np.where(np.isfinite(share), share, 0.0)
        room: Scalars = np.abs(value) * (share + roundings * self.rounding.unit)
        return room


@dataclass(frozen=True, slots=True, eq=False)
class CaseNumbers:
    """Numbers of R rows of a case.

    Attributes
    ----------
    found, right, allowed : (R,) float64; as in `Numbers`
    factors, conditions, other_rows : mapping of str to (R,) array; likewise
    row : (R,) int; counted over all cases
    """

    found: Scalars
    right: Scalars
    allowed: Scalars
    factors: Mapping[str, Bounded]
    conditions: Mapping[str, Masks]
    other_rows: Mapping[str, Scalars]
    row: Indices


def part_of(
    found: NDArray[Any],
    right: NDArray[Any],
    allowed: NDArray[Any],
    facts: RowFacts,
    rows: Indices,
    start: int,
) -> CaseNumbers:
    """Some rows of a case, component by component.

    Parameters
    ----------
    found, right, allowed : (N, ...) array; of one shape
    facts : RowFacts; of N rows; those of another shape are left out
    rows : (K,) int; which of them
    start : int; number of the case's first row among those of all cases
    """
    shape = right.shape

    def flat(values: NDArray[Any]) -> NDArray[Any]:
        wide = values.reshape(values.shape + (1,) * (len(shape) - values.ndim))
        return np.broadcast_to(wide, shape)[rows].reshape(-1)

    def fits(values: NDArray[Any]) -> bool:
        return values.ndim == 1 or values.shape == shape

    others = {
        "the row before": np.roll(right, 1, axis=0),
        "the row after": np.roll(right, -1, axis=0),
        "the first row": np.broadcast_to(right[:1], shape),
    }
    factors, conditions = facts.factors.items(), facts.conditions.items()
    return CaseNumbers(
        flat(found.astype(np.float64)),
        flat(right.astype(np.float64)),
        flat(allowed.astype(np.float64)),
        {
            name: Bounded(flat(f.value), flat(f.error), f.rounding)
            for name, f in factors
            if fits(f.value)
        },
        {name: flat(mask) for name, mask in conditions if fits(mask)},
        {name: flat(values) for name, values in others.items()},
        flat(np.arange(len(right)) + start),
    )


def joined(name: str, parts: list[CaseNumbers], precision: Precision) -> Numbers:
    """The numbers of all cases, with what is known of all of them.

    Parameters
    ----------
    parts : list of CaseNumbers; at least one
    """
    rounding = rounding_of(precision)

    def shared(which: str) -> list[str]:
        first, *rest = (getattr(p, which) for p in parts)
        return [key for key in first if all(key in other for other in rest)]

    def of_all(which: str, key: str) -> NDArray[Any]:
        return np.concatenate([getattr(p, which)[key] for p in parts])

    def factor(key: str) -> Bounded:
        found = [p.factors[key] for p in parts]
        value = np.concatenate([f.value for f in found])
        return Bounded(value, np.concatenate([f.error for f in found]), rounding)

    named = [key for p in parts for key in p.conditions]

    def condition(key: str) -> Masks:
        """Not so where it is not known of a case."""
        none = [np.zeros(len(p.found), bool) for p in parts]
        found = [p.conditions.get(key, n) for p, n in zip(parts, none, strict=True)]
        return np.concatenate(found)

    return Numbers(
        name=name,
        found=np.concatenate([p.found for p in parts]),
        right=np.concatenate([p.right for p in parts]),
        allowed=np.concatenate([p.allowed for p in parts]),
        factors={key: factor(key) for key in shared("factors")},
        conditions={key: condition(key) for key in dict.fromkeys(named)},
        other_rows={key: of_all("other_rows", key) for key in shared("other_rows")},
        row=np.concatenate([p.row for p in parts]),
        rounding=rounding,
        most=float(np.finfo(precision).max),
    )
