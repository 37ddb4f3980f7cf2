"""An image from pixels and their differences: screened Poisson reconstruction."""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dctn, idctn

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


ALPHA = 0.2
"""Weight of a pixel's own estimate beside a difference, on the rows: α² in squares."""


def least_squares(
    primal: Scalars, d: Differences, width: int, alpha: float = ALPHA
) -> Scalars:
    """Image I that minimizes |α (I − P)|² + |D_x I − d_x|² + |D_y I − d_y|².

    [Lehtinen13, section 3]; [Kettunen15].  The normal equations
    (α² + D_xᵀ D_x + D_yᵀ D_y) I = α² P + D_xᵀ d_x + D_yᵀ d_y are diagonal under the
    cosine transform of type 2, whose even continuation at the borders is that of
    differences that do not lead out of the image.

    Parameters
    ----------
    primal : (N, C) float64; pixels P
    d : Differences; N rows
    alpha : float; positive

    Returns
    -------
    (N, C) float64
        Linear in what is given, so that it is unbiased where that is; its mean is that
        of the pixels.

    Raises
    ------
    ValueError
        A pixel or a difference is not finite, or a difference leads out of the image:
        the message says which.
    """
    check(primal, d, width)
    right = alpha * alpha * primal + spread_back(d, width)
    return screened(right, width, alpha * alpha)


def screened(right: Scalars, width: int, screen: float) -> Scalars:
    """Solve (s + D_xᵀ D_x + D_yᵀ D_y) I = R exactly, (N, C) float64; I.

    Parameters
    ----------
    right : (N, C) float64; R
    screen : float; s, positive
    """
    image = right.reshape(-1, width, right.shape[1])
    height = len(image)
    down = 4 * np.sin(np.pi * np.arange(height) / (2 * height)) ** 2
    across = 4 * np.sin(np.pi * np.arange(width) / (2 * width)) ** 2
    eigenvalue = screen + down[:, None] + across
    waves = dctn(image, axes=(0, 1)) / eigenvalue[:, :, None]
    solved: Scalars = idctn(waves, axes=(0, 1)).reshape(right.shape)
    return solved


def check(primal: Scalars, d: Differences, width: int) -> None:
    """Refuse what no image can be made from.

    Parameters
    ----------
    primal : (N, C) float64; pixels

    Raises
    ------
    ValueError
        A pixel or a difference is not finite, or a difference leads out of the image.
    """
    named = (("pixel", primal), ("difference x", d.x), ("difference y", d.y))
    for name, rows in named:
        bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        if len(bad):
            y, x = divmod(int(bad[0]), width)
            raise ValueError(
                f"{name} at ({x}, {y}) is {rows[bad[0]].tolist()}, and {len(bad)} in"
                " all are not finite: nothing is reconstructed from them"
            )
    last_column = d.x.reshape(-1, width, d.x.shape[1])[:, -1]
    last_row = d.y.reshape(-1, width, d.y.shape[1])[-1]
    if last_column.any() or last_row.any():
        raise ValueError(
            "differences of the last column and row lead out of the image: must be 0"
        )
