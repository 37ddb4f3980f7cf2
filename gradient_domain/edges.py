"""Edge pairs, and pairs that are alike: told by the G-buffer, never by a sample."""

from dataclasses import dataclass

import numpy as np

from gradient_domain.pairs import Pairs
from reference.arrays import Indices, Masks, Scalars, Vec3s, dot
from reference.records import take
from reference.scene.surface import VisiblePoints

ALBEDO, COSINE, DEPTH = 0.1, 0.9, 0.1
"""Of pixels that are alike: greatest difference of albedos, least cosine, and depth."""


@dataclass(frozen=True, slots=True)
class Looks:
    """What pixels are told apart by, N rows.

    Attributes
    ----------
    hit : (N,) bool; they see something
    albedo, normal : (N, 3) float64; of it
    depth : (N,) float64, m; of it
    """

    hit: Masks
    albedo: Vec3s
    normal: Vec3s
    depth: Scalars


def looks(visible: VisiblePoints) -> Looks:
    """Looks of the pixels of a frame."""
    surface = visible.surface
    return Looks(surface.hit, surface.color, surface.shading, visible.depth)


def across_edges(seen: Looks, pairs: Pairs) -> Masks:
    """Which pairs lie across an edge [Wang25, section 4.3.2].

    Parameters
    ----------
    seen : Looks; of the frame, N rows
    pairs : Pairs; K rows

    Returns
    -------
    (K,) bool; symmetric: the order of the pixels does not matter
    """
    return differ(take(seen, pairs.first), take(seen, pairs.second))


def alike(seen: Looks, pairs: Pairs, rows: Indices, others: Indices) -> Masks:
    """Whether two pairs look alike, pixel by pixel, (K,) bool; symmetric.

    Parameters
    ----------
    seen : Looks; of the frame, N rows
    rows, others : (K,) int; rows of pairs
    """
    apart = [
        differ(take(seen, pixel[rows]), take(seen, pixel[others]))
        for pixel in (pairs.first, pairs.second)
    ]
    found: Masks = ~(apart[0] | apart[1])
    return found


def differ(a: Looks, b: Looks) -> Masks:
    """Whether pixels look unlike.

    [Wang25, section 4.3.2]: albedos (here in any channel) that differ by more than 0.1,
    normals at a cosine *below* 0.9 (printed is above), or depths that differ by more
    than a tenth of the larger one (printed is the first).

    Returns
    -------
    (K,) bool; symmetric; True where one of them sees nothing, false where neither does
    """
    albedo = np.abs(a.albedo - b.albedo).max(axis=1) > ALBEDO
    normal = dot(a.normal, b.normal) < COSINE
    depth = np.abs(a.depth - b.depth) > DEPTH * np.maximum(a.depth, b.depth)
    unlike = a.hit & b.hit & (albedo | normal | depth)
    alone: Masks = a.hit != b.hit
    found: Masks = unlike | alone
    return found
