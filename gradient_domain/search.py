"""Pairs around that may lend their samples: those alike, or any."""

import numpy as np

from gradient_domain.edges import Looks, alike
from gradient_domain.pairs import Pairs, pair_at
from reference.arrays import Indices, Masks, Scalars
from reference.records import NONE
from reference.rng import Uniforms

AT_ONCE = 16
"""Tries that are made for all rows before it is asked who still searches."""


def draw_around(
    pairs: Pairs, rows: Indices, radius: int, width: int, height: int, u: Scalars
) -> Indices:
    """A pair of the same axis in a square around each pair.

    Parameters
    ----------
    rows : (K,) int; those that search
    radius : int, pixels; half the side of the square
    u : (K,) float64; one number in [0, 1) each

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


def find_alike(
    seen: Looks,
    pairs: Pairs,
    across: Masks,
    rows: Indices,
    radius: int,
    width: int,
    tries: int,
    uniforms: Uniforms,
) -> Indices:
    """The first of some edge pairs around each edge pair that looks like it.

    [Wang25, section 4.3.2].  Pairs of both pixels alike also have the edge in the same
    order, so that k means the same to both.

    Parameters
    ----------
    seen : Looks; of the frame, N rows
    across : (P,) bool; which lie across an edge
    rows : (K,) int; those that search; they do
    radius : int, pixels; half the side of the square that is searched
    tries : int; how many pairs are looked at, at most 256
    uniforms : Uniforms; K rows; a try takes one number

    Returns
    -------
    (K,) int; row of a pair, or ``NONE`` where none was found
    """
    height = len(seen.depth) // width
    found = np.full(len(rows), NONE)
    for first in range(0, tries, AT_ONCE):
        searching = np.flatnonzero(found == NONE)
        if len(searching) == 0:
            break
        some, count = uniforms.rows(searching), min(AT_ONCE, tries - first)
        draws = (some.draw((first + k) // 4) for k in range(0, count, 4))
        u = np.concatenate([lane for draw in draws for lane in draw][:count])
        own = np.tile(rows[searching], count)
        other = draw_around(pairs, own, radius, width, height, u)
        at = np.flatnonzero((other != NONE) & across[other])
        at = at[alike(seen, pairs, own[at], other[at])]
        # Tries follow one another: the first of each row is that of its first place.
        row, place = np.unique(at % len(searching), return_index=True)
        found[searching[row]] = other[at[place]]
    return found
