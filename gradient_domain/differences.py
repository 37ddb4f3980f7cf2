"""Differences of neighbouring pixels, and what they are turned into."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars


@dataclass(frozen=True, slots=True)
class Differences:
    """A frame of differences, N rows = y · W + x.

    Attributes
    ----------
    x : (N, C); right neighbour less pixel; 0 in the last column, which has none
    y : (N, C); lower neighbour less pixel; 0 in the last row
    """

    x: Scalars
    y: Scalars


def differences(rows: Scalars, width: int) -> Differences:
    """Forward differences D_x I and D_y I of a frame, N rows.

    [Wang25, Eq. 1], of pixels that are known.

    Parameters
    ----------
    rows : (N, C) float; the frame
    """
    image = rows.reshape(-1, width, rows.shape[1])
    x, y = np.zeros_like(image), np.zeros_like(image)
    x[:, :-1] = np.diff(image, axis=1)
    y[:-1] = np.diff(image, axis=0)
    return Differences(x.reshape(rows.shape), y.reshape(rows.shape))


def spread_back(d: Differences, width: int) -> Scalars:
    """Adjoint D_xᵀ d_x + D_yᵀ d_y: what differences say of each pixel.

    Returns
    -------
    (N, C) float; minus the divergence; differences to pixels outside do not count
    """
    x, y = (a.reshape(-1, width, a.shape[1]) for a in (d.x, d.y))
    total = np.zeros_like(x)
    total[:, :-1] -= x[:, :-1]
    total[:, 1:] += x[:, :-1]
    total[:-1] -= y[:-1]
    total[1:] += y[:-1]
    back: Scalars = total.reshape(d.x.shape)
    return back
