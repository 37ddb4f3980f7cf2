"""Reconstruction that a few wrong differences do not bend: least absolute values."""

import numpy as np

from restir_gi.gradient_domain.reconstruction import (
    ALPHA,
    Differences,
    check,
    differences,
    least_squares,
    screened,
    spread_back,
)
from restir_gi.reference.numerics.arrays import Scalars

STEPS = 200
"""Of alternation."""

PENALTY = 0.3
"""ρ in inverse mean deviations; a third or three times as much needs more steps."""


def least_absolute(
    primal: Scalars, d: Differences, width: int, alpha: float = ALPHA
) -> Scalars:
    """Image I that minimizes Σ |α (I − P)| + Σ |D_x I − d_x| + Σ |D_y I − d_y|.

    Parameters
    ----------
    primal : (N, C) float64; pixels P
    d : Differences; N rows
    alpha : float; positive

    Returns
    -------
    (N, C) float64
        |·| is the length of all channels.  Not linear: it is biased, mostly to
        the dark where bright pixels are rare, and its mean is not that of the pixels.

    Raises
    ------
    ValueError
        As :func:`restir_gi.gradient_domain.reconstruction.least_squares`.

    Notes
    -----
    Alternating directions [Boyd11, section 6.1]: with A = (α, D_x, D_y), b = (α P, d_x,
    d_y) and multipliers u, z shortens A I − b + u by 1/ρ, and I solves the screened
    Poisson equation for b + z − u, by one exact transform.  What is left after all
    steps is some ten-thousandths of the sum, where one path a pixel finds little
    light a hundredth.
    """
    check(primal, d, width)
    image = least_squares(primal, d, width, alpha)
    off = _deviations(image, primal, d, width, alpha)
    mean = float(np.mean([_lengths(a) for a in off]))
    if mean == 0:
        return image
    shortest = mean / PENALTY
    u = [np.zeros_like(a) for a in off]
    for _ in range(STEPS):
        moved = [a + b for a, b in zip(off, u, strict=True)]
        u = [_at_most(a, shortest) for a in moved]
        p, x, y = (a - 2.0 * b for a, b in zip(moved, u, strict=True))
        wanted = Differences(d.x + x, d.y + y)
        right = alpha * (alpha * primal + p) + spread_back(wanted, width)
        image = screened(right, width, alpha * alpha)
        off = _deviations(image, primal, d, width, alpha)
    return image


def _deviations(
    image: Scalars, primal: Scalars, d: Differences, width: int, alpha: float
) -> list[Scalars]:
    """A I − b."""
    now = differences(image, width)
    return [alpha * (image - primal), now.x - d.x, now.y - d.y]


def _at_most(rows: Scalars, length: float) -> Scalars:
    """Rows, shortened where they are longer: what shortening by ``length`` takes."""
    share = np.minimum(1.0, length / np.maximum(_lengths(rows), length))
    kept: Scalars = rows * share[:, None]
    return kept


def _lengths(rows: Scalars) -> Scalars:
    squares: Scalars = np.einsum("ij,ij->i", rows, rows)
    return np.sqrt(squares)
