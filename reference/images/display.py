"""How linear radiance is shown: exposure, sRGB, 8 bit, PNG."""

from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.image import Floats, luminance
from restir_gi.reference.system.files import write_file

Bytes = NDArray[np.uint8]

MARKER = (255, 0, 255)  # magenta: no radiance looks like this by chance


def encode_srgb(linear: Floats) -> Floats:
    """Values a screen expects for linear light in [0, 1].

    Two lines of IEC 61966-2-1, written out so that a PNG need not wait a second for
    colour-science; the tests compare the two.

    Parameters
    ----------
    linear : (...) float; shares of full white

    Returns
    -------
    (...) float
        1.055 c^(1/2.4) − 0.055, and 12.92 c up to c = 0.0031308, where the power would
        be too steep.
    """
    power = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, power)


def auto_exposure(rgb: Floats) -> float:
    """Factor that brings the 95th percentile of luminance to 0.8; 1 for a black image.

    A percentile, because the maximum is a lamp or a firefly; of the lit pixels,
    because a scene may be black but for a gap.

    Parameters
    ----------
    rgb : (H, W, 3) float; linear radiance; pixels that are not finite do not count
    """
    y = luminance(rgb[np.isfinite(rgb).all(axis=-1)].astype(np.float64))
    lit = y[y > 0]
    return float(0.8 / np.percentile(lit, 95)) if lit.size else 1.0


def to_display(rgb: Floats, exposure: float) -> Bytes:
    """Pixels of a screen: exposed, clipped, sRGB, 8 bit.

    Parameters
    ----------
    rgb : (H, W, 3) float; linear radiance
    exposure : float; factor on it; 1 leaves it as it is

    Returns
    -------
    (H, W, 3) uint8; magenta where the radiance is not finite
    """
    finite = np.isfinite(rgb).all(axis=-1, keepdims=True)
    exposed = np.where(finite, rgb, 0.0).astype(np.float64) * exposure
    encoded = np.rint(255 * encode_srgb(np.clip(exposed, 0, 1))).astype(np.uint8)
    return np.where(finite, encoded, np.array(MARKER, np.uint8))


def encode_png(pixels: Bytes) -> bytes:
    """PNG file of a picture.

    Parameters
    ----------
    pixels : (H, W, 3) uint8; as a screen takes them
    """
    from PIL import Image as Pillow

    buffer = BytesIO()
    Pillow.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()


def write_png(path: Path, rgb: Floats, exposure: float) -> None:
    """Write linear radiance as a PNG.

    Parameters
    ----------
    path : Path; replaced in one step
    rgb : (H, W, 3) float; linear radiance
    exposure : float; factor on it, as in `to_display`

    Raises
    ------
    UsageError
        The file cannot be written; see `write_file`.
    """
    write_file(path, encode_png(to_display(rgb, exposure)))
