"""What the means of a picture should be: path traced, with its own error."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.oracle.cases import UnaskedError, for_ever
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.path_tracer import camera_radiance, first_hits
from restir_gi.reference.transport.world import build_world

TILES = 4
"""On a side of the picture."""

LEAST_SAMPLES = 256
"""Of each pixel: so many that the means are nearly normal."""

SEED = 2**26 + 1
"""Of the path tracer: far from what a user counts from."""


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Means of a picture and of its tiles.

    Attributes
    ----------
    mean, standard_error : (1 + TILES²,) float64
        Of the picture and of its tiles, as the mean over channels.
    samples : int; of each pixel, from which the error was estimated
    """

    mean: Scalars
    standard_error: Scalars
    samples: int


def statistics(color: NDArray[np.floating]) -> Scalars:
    """Mean of a picture, and those of its tiles.

    Parameters
    ----------
    color : (height, width, 3); of sides that `TILES` divides

    Returns
    -------
    (1 + TILES²,) float64; over all channels
    """
    grey = color.astype(np.float64).mean(axis=2)
    height, width = (side // TILES for side in grey.shape)
    tiles = grey.reshape(TILES, height, TILES, width).mean(axis=(1, 3)).ravel()
    return np.concatenate([[grey.mean()], tiles])


def path_traced(
    scene: Scene,
    size: tuple[int, int],
    bounces: int,
    samples: int,
    remaining: Callable[[], float] = for_ever,
) -> Truth:
    """Indirect light by the plain path tracer, through pixel centres.

    Parameters
    ----------
    scene : Scene; any that can be rendered
    samples : int; of each pixel, at most
    remaining : callable; seconds that are left: half of them are spent here

    Returns
    -------
    Truth; the error is that of the mean of independent pictures

    Raises
    ------
    UnaskedError
        There was no time for `LEAST_SAMPLES`.
    """
    end = remaining() / 2
    width, height = size
    camera = replace(scene.camera, width=width, height=height)
    world = build_world(validate(replace(scene, camera=camera)))
    points = first_hits(world, *pixel_centers(width, height))
    pixel = np.arange(width * height, dtype=np.uint32)

    def one(number: int) -> Scalars:
        uniforms = KeyedUniforms(pixel, number, SEED, Stream.PATH)
        color = camera_radiance(world, points, "indirect", bounces, uniforms)
        return statistics(color.reshape(height, width, 3))

    pictures = []
    for number in range(samples):
        if (left := remaining()) <= 0 or left < end:
            break
        pictures.append(one(number))
    if len(pictures) < min(LEAST_SAMPLES, samples):
        raise UnaskedError("no time was left to trace the truth")
    found = np.stack(pictures)
    error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    return Truth(found.mean(axis=0), error, len(found))
