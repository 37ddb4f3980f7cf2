"""Errors as pictures: one colour scale each, with its bar."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images.display import MARKER, Bytes
from restir_gi.reference.images.image import Floats, luminance
from restir_gi.reference.images.metrics import EPSILON

SIGNED, UNSIGNED = "RdBu_r", "inferno"  # blue, white, red; black to yellow
Z_SCALE = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class ErrorMap:
    """A picture of one error.

    Attributes
    ----------
    name : str; of the file, without ending
    title, meaning : str; what it is, and how to read it
    values : (H, W) float; NaN where a pixel was left out
    low, high : float
        Values at the ends of the colour scale; beyond them the colour stays.
    colors : str; scale, by matplotlib's name
    left_out : (int, int, int); colour of pixels that were left out
    """

    name: str
    title: str
    meaning: str
    values: Floats
    low: float
    high: float
    colors: str
    left_out: tuple[int, int, int] = MARKER

    def pixels(self) -> Bytes:
        """Coloured (H, W, 3) uint8."""
        known = ~np.isnan(self.values)
        t = (np.where(known, self.values, self.low) - self.low) / (self.high - self.low)
        colored = np.where(known[..., None], _colored(t, self.colors), self.left_out)
        return colored.astype(np.uint8)

    def bar(self, steps: int = 17) -> Bytes:
        """Colour bar, (steps, 3) uint8; from low to high."""
        return _colored(np.linspace(0, 1, steps), self.colors)


def _colored(t: Floats, colors: str) -> Bytes:
    from matplotlib import colormaps

    pixels: Bytes = colormaps[colors](np.clip(t, 0, 1), bytes=True)[..., :3]
    return pixels


def difference_map(a: Floats, b: Floats) -> ErrorMap:
    """Signed luminance of A − B, on a scale that is symmetric about 0.

    Parameters
    ----------
    a, b : (H, W, 3) float64; image and truth; NaN where a pixel is left out
    """
    values = luminance(a) - luminance(b)
    limit = scale_of(values[~np.isnan(values)])
    meaning = (
        "Luminance of A − B: red where A is brighter, blue where it is darker. The"
        " scale ends at the 99th percentile of its size."
    )
    return ErrorMap(
        "difference", "Signed difference", meaning, values, -limit, limit, SIGNED
    )


def relative_error_map(a: Floats, b: Floats) -> ErrorMap:
    """Share of each pixel in `metrics.mape`.

    Parameters
    ----------
    a, b : (H, W, 3) float64; image and truth; NaN where a pixel is left out

    Returns
    -------
    ErrorMap; on a scale from 0 to 100 %, the same for all pairs of images
    """
    values = np.mean(np.abs(a - b) / (np.abs(b) + EPSILON), axis=-1)
    meaning = (
        f"Mean over the channels of |A − B| / (|B| + {EPSILON}). The mean of this map"
        " is MAPE."
    )
    return ErrorMap(
        "relative_error", "Relative error", meaning, values, 0.0, 1.0, UNSIGNED
    )


def flip_map(error: Floats) -> ErrorMap:
    """What a viewer notices, on FLIP's own scale from 0 to 1.

    Parameters
    ----------
    error : (H, W) float; as `flip.flip_hdr` gives it; NaN where a pixel is left out
    """
    meaning = (
        "HDR-FLIP: what a viewer notices who flips between A and B, at the exposure"
        " where it shows most."
    )
    return ErrorMap("flip", "FLIP", meaning, error, 0.0, 1.0, UNSIGNED)


def z_map(z: Floats) -> ErrorMap:
    """Of each pixel's three z scores the one furthest from 0.

    Parameters
    ----------
    z : (H, W, 3) float64
        As `metrics.z_scores` gives them; NaN where a pixel is left out.

    Returns
    -------
    ErrorMap; on a scale of ±`Z_SCALE` standard deviations
    """
    furthest = np.argmax(np.abs(z), axis=-1, keepdims=True)
    values = np.take_along_axis(z, furthest, axis=-1)[..., 0]
    meaning = (
        "(A − B) / standard error, in the channel where it is largest. Noise is"
        " speckle of both colours, bias an area of one."
    )
    return ErrorMap("z", "z score", meaning, values, -Z_SCALE, Z_SCALE, SIGNED)


def scale_of(difference: Floats) -> float:
    """99th percentile of |d|, so that a firefly does not hide the rest.

    Parameters
    ----------
    difference : (...) float; d

    Returns
    -------
    float; never 0: the largest |d| if the percentile is 0, and 1 if that is 0 as well
    """
    size = np.abs(difference)
    return float(np.percentile(size, 99) or size.max() or 1.0)
