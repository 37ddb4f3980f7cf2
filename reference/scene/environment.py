"""Light from beyond the scene: radiance, sampling and density by direction."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images.image import luminance_weights
from restir_gi.reference.numerics.arrays import Scalars, Vec3s, vectors
from restir_gi.reference.numerics.frames import turn
from restir_gi.reference.numerics.sampling import sample_uniform_sphere
from restir_gi.reference.numerics.tables import cumulate, sample_table
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    Environment,
    LatLongEnvironment,
)
from restir_gi.reference.scene.textures import read_latitudes


@dataclass(frozen=True, slots=True, eq=False)
class EnvironmentMap:
    """An environment, ready to be sampled.

    Attributes
    ----------
    source : Environment; as the author gave it
    cumulative : (h·w,) float64 or None
        Running sum of the probabilities of the texels; ``None`` for a constant.
    density : (h, w) float64 or None, 1/sr
        Probability of each texel over its solid angle.
    """

    source: Environment
    cumulative: Scalars | None
    density: Scalars | None


def build_environment(source: Environment) -> EnvironmentMap:
    """Prepare an environment for sampling.

    Texels are drawn by the largest luminance among them and their neighbours, so that
    the density is positive wherever the interpolated radiance is.
    """
    if isinstance(source, ConstantEnvironment) or not source.pixels.any():
        return EnvironmentMap(source, None, None)
    height, width, _ = source.pixels.shape
    luminance = source.pixels @ np.array(luminance_weights())
    padded = np.pad(
        np.pad(luminance, ((1, 1), (0, 0)), "edge"), ((0, 0), (1, 1)), "wrap"
    )
    largest = np.max(
        [padded[i : i + height, j : j + width] for i in range(3) for j in range(3)],
        axis=0,
    )
    edges = np.cos(np.linspace(0.0, np.pi, height + 1))
    solid_angle = (edges[:-1] - edges[1:])[:, None] * (2.0 * np.pi / width)
    weight = largest * solid_angle
    density = weight / weight.sum() / solid_angle
    return EnvironmentMap(source, cumulate(weight.ravel()), density)


def environment_radiance(environment: EnvironmentMap, direction: Vec3s) -> Vec3s:
    """Radiance that arrives from a direction.

    Parameters
    ----------
    direction : (N, 3) float64; unit vectors away from the scene

    Returns
    -------
    (N, 3) float64, W/(m² sr); interpolated between texel centres
    """
    source = environment.source
    if isinstance(source, ConstantEnvironment):
        return np.broadcast_to(np.asarray(source.radiance, float), direction.shape)
    return read_latitudes(source.pixels, *_to_map(source, direction))


def sample_environment(
    environment: EnvironmentMap, u1: Scalars, u2: Scalars
) -> tuple[Vec3s, Scalars]:
    """Draw directions in proportion to the luminance of the texels.

    Parameters
    ----------
    u1, u2 : (N,) float64; in [0, 1)

    Returns
    -------
    (N, 3), (N,) float64; unit directions, and their density in 1/sr
    """
    source = environment.source
    if isinstance(source, ConstantEnvironment) or environment.cumulative is None:
        direction = sample_uniform_sphere(u1, u2)
        return direction, np.full(len(u1), 1.0 / (4.0 * np.pi))
    height, width, _ = source.pixels.shape
    texel, place = sample_table(environment.cumulative, u1)
    row, column = texel // width, texel % width
    upper, lower = (np.cos(np.pi * (row + i) / height) for i in (0, 1))
    cos_theta = upper + place * (lower - upper)
    phi = 2.0 * np.pi * (column + u2) / width
    sin_theta = np.sqrt(np.maximum(1.0 - cos_theta**2, 0.0))
    # The inverse of _to_map.
    local = vectors(sin_theta * np.sin(phi), cos_theta, -sin_theta * np.cos(phi))
    assert environment.density is not None
    return turn(local, source.to_world), environment.density[row, column]


def pdf_environment(environment: EnvironmentMap, direction: Vec3s) -> Scalars:
    """Density of :func:`sample_environment`, (N,) float64, 1/sr; constant over a texel.

    Parameters
    ----------
    direction : (N, 3) float64; unit vectors
    """
    source = environment.source
    if isinstance(source, ConstantEnvironment) or environment.density is None:
        return np.full(len(direction), 1.0 / (4.0 * np.pi))
    height, width, _ = source.pixels.shape
    u, v = _to_map(source, direction)
    column = np.minimum((u * width).astype(np.int64), width - 1)
    row = np.minimum((v * height).astype(np.int64), height - 1)
    density: Scalars = environment.density[row, column]
    return density


def _to_map(source: LatLongEnvironment, direction: Vec3s) -> tuple[Scalars, Scalars]:
    local = turn(direction, source.to_world.T)
    u = (np.arctan2(local[:, 0], -local[:, 2]) / (2.0 * np.pi)) % 1.0
    v = np.arccos(np.clip(local[:, 1], -1.0, 1.0)) / np.pi
    return np.where(u >= 1.0, 0.0, u), v
