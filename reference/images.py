"""Frames as pictures: the only place where (H, W, 3) exists, and how it is shown."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.arrays import dot
from reference.files import write_file

Floats = NDArray[np.floating[Any]]
Bytes = NDArray[np.uint8]

MARKER = (255, 0, 255)  # magenta: no radiance looks like this by chance


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """Layers of one size, with the words that say where they come from.

    Attributes
    ----------
    layers : mapping of str to (H, W, C) float32
        ``"color"`` is the picture, C = 3, linear Rec. 709 radiance.  Further layers
        have C = 1 or 3; ``"standard_error"`` is that of ``"color"``.
    metadata : mapping of str to str
        Scene, method, settings, seed, version.
    """

    layers: Mapping[str, Floats]
    metadata: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if "color" not in self.layers or self.color.shape[2:] != (3,):
            raise ValueError('an image needs a layer "color" of shape (H, W, 3)')
        for name, layer in self.layers.items():
            size_fits = layer.shape[:2] == self.color.shape[:2]
            if not size_fits or layer.shape[2:] not in ((1,), (3,)):
                raise ValueError(f"layer {name!r} has shape {layer.shape}")
            if layer.dtype != np.float32:
                raise ValueError(f"layer {name!r} is {layer.dtype}, not float32")

    @property
    def color(self) -> Floats:
        """The picture itself, (H, W, 3)."""
        return self.layers["color"]

    @property
    def width(self) -> int:
        """Pixels in a row."""
        return int(self.color.shape[1])

    @property
    def height(self) -> int:
        """Rows of pixels."""
        return int(self.color.shape[0])


def to_image(rows: Floats, width: int, height: int) -> NDArray[np.float32]:
    """Frame as a layer: row y·W + x becomes pixel (y, x).

    Parameters
    ----------
    rows : (N,) or (N, C) float, N = width * height
        Any precision; beyond the range of float32 it becomes infinite, for
        comparisons to report.

    Returns
    -------
    (height, width, C) float32
        C = 1 for scalars.
    """
    if len(rows) != width * height:
        raise ValueError(f"{len(rows)} rows are no {width}x{height} frame")
    with np.errstate(over="ignore"):
        return rows.astype(np.float32).reshape(height, width, -1)


def to_rows(layer: Floats) -> Floats:
    """Layer as a frame: the inverse of `to_image`, (H, W, C) to (H·W, C)."""
    return layer.reshape(-1, layer.shape[2])


def luminance_weights() -> tuple[float, float, float]:
    """Share of R, G and B in luminance Y: the middle row of RGB to XYZ, Rec. 709.

    Notes
    -----
    The first call imports colour-science, which takes about a second.
    """
    from colour.models import RGB_COLOURSPACE_sRGB

    red, green, blue = RGB_COLOURSPACE_sRGB.matrix_RGB_to_XYZ[1]
    return float(red), float(green), float(blue)


def luminance(rgb: Floats) -> Floats:
    """Luminance Y = w · rgb of linear Rec. 709 colours, (..., 3) to (...)."""
    return dot(rgb, np.array(luminance_weights()))


def encode_srgb(linear: Floats) -> Floats:
    """Values a screen expects for linear light in [0, 1].

    1.055 c^(1/2.4) - 0.055 above 0.0031308, and 12.92 c below, where the power would
    be too steep.  Written out rather than imported: two lines of IEC 61966-2-1, and a
    PNG need not wait a second for colour-science, which the tests compare it with.
    """
    power = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, power)


def auto_exposure(rgb: Floats) -> float:
    """Factor that brings the 95th percentile of luminance to 0.8.

    A percentile, because the maximum is a lamp or a firefly; of the lit pixels,
    because a scene may be black but for a gap.

    Parameters
    ----------
    rgb : (H, W, 3) float
        Linear radiance; pixels that are not finite do not count.

    Returns
    -------
    float
        1 for a black image.
    """
    y = luminance(rgb[np.isfinite(rgb).all(axis=-1)].astype(np.float64))
    lit = y[y > 0]
    return float(0.8 / np.percentile(lit, 95)) if lit.size else 1.0


def to_display(rgb: Floats, exposure: float) -> Bytes:
    """Pixels of a screen: exposed, clipped, sRGB, 8 bit.

    Parameters
    ----------
    rgb : (H, W, 3) float
        Linear radiance.
    exposure : float
        Factor on it; 1 leaves it as it is.

    Returns
    -------
    (H, W, 3) uint8
        Magenta where the radiance is not finite.
    """
    finite = np.isfinite(rgb).all(axis=-1, keepdims=True)
    exposed = np.where(finite, rgb, 0.0).astype(np.float64) * exposure
    encoded = np.rint(255 * encode_srgb(np.clip(exposed, 0, 1))).astype(np.uint8)
    return np.where(finite, encoded, np.array(MARKER, np.uint8))


def encode_png(pixels: Bytes) -> bytes:
    """PNG file of (H, W, 3) uint8 pixels."""
    from PIL import Image as Pillow

    buffer = BytesIO()
    Pillow.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()


def write_png(path: Path, rgb: Floats, exposure: float) -> None:
    """Write linear radiance (H, W, 3) as a PNG; see `to_display` and `write_file`."""
    write_file(path, encode_png(to_display(rgb, exposure)))
