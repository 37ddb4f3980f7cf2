"""Pairs of neighbouring pixels: which there are, one around, and where they were."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from restir_gi.extensions.area_restir import Window, windows
from restir_gi.extensions.frame_loop import PathFrame
from restir_gi.gradient_domain.reconstruction import Differences
from restir_gi.gradient_domain.settings import GradientSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.numerics.records import NONE, scatter
from restir_gi.reference.scene.surface import VisiblePoints


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


# ------------------------------------- around a pair


def draw_around(
    frame: FrameContext[GradientSettings], pairs: Pairs, rows: Indices, u: Scalars
) -> Indices:
    """A pair of the same axis in a square around each of K pairs.

    Parameters
    ----------
    rows : (K,) int; of ``pairs``, which are those of the frame
    u : (K,) float64; one number in [0, 1) each

    Returns
    -------
    (K,) int
        Row of a pair, or ``NONE`` where it leads out of the image, or is the pair
        itself.
    """
    s, camera = frame.settings, frame.world.camera
    radius = int(max(s.radius * camera.width, s.min_radius))
    return pair_in_square(pairs, rows, u, radius, camera.width, camera.height)


def pair_in_square(
    pairs: Pairs, rows: Indices, u: Scalars, radius: int, width: int, height: int
) -> Indices:
    """A pair of the same axis, at most ``radius`` columns and lines away from K pairs.

    Parameters
    ----------
    rows : (K,) int; of ``pairs``, which are all of an image
    u : (K,); in [0, 1): places of the square follow one another line by line

    Returns
    -------
    (K,) int
        Row of a pair, or ``NONE`` where it leads out of the image, or is the pair
        itself.
    """
    side = 2 * radius + 1
    place = np.floor(u * side**2).astype(np.int64)
    y, x = np.divmod(pairs.first[rows], width)
    x, y = x + place % side - radius, y + place // side - radius
    found = pair_at(pairs.axis[rows], x, y, width, height)
    return np.where(found == rows, NONE, found)


# ------------------------------------- a frame ago


def pivots(pairs: Pairs, visible: VisiblePoints) -> Indices:
    """The nearer pixel of each pair, with which both pixels move.

    [Wang25, section 4.3.1]: what is behind may have been hidden.

    Returns
    -------
    (K,) int
        Row of the pixel; one that sees nothing is the farther one, and the first is
        taken where both are alike.
    """
    depth = np.where(visible.surface.hit, visible.depth, np.inf)
    second = depth[pairs.second] < depth[pairs.first]
    return np.where(second, pairs.second, pairs.first)


def pair_windows(
    frame: FrameContext[GradientSettings], last: PathFrame, pairs: Pairs
) -> list[Window]:
    """Where pairs were a frame ago: up to four pairs of the last frame for each.

    Their rows are those of the pairs of the last frame that have the pivot where this
    pair has it [Wang25, section 4.3.1].
    """
    camera = last.world.camera
    pivot = pivots(pairs, frame.visible)
    found = []
    for part in windows(frame, last, pivot):
        rows = pairs_before(pairs, pivot, part.rows, camera.width, camera.height)
        share = np.where(rows != NONE, part.share, 0.0)
        found.append(Window(rows, part.dx, part.dy, share))
    return found


def pairs_before(
    pairs: Pairs, pivot: Indices, rows: Indices, width: int, height: int
) -> Indices:
    """Pairs of the last frame that have a pixel where K pairs have their pivot.

    Parameters
    ----------
    pivot : (K,) int; row of the image, of either pixel of each pair
    rows : (K,) int; where the pivot was in the last frame, or ``NONE``

    Returns
    -------
    (K,) int; row of a pair, or ``NONE`` where the pivot or its neighbour was nowhere
    """
    second = pivot != pairs.first
    back_x, back_y = (
        np.where(second, step, 0).astype(np.int64) for step in (pairs.dx, pairs.dy)
    )
    y, x = np.divmod(rows, width)
    found = pair_at(pairs.axis, x - back_x, y - back_y, width, height)
    return np.where(rows != NONE, found, NONE)
