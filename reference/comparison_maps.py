"""Errors as pictures: one colour scale each, with its bar."""

from dataclasses import dataclass

import numpy as np

from reference.images import MARKER, Bytes, Floats, luminance
from reference.metrics import EPSILON

SIGNED, UNSIGNED = "RdBu_r", "inferno"  # blue, white, red; black to yellow
Z_SCALE = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class ErrorMap:
    """A picture of one error.

    Attributes
    ----------
    name : str
        Of the file, without ending.
    title, meaning : str
        What it is, and how to read it.
    values : (H, W) float
        NaN where a pixel was left out.
    low, high : float
        Values at the ends of the colour scale; beyond them the colour stays.
    colors : str
        Scale, by matplotlib's name.
    """

    name: str
    title: str
    meaning: str
    values: Floats
    low: float
    high: float
    colors: str

    def pixels(self) -> Bytes:
        """Coloured (H, W, 3) uint8; magenta where a pixel was left out."""
        known = ~np.isnan(self.values)
        t = (np.where(known, self.values, self.low) - self.low) / (self.high - self.low)
        return np.where(known[..., None], _colored(t, self.colors), MARKER).astype(
            np.uint8
        )

    def bar(self, steps: int = 17) -> Bytes:
        """Colours from low to high, (steps, 3) uint8."""
        return _colored(np.linspace(0, 1, steps), self.colors)


def _colored(t: Floats, colors: str) -> Bytes:
    from matplotlib import colormaps

    pixels: Bytes = colormaps[colors](np.clip(t, 0, 1), bytes=True)[..., :3]
    return pixels


def difference_map(a: Floats, b: Floats) -> ErrorMap:
    """Signed luminance of A - B, for (H, W, 3) images."""
    values = luminance(a) - luminance(b)
    limit = scale_of(values[~np.isnan(values)])
    meaning = (
        "Luminance of A - B: red where A is brighter, blue where it is darker. The"
        " scale ends at the 99th percentile of its size."
    )
    return ErrorMap(
        "difference", "Signed difference", meaning, values, -limit, limit, SIGNED
    )


def relative_error_map(a: Floats, b: Floats) -> ErrorMap:
    """What each pixel of two (H, W, 3) images adds to `metrics.mape`."""
    values = np.mean(np.abs(a - b) / (np.abs(b) + EPSILON), axis=-1)
    meaning = (
        f"Mean over the channels of |A - B| / (|B| + {EPSILON}). The mean of this map"
        " is MAPE."
    )
    return ErrorMap(
        "relative_error", "Relative error", meaning, values, 0.0, 1.0, UNSIGNED
    )


def flip_map(error: Floats) -> ErrorMap:
    """FLIP error (H, W) as `flip.flip_hdr` gives it."""
    meaning = (
        "HDR-FLIP: what a viewer notices who flips between A and B, at the exposure"
        " where it shows most."
    )
    return ErrorMap("flip", "FLIP", meaning, error, 0.0, 1.0, UNSIGNED)


def z_map(z: Floats) -> ErrorMap:
    """Of each pixel's three z scores (H, W, 3), the one furthest from 0."""
    furthest = np.argmax(np.abs(z), axis=-1, keepdims=True)
    values = np.take_along_axis(z, furthest, axis=-1)[..., 0]
    meaning = (
        "(A - B) / standard error, in the channel where it is largest. Noise is"
        " speckle of both colours, bias an area of one."
    )
    return ErrorMap("z", "z score", meaning, values, -Z_SCALE, Z_SCALE, SIGNED)


def scale_of(difference: Floats) -> float:
    """99th percentile of |d|, so that a firefly does not hide the rest; never 0."""
    size = np.abs(difference)
    return float(np.percentile(size, 99) or size.max() or 1.0)
