"""FLIP, the difference a viewer sees who flips between two images [Andersson20]."""

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.display import Bytes
from restir_gi.reference.images.image import Floats, luminance

ACES_85 = 2.1188723  # radiance that FLIP's ACES curve maps to 0.85
MOST_EXPOSURES = 32  # FLIP takes one a stop, about 2 s each at 1920 x 1080


def flip_ldr(a: Bytes, b: Bytes) -> tuple[NDArray[np.float32], float]:
    """FLIP between two displayed images, at 67 pixels a degree.

    Parameters
    ----------
    a, b : (H, W, 3) uint8; image and truth, as `to_display` makes them

    Returns
    -------
    (H, W) float32, float; error in [0, 1], and its mean
    """
    return _evaluate(a.astype(np.float32) / 255, b.astype(np.float32) / 255, "LDR", {})


def flip_hdr(a: Floats, b: Floats) -> tuple[NDArray[np.float32], float]:
    """HDR-FLIP: the largest error over all exposures that suit the truth.

    [Andersson21].  The exposures are given, not left to the library: for a truth that
    is mostly black its own choice runs over 20 stops too far, and for one that is all
    black it ends the *process*, with no exception.

    Parameters
    ----------
    a, b : (H, W, 3) float
        Image and truth, linear radiance, finite; negative counts as 0.

    Returns
    -------
    (H, W) float32, float; error in [0, 1], and its mean
    """
    lit = np.maximum(b, 0), np.maximum(a, 0)
    exposures = _exposures(lit[0] if lit[0].any() else lit[1])
    return _evaluate(lit[1], lit[0], "HDR", exposures)


def _exposures(rgb: Floats) -> dict[str, float]:
    """Choose the stops that bring the brightest and the median lit pixel to 0.85."""
    y = luminance(rgb.astype(np.float64))
    lit = y[y > 0] if y.any() else np.ones(1)
    # Beyond 100 stops the library's float32 powers of two overflow.
    start, stop = np.clip(
        np.log2(ACES_85 / np.array([lit.max(), np.median(lit)])), -100, 100
    )
    count = min(max(ceil(stop - start), 2), MOST_EXPOSURES)
    return {
        "startExposure": float(start),
        "stopExposure": float(stop),
        "numExposures": count,
    }


def _evaluate(
    a: Floats, b: Floats, dynamic_range: str, parameters: dict[str, Any]
) -> tuple[NDArray[np.float32], float]:
    import flip_evaluator

    error, mean, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(b, np.float32),
        np.ascontiguousarray(a, np.float32),
        dynamic_range,
        applyMagma=False,
        parameters=parameters,
    )
    return error[..., 0], float(mean)
