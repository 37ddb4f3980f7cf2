"""Frames as images of layers: the only place where (H, W, 3) is made of rows."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import dot

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """Layers of one size, with the words that say where they come from.

    Attributes
    ----------
    layers : mapping of str to (H, W, C) float32
        ``"color"`` is the picture, C = 3, linear Rec. 709 radiance.  Further layers
        have C = 1 or 3; ``"standard_error"`` is that of ``"color"``.
    metadata : mapping of str to str; scene, method, settings, seed, version
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
    rows : (N,) or (N, C) float
        Any precision; beyond the range of float32 it becomes infinite, for
        comparisons to report.
    width, height : int; pixels, N = width · height

    Returns
    -------
    (height, width, C) float32; C = 1 for scalars

    Raises
    ------
    ValueError
        There are fewer or more rows.
    """
    if len(rows) != width * height:
        raise ValueError(f"{len(rows)} rows do not make a {width}x{height} frame")
    with np.errstate(over="ignore"):
        return rows.astype(np.float32).reshape(height, width, -1)


def to_rows(layer: Floats) -> Floats:
    """Layer as a frame: the inverse of `to_image`.

    Parameters
    ----------
    layer : (H, W, C) float; of an image

    Returns
    -------
    (H·W, C) float; scalars too keep their axis, C = 1
    """
    return layer.reshape(-1, layer.shape[2])


def luminance_weights() -> tuple[float, float, float]:
    """Share of R, G and B in luminance Y: the middle row of RGB to XYZ, Rec. 709.

    Their sum is 1.
    """
    # Those of colour-science, which a test compares: importing it takes a second.
    return 0.2126, 0.7152, 0.0722


def luminance(rgb: Floats) -> Floats:
    """Luminance Y = w · rgb of linear Rec. 709 colours, with `luminance_weights` w.

    Parameters
    ----------
    rgb : (..., 3) float; linear radiance

    Returns
    -------
    (...) float64; NaN and infinities as they follow
    """
    return dot(rgb, np.array(luminance_weights()))
