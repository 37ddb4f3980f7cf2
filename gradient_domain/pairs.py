"""Pairs of neighbouring pixels: each one and its right one, each and its lower one."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from gradient_domain.differences import Differences
from reference.arrays import Indices, Scalars, Vec3s
from reference.records import NONE, scatter


class Axis(IntEnum):
    """Which way a pair goes: to the right neighbour, or to the lower one."""

    X = 0
    Y = 1


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pixel pairs (i, j), P rows.

    Attributes
    ----------
    first, second : (P,) int; i and j, rows of the image
    axis : (P,) int8; `Axis`
    dx, dy : (P,) float64, pixels; from i to j
    """

    first: Indices
    second: Indices
    axis: Indices
    dx: Scalars
    dy: Scalars

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.first)


def pixel_pairs(width: int, height: int) -> Pairs:
    """All pairs of an image.

    H (W − 1) horizontal ones, then (H − 1) W vertical ones, each in the order of their
    first pixels: none leads out of the image.
    """
    rows = np.arange(width * height).reshape(height, width)
    first = rows[:, :-1].ravel(), rows[:-1].ravel()
    second = rows[:, 1:].ravel(), rows[1:].ravel()
    axis = np.repeat(np.array(Axis, np.int8), [len(part) for part in first])
    across = (axis == Axis.X).astype(float)
    return Pairs(
        np.concatenate(first), np.concatenate(second), axis, across, 1.0 - across
    )


def pair_at(axis: Indices, x: Indices, y: Indices, width: int, height: int) -> Indices:
    """Rows of pairs by axis, and column and line of the first pixel.

    Parameters
    ----------
    axis : (K,) int; `Axis`
    x, y : (K,) int; column and line, also outside of the image

    Returns
    -------
    (K,) int; row among `pixel_pairs`, or ``NONE`` where the pair leads out of the image
    """
    across = axis == Axis.X
    columns, lines = np.where(across, width - 1, width), np.where(across, 0, 1)
    inside = (x >= 0) & (y >= 0) & (x < columns) & (y < height - lines)
    before = np.where(across, 0, height * (width - 1))
    return np.where(inside, before + y * columns + x, NONE)


def as_differences(pairs: Pairs, delta: Vec3s, pixels: int) -> Differences:
    """Differences of an image, from those of its pairs.

    Parameters
    ----------
    delta : (P, 3) float64; Δ_ij = F_i − F_j of each
    pixels : int; N

    Returns
    -------
    Differences; N rows of F_j − F_i: the paper's Δ is minus the forward difference
    """
    parts = []
    for axis in Axis:
        at = np.flatnonzero(pairs.axis == axis)
        parts.append(scatter(pairs.first[at], -delta[at], pixels))
    return Differences(*parts)
