"""What the means of a picture should be: path traced, with its own error."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.oracle.blackbox.tiles import (
    COLUMNS,
    PLACES,
    columns,
    tile_means,
)

LEAST_SAMPLES = 256
"""Of each pixel: so many that the means are nearly normal."""

MOST_SAMPLES = 2**16


def rows_of(color: NDArray[np.floating]) -> Vec3s:
    """All numbers of a picture whose moments are kept.

    Parameters
    ----------
    color : (H, W, 3); of sides that `tiles.TILES` divides

    Returns
    -------
    (H · W + COLUMNS, 3) float64
        Pixels; and columns of the picture's means, three times each.
    """
    means = np.repeat(columns(tile_means(color))[:, None], 3, axis=1)
    return np.concatenate([color.reshape(-1, 3).astype(np.float64), means])


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Means of a picture and of its tiles, by so many samples of each pixel.

    Attributes
    ----------
    moments : Moments; of `rows_of` pictures of a sample a pixel
    size : (int, int); width and height
    """

    moments: Moments
    size: tuple[int, int]

    @property
    def samples(self) -> int:
        """Of each pixel."""
        return self.moments.count

    @property
    def mean(self) -> Scalars:
        """(COLUMNS,) float64; over all channels."""
        found: Scalars = self.moments.mean[-COLUMNS:, 0]
        return found

    @property
    def deviation(self) -> Scalars:
        """Standard deviation of one sample a pixel, (COLUMNS,) float64."""
        found: Scalars = np.sqrt(self.moments.variance()[-COLUMNS:, 0])
        return found

    @property
    def standard_error(self) -> Scalars:
        """(COLUMNS,) float64; of the mean."""
        found: Scalars = self.deviation / np.sqrt(self.samples)
        return found

    @property
    def channels(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Means of each channel and their errors, (PLACES, 3) each."""
        shape = (PLACES, 3)
        mean, error = self.mean[PLACES:], self.standard_error[PLACES:]
        return mean.reshape(shape), error.reshape(shape)

    @property
    def picture(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Means of pixels and their errors, (H, W, 3) each."""
        width, height = self.size
        pixels = slice(0, width * height)
        shape = (height, width, 3)
        error = self.moments.standard_error()
        return self.moments.mean[pixels].reshape(shape), error[pixels].reshape(shape)
