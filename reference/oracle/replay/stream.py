"""Replay of a stream of weights: who may be kept, and what rounding leaves open."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.rules import Rules


class Weighted(Protocol):
    """A competitor: its weight, and the number that decides on it, (N,) each."""

    @property
    def w(self) -> Bounded:
        """Weight, not negative."""

    @property
    def u(self) -> Bounded:
        """In [0, 1)."""


def sums_of(slots: Sequence[Weighted], rules: Rules) -> list[Bounded]:
    """Running sums of weights, as many; the last is that of all.

    Parameters
    ----------
    slots : sequence of Weighted; in the order of the stream
    """
    sums = [slots[0].w]
    for slot in slots[1:]:
        sums.append(rules.merged_weight(sums[-1], slot.w))
    return sums


def choices_of(
    slots: Sequence[Weighted], sums: list[Bounded], rules: Rules
) -> tuple[Masks, Indices]:
    """Who is kept.

    Parameters
    ----------
    slots : sequence of Weighted; S, in the order of the stream

    Returns
    -------
    may : (S, N) bool; whether rounding allows that each slot is
    exactly : (N,) int; which one is in exact arithmetic
    """
    rows = len(slots[0].w.value)
    may = np.zeros((len(slots), rows), bool)
    may[0] = True
    exactly = np.zeros(rows, np.int64)
    for k, slot in enumerate(slots[1:], start=1):
        prefers = rules.preference(slot.u, sums[k - 1], slot.w)
        alone = (sums[k - 1].value == 0) & (slot.w.value > 0)
        # A weight that rounding cannot tell from 0 may be 0, and then it is not kept.
        may[:k] &= ~(prefers.surely_positive | alone & slot.w.surely_positive)
        may[k] = ~prefers.surely_not_positive & (slot.w.value + slot.w.error > 0)
        exactly = np.where((prefers.value > 0) | alone, k, exactly)
    return may, exactly


STEP = 2.0**-24
"""Between the numbers that pass ``random`` gives."""


def at_an_end(u: Scalars) -> Masks:
    """Whether numbers are the smallest or the largest of all, (N, ...) bool.

    Cases ask for these on purpose, and rounding leaves more open there; a random number
    is one of them so rarely that nothing is lost.

    Parameters
    ----------
    u : (N, ...) float64; as pass ``random`` gives them
    """
    ends: Masks = (u <= 0) | (u >= 1 - STEP)
    return ends


def by_chance(slots: Sequence[Weighted]) -> Masks:
    """Rows whose decisions hang on random numbers alone, (N,) bool.

    Not those with a number at an end, nor those of which rounding leaves open whether a
    weight is 0.

    Parameters
    ----------
    slots : sequence of Weighted; in the order of the stream
    """
    ends = [at_an_end(slot.u.value) for slot in slots[1:]]
    unsure = [(s.w.value > 0) & ~s.w.surely_positive for s in slots]
    found: Masks = ~np.any([*ends, *unsure], axis=0)
    return found


def left_open(slots: Sequence[Weighted], sums: list[Bounded]) -> float:
    """Mean number of decisions that rounding leaves open: 2 error / S, for random u.

    Rows that are not `by_chance` are left out, as they are by those who count.

    Parameters
    ----------
    slots : sequence of Weighted; in the order of the stream
    """
    mean, counted = 0.0, by_chance(slots)
    for k, slot in enumerate(slots[1:], start=1):
        S = sums[k]
        margin = slot.w - slot.u * S
        here = (S.value > 0) & (slot.w.value > 0) & (sums[k - 1].value > 0)
        here &= counted
        share = np.divide(
            2 * margin.error, S.value, out=np.zeros_like(S.value), where=here
        )
        mean += float(np.minimum(share, 1.0).sum())
    return mean
