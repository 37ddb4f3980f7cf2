"""Checkerboard: half of the pixels draw a new sample in each frame."""

from restir_gi.reference.numerics.arrays import Indices, Masks


def draws_new_sample(
    rows: Indices, width: int, frame: int, has_history: Masks
) -> Masks:
    """Whether pixels draw a new sample in this frame.

    Decided by place, geometry and time alone, never by a sample.  While nothing moves,
    the history covers the pixel's whole domain and nothing is biased; in a scene that
    changes, what only a new sample could have found is missing.

    Parameters
    ----------
    rows : (K,) int; pixels, y · width + x
    frame : int; from 0
    has_history : (K,) bool; the pixel goes on from the last frame

    Returns
    -------
    (K,) bool; where x + y + frame is even, and where there is no history to live on
    """
    turn = (rows % width + rows // width + frame) % 2 == 0
    drawn: Masks = turn | ~has_history
    return drawn
