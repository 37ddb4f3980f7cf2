"""Means over square tiles of a picture."""

import numpy as np

from restir_gi.reference.images.image import luminance
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.intervals import Numbers

TILE = 8  # pixels


def tile_means(rows: Vec3s, width: int, tile: int = TILE) -> Vec3s:
    """Means of the whole tiles of a frame, (T, 3) float64; row by row.

    Parameters
    ----------
    rows : (N, 3) float64; the frame
    width : int, pixels
        Of the frame; what is left beyond the last whole tile does not count.
    tile : int, pixels; width and height of a tile; of a frame that is smaller, its own
    """
    image = rows.reshape(-1, width, 3)
    tall, wide = min(tile, len(image)), min(tile, width)
    down, across = len(image) // tall, width // wide
    whole = image[: down * tall, : across * wide]
    parts = whole.reshape(down, tall, across, wide, 3)
    means: Vec3s = parts.mean(axis=(1, 3)).reshape(-1, 3)
    return means


def tile_luminance(rows: Vec3s, size: int, tile: int = TILE) -> Numbers:
    """Mean luminance of the whole tiles of a frame.

    Parameters
    ----------
    rows : (size · size, 3) float64; linear radiance
    size : int, pixels
        Width and height, at least ``tile``; what is left beyond the last whole tile
        does not count.

    Returns
    -------
    (tiles, tiles) float64; row and column
    """
    count = size // tile
    whole = luminance(rows).reshape(size, size)[: count * tile, : count * tile]
    means: Numbers = whole.reshape(count, tile, count, tile).mean(axis=(1, 3))
    return means


def largest_of_half(values: Numbers) -> tuple[int, float, float]:
    """Column that deviates most from 0, with an honest mean.

    Parameters
    ----------
    values : (R, K) float64; K deviations of each of R runs, at least four runs

    Returns
    -------
    index : int; column whose mean over the even runs is the largest in size
    mean, error : float
        Its mean and standard error over the odd runs, which had no part in the
        choice: the largest of many noisy means is too large.
    """
    index = int(np.argmax(np.abs(values[::2].mean(axis=0))))
    return index, *mean_and_error(values[1::2, index])


def rms_without_noise(values: Numbers) -> float:
    """Root mean square of the expectations of many noisy numbers.

    √ max(0, mean over k of E_even E_odd), with the means of the even and of the odd
    runs: their noises are independent, so that the product has the square of the
    expectation as its own, and no noise is taken for signal.

    Parameters
    ----------
    values : (R, K) float64; K numbers of each of R independent runs, at least two runs
    """
    product = values[::2].mean(axis=0) * values[1::2].mean(axis=0)
    return float(np.sqrt(max(0.0, product.mean())))


def mean_and_error(values: Numbers) -> tuple[float, float]:
    """Mean of runs, and its standard error.

    Parameters
    ----------
    values : (R,) float64; a number a run, at least two runs
    """
    error = values.std(ddof=1) / np.sqrt(len(values))
    return float(values.mean()), float(error)
