"""What the means of a picture should be: path traced, with its own error."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reference.arrays import Scalars
from reference.path_tracer import camera_radiance, first_hits
from reference.rng import KeyedUniforms, Stream
from reference.scene.camera import pixel_centers
from reference.scene.scene import Scene
from reference.scene.validation import validate
from reference.world import build_world

TILES = 4
"""On a side of the picture."""

SEED = 2**26 + 1
"""Of the path tracer: far from what a user counts from."""


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Means of a picture and of its tiles.

    Attributes
    ----------
    mean, standard_error : (1 + TILES²,) float64
        Of the picture and of its tiles, as the mean over channels.
    """

    mean: Scalars
    standard_error: Scalars


def statistics(color: NDArray[np.floating]) -> Scalars:
    """Mean of a picture, and those of its tiles.

    Parameters
    ----------
    color : (height, width, 3)
        Of sides that `TILES` divides.

    Returns
    -------
    (1 + TILES²,) float64
        Over all channels.
    """
    grey = color.astype(np.float64).mean(axis=2)
    height, width = (side // TILES for side in grey.shape)
    tiles = grey.reshape(TILES, height, TILES, width).mean(axis=(1, 3)).ravel()
    return np.concatenate([[grey.mean()], tiles])


def path_traced(
    scene: Scene, size: tuple[int, int], bounces: int, samples: int
) -> Truth:
    """Indirect light by the plain path tracer, through pixel centres.

    Parameters
    ----------
    scene : Scene
        Any that can be rendered.
    size : (int, int), pixels
        Width and height.
    bounces : int
        Of indirect light.
    samples : int
        Of each pixel.

    Returns
    -------
    Truth
        The error is that of the mean of independent pictures.
    """
    width, height = size
    camera = replace(scene.camera, width=width, height=height)
    world = build_world(validate(replace(scene, camera=camera)))
    points = first_hits(world, *pixel_centers(width, height))
    pixel = np.arange(width * height, dtype=np.uint32)

    def one(number: int) -> Scalars:
        uniforms = KeyedUniforms(pixel, number, SEED, Stream.PATH)
        color = camera_radiance(world, points, "indirect", bounces, uniforms)
        return statistics(color.reshape(height, width, 3))

    found = np.stack([one(number) for number in range(samples)])
    error = found.std(axis=0, ddof=1) / np.sqrt(samples)
    return Truth(found.mean(axis=0), error)
