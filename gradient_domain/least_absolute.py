"""Reconstruction that a few wrong differences do not bend: least absolute values."""

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from gradient_domain.differences import Differences, differences, spread_back
from gradient_domain.reconstruction import ALPHA, check, least_squares, screened
from reference.arrays import Scalars

STEPS = 40
"""Of reweighting."""

FLOOR, FALL = 0.05, 0.7
"""Least deviation that is told from 0, in mean deviations: at first, and by step."""


def least_absolute(
    primal: Scalars, d: Differences, width: int, alpha: float = ALPHA
) -> Scalars:
    """Image I that minimizes Σ |α (I − P)| + Σ |D_x I − d_x| + Σ |D_y I − d_y|.

    Parameters
    ----------
    primal : (N, C) float64
        Pixels P.
    d : Differences
        N rows.
    width : int, pixels
        Of a row.
    alpha : float
        Positive.

    Returns
    -------
    (N, C) float64
        |·| is the length of all channels.  Not linear: it is biased, mostly to
        the dark where bright pixels are rare, and its mean is not that of the pixels.

    Raises
    ------
    ValueError
        As :func:`gradient_domain.reconstruction.least_squares`.

    Notes
    -----
    Iteratively reweighted least squares: each row is weighted by the inverse of its
    deviation, down to a floor that falls; what is solved is the weighted screened
    Poisson equation, by conjugate gradients that the unweighted one preconditions.
    [Lehtinen13, section 3].
    """
    check(primal, d, width)
    image = least_squares(primal, d, width, alpha)
    floor = FLOOR
    for _ in range(STEPS):
        weights = _weights(image, primal, d, width, alpha, floor)
        if weights is None:
            break
        image = _weighted(image, primal, d, width, alpha, weights)
        floor *= FALL
    return image


def _weights(
    image: Scalars,
    primal: Scalars,
    d: Differences,
    width: int,
    alpha: float,
    floor: float,
) -> tuple[Scalars, Scalars, Scalars] | None:
    """Inverse deviations of the rows; ``None`` where nothing deviates."""
    now = differences(image, width)
    off = [_lengths(a) for a in (alpha * (image - primal), now.x - d.x, now.y - d.y)]
    mean = float(np.mean(off))
    if mean == 0:
        return None
    p, x, y = (mean / np.maximum(a, floor * mean) for a in off)
    return p, x, y


def _lengths(rows: Scalars) -> Scalars:
    squares: Scalars = np.einsum("ij,ij->i", rows, rows)
    return np.sqrt(squares)


def _weighted(
    image: Scalars,
    primal: Scalars,
    d: Differences,
    width: int,
    alpha: float,
    weights: tuple[Scalars, Scalars, Scalars],
) -> Scalars:
    p, x, y = (w[:, None] for w in weights)
    screen = alpha * alpha * p
    right = screen * primal + spread_back(Differences(x * d.x, y * d.y), width)
    size = len(image)

    def left(column: Scalars) -> Scalars:
        rows = column.reshape(size, 1)
        now = differences(rows, width)
        pulled = spread_back(Differences(x * now.x, y * now.y), width)
        total: Scalars = (screen * rows + pulled).ravel()
        return total

    s, t = float(np.mean(screen)), float(np.mean([x.mean(), y.mean()]))

    def nearly(column: Scalars) -> Scalars:
        return screened(column.reshape(size, 1), width, s, t).ravel()

    operator = LinearOperator((size, size), matvec=left)
    inverse = LinearOperator((size, size), matvec=nearly)
    solved = np.empty_like(image)
    for channel in range(image.shape[1]):
        solved[:, channel], _ = cg(
            operator,
            right[:, channel],
            x0=image[:, channel],
            rtol=1e-6,
            maxiter=200,
            M=inverse,
        )
    return solved
