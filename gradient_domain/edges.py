"""Which pairs of pixels lie across an edge: told by the G-buffer, never by a sample."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from reference.arrays import Indices, Masks, dot
from reference.passes.neighbors import NONE
from reference.records import take
from reference.scene.surface import VisiblePoints

ALBEDO, COSINE, DEPTH = 0.1, 0.9, 0.1
"""Of pixels that are alike: greatest difference of albedos, least cosine, and depth."""


class Axis(IntEnum):
    """Which way a pair goes: to the right neighbour, or to the lower one."""

    X = 0
    Y = 1


def partners(width: int, height: int, axis: Axis) -> Indices:
    """Second pixels of the pairs whose first ones are all pixels.

    Parameters
    ----------
    width, height : int, pixels
        Of the image.
    axis : Axis
        Which way.

    Returns
    -------
    (N,) int64
        Row of the neighbour, or ``NONE`` in the last column or row.
    """
    rows = np.arange(width * height).reshape(height, width)
    found = np.full_like(rows, NONE)
    if axis == Axis.X:
        found[:, :-1] = rows[:, 1:]
    else:
        found[:-1] = rows[1:]
    return found.ravel()


@dataclass(frozen=True, slots=True)
class Edges:
    """Pairs of a frame that lie across an edge, N rows.

    Attributes
    ----------
    x, y : (N,) bool
        Pixel and right neighbour, pixel and lower one; false where there is none.
    """

    x: Masks
    y: Masks


def edges(visible: VisiblePoints, width: int) -> Edges:
    """Find the edge pairs of a frame.

    Parameters
    ----------
    visible : VisiblePoints
        G-buffer.
    width : int, pixels
        Of the image.

    Returns
    -------
    Edges
        N rows.
    """
    height = len(visible.depth) // width
    found = []
    for axis in Axis:
        second = partners(width, height, axis)
        there = second != NONE
        other = take(visible, np.maximum(second, 0))
        found.append(there & differ(visible, other))
    return Edges(*found)


def differ(a: VisiblePoints, b: VisiblePoints) -> Masks:
    """Whether the pixels of pairs see what is unlike.

    Parameters
    ----------
    a, b : VisiblePoints
        N pixels each.

    Returns
    -------
    (N,) bool
        Symmetric.  True where one of them sees nothing, false where neither does.

    Notes
    -----
    [Wang25, section 4.3.2]: albedos (here in any channel) that differ by more than 0.1,
    normals at a cosine *below* 0.9 (printed is above), or depths that differ by more
    than a tenth of the larger one (printed is the first).
    """
    both = a.surface.hit & b.surface.hit
    albedo = np.abs(a.surface.color - b.surface.color).max(axis=1) > ALBEDO
    normal = dot(a.surface.shading, b.surface.shading) < COSINE
    larger = np.maximum(a.depth, b.depth)
    depth = np.abs(a.depth - b.depth) > DEPTH * larger
    unlike = both & (albedo | normal | depth)
    alone: Masks = a.surface.hit != b.surface.hit
    found: Masks = unlike | alone
    return found
