"""Errors of differences and of images against path tracing: MSE, relMSE and FLIP."""

import numpy as np

from restir_gi.gradient_domain.reconstruction import Differences, differences
from restir_gi.reference.images import metrics
from restir_gi.reference.images.display import Bytes
from restir_gi.reference.images.flip import flip_hdr, flip_ldr
from restir_gi.reference.images.image import to_image
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.intervals import Numbers
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.figures.spread import spreads

QUANTILE = 0.99
"""Of true differences, by magnitude, that is drawn as black or white."""


def gradient_errors(estimates: list[Scalars], pixels: Scalars | None = None) -> Numbers:
    """Mean squared error of the differences of each run.

    Parameters
    ----------
    estimates : list of (N, 9) float64
        Pixels, and differences to the right and down; runs, all unbiased.
    pixels : (N, 2) bool, optional; which differences to the right and down count

    Returns
    -------
    (R,) float64; by how far runs spread; no truth is needed
    """
    both = [np.concatenate([e[:, 3:6], e[:, 6:9]]) for e in estimates]
    if pixels is not None:
        at = np.flatnonzero(pixels.T.ravel())
        both = [rows[at] for rows in both]
    return spreads(both)


def relative_gradient_errors(
    estimates: list[Scalars], truth: Moments, width: int
) -> Numbers:
    """Relative mean squared error of the differences of each run.

    Parameters
    ----------
    estimates : list of (N, 9) float64
        Pixels, and differences to the right and down; runs, all unbiased.
    truth : Moments; path-traced

    Returns
    -------
    (R,) float64
        Relative to the light b of a pair, the mean of its two pixels: true differences
        are 0 nearly everywhere.  Squared errors are divided by b² + ε, as in `rel_mse`.
    """
    true = differences(truth.mean, width)
    light = truth.mean + np.array([true.x, true.y]) / 2
    scale = 1.0 / np.sqrt(light**2 + metrics.EPSILON)
    both = [np.array([e[:, 3:6], e[:, 6:9]]) * scale for e in estimates]
    return spreads([rows.reshape(-1, 3) for rows in both])


def image_errors(images: list[Vec3s], truth: Moments) -> tuple[Numbers, Numbers]:
    """MSE and relative MSE of each image, without the share of the truth's own noise.

    Parameters
    ----------
    images : list of (N, 3) float64; runs
    truth : Moments; path-traced

    Returns
    -------
    (R,), (R,) float64; biased images count with their bias
    """
    true, variance = truth.mean, truth.standard_error() ** 2
    mse = np.array([metrics.mse(i, true, variance) for i in images])
    relative = np.array([metrics.rel_mse(i, true, variance) for i in images])
    return mse, relative


def image_flips(images: list[Vec3s], truth: Moments, width: int) -> Numbers:
    """FLIP of each image.

    Parameters
    ----------
    images : list of (N, 3) float64; runs
    truth : Moments; path-traced; its noise is seen as well

    Returns
    -------
    (R,) float64; mean over the pixels, 0 for no difference that is seen
    """
    height = len(truth.mean) // width

    def shown(rows: Vec3s) -> Scalars:
        return to_image(np.maximum(rows, 0.0), width, height)

    true = shown(truth.mean)
    return np.array([flip_hdr(shown(i), true)[1] for i in images])


def gradient_picture(d: Differences, truth: Moments, width: int) -> Bytes:
    """Differences to the right as a screen takes them: grey for none.

    Parameters
    ----------
    d : Differences; N rows
    truth : Moments; path-traced: what is black and white is told by its differences

    Returns
    -------
    (H, W, 3) uint8; brighter where the right neighbour is
    """
    true = np.abs(differences(truth.mean, width).x)
    scale = max(float(np.quantile(true, QUANTILE)), 1e-300)
    grey = np.clip(0.5 + 0.5 * d.x / scale, 0.0, 1.0)
    return to_image(np.rint(255 * grey), width, len(d.x) // width).astype(np.uint8)


def gradient_flips(estimates: list[Scalars], truth: Moments, width: int) -> Numbers:
    """FLIP of the pictures of differences of each run.

    Parameters
    ----------
    estimates : list of (N, 9) float64; runs
    truth : Moments; path-traced

    Returns
    -------
    (R,) float64; mean over the pixels
    """
    true = gradient_picture(differences(truth.mean, width), truth, width)
    pictures = (
        gradient_picture(Differences(e[:, 3:6], e[:, 6:9]), truth, width)
        for e in estimates
    )
    return np.array([flip_ldr(picture, true)[1] for picture in pictures])
