"""Unit normals in six bytes: components as 16-bit integers, of which 32767 is 0."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Vec3s, normalize

UNIT = 32767
"""Steps from 0 to 1, and the code of 0.  65535 is never written and read as 65534."""

WORST_ANGLE = 3**0.5 / (2 * UNIT)
"""Largest angle between a normal and its decoded codes: 2.643e-5 radians, 5.5″."""


def encode_components(n: Vec3s) -> NDArray[np.uint16]:
    """Codes of the components of unit normals: the nearest of a grid of step 1/32767.

    Parameters
    ----------
    n : (N, 3) float; unit normals, or 0

    Returns
    -------
    (N, 3) uint16
        32767 n + 32767, rounded to nearest, ties to even: from 0 to 65534.  Components
        beyond 1 become 1, those that are no number 0.

    Notes
    -----
    A component is off by half a step at most, a normal by √3/2 steps, and the angle is
    largest where all of that is across it: `WORST_ANGLE` = √3 / (2 · 32767), to a part
    in 1e9.
    """
    steps = np.rint(UNIT * np.clip(np.nan_to_num(n.astype(np.float64), nan=0.0), -1, 1))
    codes: NDArray[np.uint16] = (steps + UNIT).astype(np.uint16)
    return codes


def decode_components(codes: NDArray[np.unsignedinteger[Any]]) -> Vec3s:
    """Unit normals of the codes of their components.

    Parameters
    ----------
    codes : (N, 3) uint16; any; 65535 is read as 65534

    Returns
    -------
    (N, 3) float64
        Of unit length to rounding, and 0 where all three codes are 32767.  What was
        read may have other codes, next to these, as its length has become 1.
    """
    steps = np.minimum(codes.astype(np.int32) - UNIT, UNIT)
    return normalize(steps.astype(np.float64))
