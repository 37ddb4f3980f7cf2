"""What designed rows are drawn from."""

import numpy as np
from numpy.random import Generator

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize

STEP = 2.0**-24
"""Between the numbers that pass ``random`` gives."""


def unit_vectors(rng: Generator, rows: int) -> Vec3s:
    """Directions, all alike, (N, 3); unit vectors."""
    return normalize(rng.normal(size=(rows, 3)))


def spread(rng: Generator, least: float, most: float, rows: int) -> Scalars:
    """Numbers from 10^least to 10^most, their logarithms all alike, (N,)."""
    found: Scalars = 10.0 ** rng.uniform(least, most, rows)
    return found


def about(rng: Generator, axis: Vec3s, cosine: Scalars | float) -> Vec3s:
    """Directions at given angles from others, (N, 3); unit vectors.

    Parameters
    ----------
    axis : (N, 3); unit vectors
    cosine : (N,) float64 or float; of the angle
    """
    other = unit_vectors(rng, len(axis))
    across = normalize(other - (other * axis).sum(axis=1)[:, None] * axis)
    along = np.broadcast_to(cosine, len(axis))[:, None]
    found: Vec3s = along * axis + np.sqrt(1 - along * along) * across
    return found


def ends_of_u(rng: Generator, rows: int) -> Scalars:
    """Numbers as pass ``random`` gives them, a tenth of them at each end, (N,)."""
    u = rng.integers(0, 2**24, rows) * STEP
    end = rng.random(rows)
    return np.where(end < 0.1, 0.0, np.where(end < 0.2, 1 - STEP, u))
