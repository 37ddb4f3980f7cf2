"""Reservoirs at a lower resolution than the picture's: one for a square of pixels."""

from restir_gi.reference.numerics.arrays import Indices, Masks


def corner(rows: Indices, width: int, side: int) -> Indices:
    """Pixel that keeps the reservoir of each pixel's square.

    Parameters
    ----------
    rows : (K,) int; pixels, y · width + x

    Returns
    -------
    (K,) int; the upper left pixel of the square; it is always inside of the image
    """
    x, y = rows % width, rows // width
    found: Indices = (y - y % side) * width + (x - x % side)
    return found


def keeps_reservoir(rows: Indices, width: int, side: int) -> Masks:
    """Whether pixels keep reservoirs, and draw samples for them.

    Parameters
    ----------
    rows : (K,) int; pixels, y · width + x
    side : int, pixels; of the squares; 1 for everyone

    Returns
    -------
    (K,) bool; decided by place alone
    """
    keeps: Masks = corner(rows, width, side) == rows
    return keeps
