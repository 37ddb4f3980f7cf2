"""Sampling of directions, points and tables: sample_X, pdf_X and invert_X."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, divide_or_zero, vectors


def left_of(u: Scalars, probability: Scalars) -> Scalars:
    """What is left of a uniform number that was compared with a probability.

    Parameters
    ----------
    u : (N,) float; in [0, 1): u < p chose
    probability : (N,) float; p, from 0 to 1

    Returns
    -------
    (N,) float
        u / p or (u - p) / (1 - p): uniform in [0, 1) and independent of the choice,
        with as many bits fewer as the choice has taken.
    """
    chosen = divide_or_zero(u, probability)
    others = divide_or_zero(u - probability, 1.0 - probability)
    most = np.nextafter(u.dtype.type(1), u.dtype.type(0))
    return np.clip(np.where(u < probability, chosen, others), 0.0, most)


def sample_uniform_hemisphere(u1: Scalars, u2: Scalars) -> Vec3s:
    """Directions about +z with density 1 / 2π, (N, 3) float; unit vectors, cos θ = u1.

    Parameters
    ----------
    u1, u2 : (N,) float; in [0, 1)
    """
    return _about_z(u1, np.sqrt(np.maximum(0.0, 1.0 - u1 * u1)), u2)


def pdf_uniform_hemisphere(cos_theta: Scalars) -> Scalars:
    """Density 1 / 2π on the hemisphere, 0 below it.

    Parameters
    ----------
    cos_theta : (N,) float; cosine with the axis

    Returns
    -------
    (N,) float, 1/sr
        0 where cos θ < 0; u1 = 0 gives cos θ = 0, which belongs to the hemisphere.
    """
    return np.where(cos_theta >= 0, 1.0 / (2.0 * np.pi), 0.0)


def invert_uniform_hemisphere(direction: Vec3s) -> tuple[Scalars, Scalars]:
    """The numbers (u1, u2) that :func:`sample_uniform_hemisphere` maps to a direction.

    Parameters
    ----------
    direction : (N, 3) float; unit vectors with z >= 0

    Returns
    -------
    (N,), (N,) float; in [0, 1)
    """
    return direction[:, 2], _azimuth(direction)


def sample_cosine_hemisphere(u1: Scalars, u2: Scalars) -> Vec3s:
    """Directions about +z with density cos θ / π.

    Parameters
    ----------
    u1, u2 : (N,) float; in [0, 1)

    Returns
    -------
    (N, 3) float; unit vectors, cos² θ = 1 - u1, never 0: so that 1 / pdf <= π 2¹²
    """
    return _about_z(np.sqrt(1.0 - u1), np.sqrt(u1), u2)


def pdf_cosine_hemisphere(cos_theta: Scalars) -> Scalars:
    """Density cos θ / π on the hemisphere, 0 below it.

    Parameters
    ----------
    cos_theta : (N,) float; cosine with the axis

    Returns
    -------
    (N,) float, 1/sr; 0 where cos θ <= 0
    """
    return np.maximum(cos_theta, 0.0) / np.pi


def invert_cosine_hemisphere(direction: Vec3s) -> tuple[Scalars, Scalars]:
    """The numbers (u1, u2) that :func:`sample_cosine_hemisphere` maps to a direction.

    Parameters
    ----------
    direction : (N, 3) float; unit vectors with z > 0

    Returns
    -------
    (N,), (N,) float; in [0, 1)
    """
    return direction[:, 0] ** 2 + direction[:, 1] ** 2, _azimuth(direction)


def sample_uniform_sphere(u1: Scalars, u2: Scalars) -> Vec3s:
    """Directions with density 1 / 4π, (N, 3) float; unit vectors, z = 1 - 2 u1.

    Parameters
    ----------
    u1, u2 : (N,) float; in [0, 1)
    """
    z = 1.0 - 2.0 * u1
    return _about_z(z, 2.0 * np.sqrt(u1 * (1.0 - u1)), u2)


def invert_uniform_sphere(direction: Vec3s) -> tuple[Scalars, Scalars]:
    """The numbers (u1, u2) that :func:`sample_uniform_sphere` maps to a direction.

    Parameters
    ----------
    direction : (N, 3) float; unit vectors

    Returns
    -------
    (N,), (N,) float; in [0, 1)
    """
    return (1.0 - direction[:, 2]) / 2.0, _azimuth(direction)


def sample_triangle(u1: Scalars, u2: Scalars) -> tuple[Scalars, Scalars]:
    """Barycentric coordinates of a point uniform over the area of a triangle.

    Parameters
    ----------
    u1, u2 : (N,) float; in [0, 1)

    Returns
    -------
    (N,), (N,) float; weights of the second and third vertex; both >= 0, sum at most 1
    """
    root = np.sqrt(u1)
    return root * (1.0 - u2), root * u2


def invert_triangle(b1: Scalars, b2: Scalars) -> tuple[Scalars, Scalars]:
    """The numbers (u1, u2) that :func:`sample_triangle` maps to barycentrics.

    Parameters
    ----------
    b1, b2 : (N,) float; weights of the second and third vertex

    Returns
    -------
    (N,), (N,) float; in [0, 1); u2 = 0 at the first vertex, where all u2 meet
    """
    return (b1 + b2) ** 2, divide_or_zero(b2, b1 + b2)


def _about_z(cos_theta: Scalars, sin_theta: Scalars, u: Scalars) -> Vec3s:
    phi = (2.0 * np.pi) * u
    return vectors(sin_theta * np.cos(phi), sin_theta * np.sin(phi), cos_theta)


def _azimuth(direction: Vec3s) -> Scalars:
    turns = np.arctan2(direction[:, 1], direction[:, 0]) / (2.0 * np.pi)
    turns = np.where(turns < 0, turns + 1.0, turns)
    # A hair below the x axis the sum rounds to 1, which is 0 again.
    return np.where(turns < 1, turns, 0.0)
