"""Pictures of exponential light, and their truths in closed form."""

import numpy as np

from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance
from restir_gi.reference.oracle.blackbox.judge import judge_pictures
from restir_gi.reference.oracle.blackbox.tiles import PLACES, TILES, tile_means
from restir_gi.reference.oracle.blackbox.truth import Truth, rows_of

HEIGHT, WIDTH = 16, 24
SAMPLES = 2**16
ASKED = Convention()


def light(convention=ASKED):
    """Means of pixels, (HEIGHT, WIDTH, 3), of no symmetry, unlike in each channel."""
    y, x = np.mgrid[0 : 1 : HEIGHT * 1j, 0 : 1 : WIDTH * 1j]
    red_green_blue = (0.3 + x, 0.4 + 0.5 * y, 0.2 + 0.6 * (1 - x) * y)
    mean = np.stack(red_green_blue, axis=-1) * convention.bounces
    if convention.pixel == "box":
        mean *= 1 + 0.3 * np.sin(9 * x)[..., None]
    if convention.light != "indirect":
        mean += x[..., None] ** 2
    return mean


def truth_of(mean):
    """Of independent exponential pixels, whose variances are their squared means."""
    squares = mean**2
    pixels = np.full(PLACES, HEIGHT * WIDTH / TILES**2)
    pixels[0] = HEIGHT * WIDTH
    channels = tile_means(squares) / pixels[:, None]
    every = np.concatenate([channels.sum(axis=1) / 9, channels.ravel()])
    means = np.repeat(every[:, None], 3, axis=1)
    variance = np.concatenate([squares.reshape(-1, 3), means])
    moments = Moments(SAMPLES, rows_of(mean), variance * (SAMPLES - 1))
    return Truth(moments, (WIDTH, HEIGHT))


def pictures_of(mean, count, samples=64, seed=0):
    """Pictures of so many samples of each pixel."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        noise = rng.gamma(samples, 1 / samples, size=mean.shape)
        yield (mean * noise).astype(np.float32)


def judged(pictures, dark=None, **options):
    """Verdict on pictures that should be of `light`.

    Parameters
    ----------
    dark : slice of rows of pixels where there is no light, or None
    """

    def truths(convention):
        mean = light(convention)
        if dark is not None:
            mean[dark] = 0
        return truth_of(mean)

    return judge_pictures(pictures, truths, ASKED, Tolerance(), **options)
