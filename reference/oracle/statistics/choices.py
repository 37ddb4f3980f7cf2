"""Evidence against the chances that weights give to choices.

Rows draw independently, given what they were given: row i keeps a candidate with
probability pᵢ = wᵢ / Σw.  For any number λ that is fixed before the choices are made,
Π exp(λ xᵢ) / (1 + pᵢ (e^λ − 1)) has expectation 1, where xᵢ is 1 if the candidate was
kept and else 0.  So it is at least 1/α with probability α at most, however large or
small the pᵢ are.  Frames may follow one another: the pᵢ of the next one hang on what
was kept in the last, and the product stays fair.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars

BETS = (6.0, 9.0)
"""λ times the standard deviation of the number of wins: where the logarithm of the
product, c z − c²/2 for an excess of z deviations, reaches that of 1e-6 or less."""

LARGEST = 20.0
"""Of λ: a candidate without variance is bet on no more than that."""


@dataclass(frozen=True, slots=True, eq=False)
class Chances:
    """Choices of some rows in one frame, and the chances that they had, N rows.

    Attributes
    ----------
    won : (N,) bool; the candidate was kept
    low, high : (N,) float64; bounds on its probability, to rounding
    """

    won: Masks
    low: Scalars
    high: Scalars

    def of(self, rows: Masks) -> "Chances":
        """Those of some rows.

        Parameters
        ----------
        rows : (N,) bool
        """
        return Chances(self.won[rows], self.low[rows], self.high[rows])

    @property
    def middle(self) -> Scalars:
        """(N,): the probability, but for rounding."""
        return (self.low + self.high) / 2


@dataclass(frozen=True, slots=True)
class Wins:
    """How often a candidate was kept, beside how often it should have been.

    Attributes
    ----------
    rows, kept : int; choices that were looked at, and wins among them
    expected, deviation : float; mean and standard deviation of the number of wins
    log_e : float
        Logarithm of the evidence e: E e ≤ 1 if the chances are as they are said to be.
    """

    rows: int
    kept: int
    expected: float
    deviation: float
    log_e: float

    @property
    def excess(self) -> float:
        """Relative difference of the wins from their mean."""
        return (self.kept - self.expected) / self.expected if self.expected else np.inf


def wins(frames: Iterable[Chances], count: int) -> Wins:
    """Evidence against the chances of some rows, over all frames.

    Parameters
    ----------
    count : int; of frames, as far as it is known beforehand: it sets the bets, and is
        no part of what is proved
    """
    logs = np.zeros((2, len(BETS)))
    rows, kept, expected, variance = 0, 0, 0.0, 0.0
    for one in frames:
        p = one.middle
        of_frame = float((p * (1 - p)).sum())
        rows, kept = rows + len(p), kept + int(one.won.sum())
        expected, variance = expected + float(p.sum()), variance + of_frame
        logs += _gains(one, of_frame * count)
    log_e = float(np.logaddexp.reduce(logs, axis=None) - np.log(logs.size))
    return Wins(rows, kept, expected, float(np.sqrt(variance)), log_e)


def _gains(one: Chances, variance: float) -> Scalars:
    """What each bet gains in a frame, (2, bets): on too many wins, and on too few."""
    found = np.zeros((2, len(BETS)))
    deviation = np.sqrt(variance) if variance > 0 else 0.0
    kept = float(one.won.sum())
    for k, c in enumerate(BETS):
        bet = min(c / deviation, LARGEST) if deviation else LARGEST
        many = np.log1p(one.high * np.expm1(bet)).sum()
        few = np.log1p(one.low * np.expm1(-bet)).sum()
        found[:, k] = bet * kept - many, -bet * kept - few
    return found
