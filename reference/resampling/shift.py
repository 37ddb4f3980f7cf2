"""Reconnection: another visible point looks at the same sample point."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    saturate,
    sqrt,
)


def reconnection_jacobian(
    x_from: Vec3s, x_to: Vec3s, x_sample: Vec3s, n_sample: Vec3s
) -> Scalars:
    """Ratio |∂ω_to / ∂ω_from| of the solid angles of one patch at the sample point.

    A patch dA covers dω = |cos φ| / d² · dA as seen from distance d, hence

        |∂ω_to / ∂ω_from| = (|cos φ_to| / |cos φ_from|) · (d_from² / d_to²)

    [Ouyang21, Eq. 11].  Not clamped: clamping is a bias, and is named so elsewhere.

    Parameters
    ----------
    x_from, x_to : (N, 3), m
        Visible point that made the sample, and the one that reuses it.
    x_sample, n_sample : (N, 3), m and 1; sample point and its unit geometric normal

    Returns
    -------
    (N,), sr/sr
        Factor on the sample's W.  0 where x_from sees the patch edge-on or either
        point touches it: there the shift has no inverse.  At most the largest number of
        the dtype; 0 where the squares of both distances overflow.
    """
    v_from, v_to = x_from - x_sample, x_to - x_sample
    # With v not normalized, cos φ = n·v / d, and d_from / d_to comes once more.
    with np.errstate(over="ignore", invalid="ignore"):
        ratio = sqrt(divide_or_zero(dot(v_from, v_from), dot(v_to, v_to)))
        cosines = divide_or_zero(abs(dot(n_sample, v_to)), abs(dot(n_sample, v_from)))
        jacobian = cosines * ratio * ratio * ratio
    return saturate(jacobian)
