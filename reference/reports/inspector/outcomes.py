"""What became of a candidate, and why: found again, since the passes keep no log."""

from dataclasses import replace
from enum import IntEnum

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.passes.pixels import NeighborPixels, reconnection
from restir_gi.reference.resampling.reservoir import Candidates


class Outcome(IntEnum):
    """What became of a candidate, in the order in which it is tested."""

    UNTRIED = 0
    ABSENT = 1
    EMPTY = 2
    DARK = 3
    REFUSED = 4
    EDGE_ON = 5
    HIDDEN = 6
    COMPETED = 7


WORDS = {
    Outcome.UNTRIED: "not tried",
    Outcome.ABSENT: "nobody: outside, not similar, or the pixel itself",
    Outcome.EMPTY: "holds no light",
    Outcome.DARK: "sends no light here",
    Outcome.REFUSED: "its Jacobian is beyond the limit",
    Outcome.EDGE_ON: "its Jacobian is 0",
    Outcome.HIDDEN: "hidden from here",
    Outcome.COMPETED: "competed",
}
"""Outcomes as they are read."""


def jacobians(source: object, rows: int) -> tuple[Scalars, Scalars]:
    """How candidates came to their pixels.

    Parameters
    ----------
    rows : int; K

    Returns
    -------
    (K,), (K,) float64, sr/sr
        Factor on W, 1 where nothing is shifted and 0 where the shift is refused; and
        Equation 11 itself.
    """
    if not isinstance(source, NeighborPixels):
        return np.ones(rows), np.ones(rows)
    exact = replace(source, q=replace(source.q, shift=reconnection))
    return source.jacobian(), exact.jacobian()


def outcomes(c: Candidates, empty: Scalars, factor: Scalars, exact: Scalars) -> Indices:
    """What became of the candidates in one slot of the stream.

    Parameters
    ----------
    empty : (K,) bool; the reservoir holds no light
    factor, exact : (K,) float64, sr/sr; as of `jacobians`

    Returns
    -------
    (K,) int; of `Outcome`; the first reason there is
    """
    reasons = {
        Outcome.ABSENT: c.M <= 0,
        Outcome.EMPTY: empty,
        Outcome.DARK: c.p_hat <= 0,
        Outcome.REFUSED: (factor <= 0) & (exact > 0),
        Outcome.EDGE_ON: factor <= 0,
        Outcome.HIDDEN: c.w <= 0,
    }
    return np.select(list(reasons.values()), list(reasons), Outcome.COMPETED)
