"""What wrong numbers have to do with right ones, in one short sentence."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import lgamma, log
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.diagnosis.naming.numbers import Numbers, Prediction

SHARE = 0.9
"""Of the wrong rows, which a sentence must explain to be told."""

CHANCE, CHANCE_OF_NAMED = log(1e-9), log(1e-5)
"""Logarithms of the largest probability that a threshold, or a condition that has a
name, separates rows by accident: there are some hundred of the first, and few of the
second."""

ToldOf = Literal["all", "some", "any"]


@dataclass(frozen=True, slots=True, eq=False)
class Claim:
    """What the numbers may be in place of right.

    Attributes
    ----------
    text : str; goes on from the number's name: "is right times 2"
    predict : callable; from `Numbers`, whose ``found`` it does not read
    cost : float; the simpler the lower
    told_of : 'all', 'some' or 'any'
        Rows: all, or those under a condition that has a name, or any threshold.
    """

    text: str
    predict: Callable[[Numbers], Prediction]
    cost: float
    told_of: ToldOf = "any"


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """Where a claim holds.

    Attributes
    ----------
    text : str; "where J > 10", or empty
    holds : callable; from `Numbers` to (R,) bool
    """

    text: str
    holds: Callable[[Numbers], Masks]


EVERYWHERE = Condition("", lambda n: np.ones(len(n.right), bool))


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A claim that holds.

    Attributes
    ----------
    rows, of : int; wrong rows that it explains, of how many
    """

    claim: Claim
    condition: Condition
    rows: int
    of: int

    @property
    def share(self) -> float:
        """Of the wrong rows."""
        return self.rows / self.of

    @property
    def cost(self) -> float:
        """The simpler the lower."""
        return self.claim.cost + 1.5 * bool(self.condition.text)

    @property
    def text(self) -> str:
        """What is so, and where."""
        return f"{self.claim.text} {self.condition.text}".rstrip()

    def predicted(self, numbers: Numbers) -> Prediction:
        """Numbers that a backend with this mistake has."""
        value, room = self.claim.predict(numbers)
        here = self.condition.holds(numbers)
        return np.where(here, value, numbers.right), np.where(here, room, 0.0)


def fitted(numbers: Numbers, claims: Iterator[Claim]) -> Fit | None:
    """The simplest of the claims that explain most wrong rows, if any explains enough.

    Rows that are right must be so by the claim too, or be told apart by a condition.
    """
    fits = [fit for claim in claims if (fit := _fit(numbers, claim)) is not None]
    best: Fit | None = min(fits, key=_preference, default=None)
    return best


def _preference(fit: Fit) -> tuple[float, float]:
    return -round(fit.share, 2), fit.cost


def _fit(numbers: Numbers, claim: Claim) -> Fit | None:
    value, room = claim.predict(numbers)
    # Who has more than the largest number may hold any that is nearly as large.
    large = np.sign(value) * np.sign(numbers.found) > 0
    large &= np.minimum(np.abs(value), np.abs(numbers.found)) > numbers.most / 4
    agrees = large | (np.abs(numbers.found - value) <= room)
    # Where nearly everything agrees, nothing is explained.
    sharp = large | (2 * room <= np.abs(numbers.found - numbers.right))
    explained = numbers.wrong & agrees & sharp
    missed = numbers.row[numbers.wrong & ~explained]
    rows = np.setdiff1d(numbers.row[explained], missed)
    of = numbers.wrong_rows
    if not of or len(rows) < SHARE * of:
        return None
    # Right rows tell where the claim is beyond what they leave open.
    told = np.abs(value - numbers.right) > 2 * (numbers.allowed + room)
    broken = numbers.clear & ~numbers.wrong & ~agrees & told
    condition = _condition(numbers, explained, broken, claim.told_of)
    return Fit(claim, condition, len(rows), of) if condition is not None else None


def _condition(
    numbers: Numbers, yes: Masks, no: Masks, told_of: ToldOf
) -> Condition | None:
    """What holds in all rows of one kind, and in none of the other."""
    if not no.any():
        return EVERYWHERE
    if told_of == "all":
        return None
    chance = _chance(int(yes.sum()), int(no.sum()))
    for name, mask in numbers.conditions.items():
        if mask[yes].all() and not mask[no].any() and chance < CHANCE_OF_NAMED:
            return _named(name)
    if told_of == "some" or chance > CHANCE:
        return None
    known = {"the right one": numbers.right}
    known |= {name: factor.value for name, factor in numbers.factors.items()}
    for name, values in known.items():
        found = _threshold(name, values[yes], values[no])
        if found is not None:
            return found
    return None


def _named(name: str) -> Condition:
    def holds(n: Numbers) -> Masks:
        return n.conditions.get(name, np.zeros(len(n.right), bool))

    return Condition(f"where {name}", holds)


def _chance(a: int, b: int) -> float:
    """Logarithm of the probability that a of a + b shuffled rows come first."""
    return lgamma(a + 1) + lgamma(b + 1) - lgamma(a + b + 1)


def _threshold(name: str, yes: Scalars, no: Scalars) -> Condition | None:
    if not (np.isfinite(yes).all() and np.isfinite(no).all()):
        return None

    def value(n: Numbers) -> Scalars:
        return n.right if name == "the right one" else n.factors[name].value

    if yes.min() == yes.max() and yes[0] not in no:
        at = float(yes[0])
        return Condition(f"where {name} is {at:.4g}", lambda n: value(n) == at)
    if yes.min() > no.max():
        at = between(float(no.max()), float(yes.min()))
        return Condition(f"where {name} > {at:.4g}", lambda n: value(n) > at)
    if yes.max() < no.min():
        at = -between(-float(no.min()), -float(yes.max()))
        return Condition(f"where {name} < {at:.4g}", lambda n: value(n) < at)
    return None


def between(a: float, b: float) -> float:
    """The number with the fewest digits from a on and below b."""
    if a <= 0 < b:
        return 0.0
    for digits in range(9):
        for x in (a, (a + b) / 2, b):
            at = float(f"{x:.{digits}e}")
            if a <= at < b:
                return at
    return a
