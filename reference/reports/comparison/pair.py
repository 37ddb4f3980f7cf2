"""Two images made comparable: one size, and only pixels that are finite in both."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.image import Image
from restir_gi.reference.system.errors import UsageError

Colors = NDArray[np.float64]

LAYER = "standard_error"


@dataclass(frozen=True, slots=True, eq=False)
class ImagePair:
    """Image A and the truth B over the same pixels.

    Attributes
    ----------
    finite_a, finite_b : (H, W) bool
        Pixels with no NaN or infinity in the colour or its standard error.
    a, b : (H, W, 3) float64; linear radiance, NaN where a pixel is not finite in both
    variance_a, variance_b : (H, W, 3) float64 or None
        Squared standard error; None where the image has none.
    """

    finite_a: NDArray[np.bool_]
    finite_b: NDArray[np.bool_]
    a: Colors
    b: Colors
    variance_a: Colors | None
    variance_b: Colors | None

    @property
    def finite(self) -> NDArray[np.bool_]:
        """Pixels that are compared, (H, W)."""
        return self.finite_a & self.finite_b

    @property
    def variance(self) -> Colors | None:
        """Of A - B, (H, W, 3) float64, as far as it is known."""
        if self.variance_a is None or self.variance_b is None:
            return self.variance_b if self.variance_a is None else self.variance_a
        return self.variance_a + self.variance_b


def match(a: Image, b: Image, names: tuple[str, str]) -> ImagePair:
    """Put image A beside the truth B, with at least one finite pixel.

    Parameters
    ----------
    a, b : Image; a layer ``"standard_error"`` in either is used

    Raises
    ------
    UsageError
        Sizes differ, or no pixel is finite in both.
    """
    if (a.width, a.height) != (b.width, b.height):
        raise UsageError(
            f"{names[0]} has {a.width}x{a.height} pixels and {names[1]}"
            f" {b.width}x{b.height}; compare images of one size"
        )
    finite_a, finite_b = _finite(a), _finite(b)
    finite = (finite_a & finite_b)[..., None]
    if not finite.any():
        raise UsageError(
            f"no pixel is finite in both {names[0]} and {names[1]};"
            " render them again without NaN and infinities"
        )
    color_a, color_b = (
        np.where(finite, image.color, np.nan).astype(np.float64) for image in (a, b)
    )
    return ImagePair(finite_a, finite_b, color_a, color_b, _variance(a), _variance(b))


def _finite(image: Image) -> NDArray[np.bool_]:
    used = [image.layers[name] for name in ("color", LAYER) if name in image.layers]
    finite: NDArray[np.bool_] = np.logical_and.reduce(
        [np.isfinite(layer).all(axis=-1) for layer in used]
    )
    return finite


def _variance(image: Image) -> Colors | None:
    if LAYER not in image.layers:
        return None
    error = np.broadcast_to(image.layers[LAYER], image.color.shape)
    return error.astype(np.float64) ** 2
