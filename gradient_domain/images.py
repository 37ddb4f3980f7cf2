"""Images that are reconstructed, by name of the norm."""

from typing import Literal

from gradient_domain.differences import Differences
from gradient_domain.least_absolute import least_absolute
from gradient_domain.reconstruction import least_squares
from reference.arrays import Vec3s

Reconstruction = Literal["l2", "l1"]


def reconstructed(
    kind: Reconstruction, primal: Vec3s, d: Differences, width: int
) -> Vec3s:
    """Image from pixels and differences.

    Parameters
    ----------
    kind : 'l2' or 'l1'; norm of what is left of the differences
    primal : (N, 3) float64; pixels

    Returns
    -------
    (N, 3) float64
        Unbiased for L2, where what is given is; L1 is not linear, and biased.

    Raises
    ------
    ValueError
        A pixel or difference is not finite.
    """
    solve = {"l2": least_squares, "l1": least_absolute}[kind]
    return solve(primal, d, width)
