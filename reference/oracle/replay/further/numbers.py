"""Settings, vectors and choices, on numbers with error bounds."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant
from restir_gi.reference.oracle.replay.judgement import Decisions
from restir_gi.reference.oracle.replay.verbs import inner, square_root


def setting(value: Value, rounding: Rounding) -> Bounded:
    """A number that holds for all rows.

    (1,): one rounding, or none where float32 holds the number.
    """
    wide = np.array([float(value)])
    held = wide.astype(np.float32) == wide
    error = np.where(held, 0.0, rounding.unit * np.abs(wide))
    return Bounded(wide, error, rounding)


def product(a: Bounded, b: Bounded) -> Bounded:
    """Vector product of the rows of two arrays of vectors, (N, 3).

    Parameters
    ----------
    a, b : Bounded; (N, 3) each; either may have one row
    """
    plus = a[:, [1, 2, 0]] * b[:, [2, 0, 1]]
    minus = a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
    return plus - minus


def unit(v: Bounded) -> Bounded:
    """Vectors of length 1, (N, 3).

    Parameters
    ----------
    v : Bounded; (N, 3)
    """
    return v / square_root(inner(v, v))[:, None]


def larger(a: Bounded, b: Bounded) -> Bounded:
    """The larger of two numbers.

    A maximum moves by no more than the one of the two that moves most.
    """
    value, error = np.maximum(a.value, b.value), np.maximum(a.error, b.error)
    return Bounded(value, error, a.rounding)


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """A yes or no of each row.

    Attributes
    ----------
    own : (N,) bool; without rounding
    certain : (N,) bool; rounding does not change it; the others are open
    """

    own: Masks
    certain: Masks

    def settled(self, found: Masks) -> Masks:
        """What to go on with, (N,) bool; the backend's, where it is open.

        Parameters
        ----------
        found : (N,) bool; choice of the backend
        """
        return np.where(self.certain, self.own, found)

    def decisions(self, found: Masks) -> Decisions:
        """The backend's choices, whose faults stand in the buffers themselves.

        Parameters
        ----------
        found : (N,) bool; choice of the backend

        Returns
        -------
        Decisions; no more rows can differ than are open, so that all may
        """
        differing = ~self.certain & (found != self.own)
        none = np.zeros(len(self.own), bool)
        return Decisions(none, int(differing.sum()), float((~self.certain).sum()))


def where_not_negative(slack: Bounded) -> Choice:
    """Yes where a number is at least 0.  An exact 0 is a certain yes."""
    own = slack.value >= 0
    with np.errstate(invalid="ignore"):
        yes, no = slack.value - slack.error >= 0, slack.value + slack.error < 0
    return Choice(own, yes | no)


def where_none_negative(slack: Bounded) -> Choice:
    """Yes where none of a row's numbers is below 0, (N,): one certain no is enough.

    Parameters
    ----------
    slack : Bounded; (N,) or (N, K)
    """
    each = where_not_negative(slack)
    rows = (len(each.own), -1)
    own, certain = each.own.reshape(rows), each.certain.reshape(rows)
    no = np.any(certain & ~own, axis=1)
    return Choice(np.all(own, axis=1), np.all(certain, axis=1) | no)


def where_all_positive(tests: list[Bounded]) -> Choice:
    """Yes where several numbers are above 0.  One certain no is enough."""
    yes = np.all([test.surely_positive for test in tests], axis=0)
    no = np.any([test.surely_not_positive for test in tests], axis=0)
    own = np.all([test.value > 0 for test in tests], axis=0)
    return Choice(own, yes | no)


def bounded_somehow(x: Bounded) -> Bounded:
    """Numbers of which nothing is known where the bound itself is no number.

    Infinity times 0 in a bound becomes infinity.
    """
    unknown = np.isnan(x.error) | np.isnan(x.value)
    value = np.where(np.isfinite(x.value), x.value, 0.0)
    return Bounded(value, np.where(unknown, np.inf, x.error), x.rounding)


def moved(x: Bounded, by: float) -> Bounded:
    """Numbers and a literal added to them, of the same shape.

    Parameters
    ----------
    by : float; 0 for none, which rounds nothing
    """
    return x + constant(by, x) if by else x
