"""Who made a sample sees it, wherever else the sample has been copied to.

A ray back to a sample may fail at an edge where the ray that found it went through.  If
the answer hung on the copy, a backend that asks about samples and one that asks about
places in the stream would differ, and both be right.
"""

from collections.abc import Sequence

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Vec3s


def made_it(
    viewer: Indices,
    position: Vec3s,
    makers: Sequence[Indices],
    positions: Sequence[Vec3s],
) -> Masks:
    """Whether viewers are the makers of samples.

    Parameters
    ----------
    viewer : (N,) int; rows of visible points, or −1
    position : (N, 3), m; of the samples asked about
    makers : sequence of (N,) int; who made each sample of the stream, or −1
    positions : sequence of (N, 3); of these samples

    Returns
    -------
    (N,) bool; the viewer made one of the stream that lies at the very same point
    """
    made: Masks = np.zeros(len(viewer), bool)
    for maker, place in zip(makers, positions, strict=True):
        same = (place == position).all(axis=1)
        made |= (viewer == maker) & (viewer >= 0) & same
    return made
