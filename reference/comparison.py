"""Two images side by side: the numbers, and the folder of pictures that shows them."""

from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference import metrics
from reference.comparison_maps import (
    difference_map,
    flip_map,
    relative_error_map,
    z_map,
)
from reference.comparison_page import write_pages
from reference.errors import UsageError
from reference.flip import flip_hdr, flip_ldr
from reference.images import Image, auto_exposure, to_display

LAYER = "standard_error"


@dataclass(frozen=True, slots=True)
class Comparison:
    """Image A judged against image B, the truth; formulas in `metrics` and `flip`.

    Attributes
    ----------
    width, height : int
        Pixels.
    not_finite_a, not_finite_b : int
        Pixels with a NaN or an infinity, in the colour or the standard error.  All
        that follows is over the pixels finite in both.
    exposure : float
        Factor under which both are displayed, and ``flip_ldr`` is taken: that of B.
    mean_a, mean_b : (float, float, float)
        Mean of each channel.
    relative_bias, mse, rmse, rel_mse, mape, smape, flip_ldr, flip_hdr : float
        A against B as they are; the noise of B counts as error.
    mse_of_b : float or None
        Mean squared standard error of B: its share of ``mse``.
    mse_corrected, rel_mse_corrected : float or None
        Without that share.  None where B has no layer ``"standard_error"``.
    z_rms : float or None
        Root mean square of the z scores: 1 without bias, if both standard errors are
        known and honest.  None where neither is known.
    z_above_3 : float or None
        Share of |z| > 3.
    """

    width: int
    height: int
    not_finite_a: int
    not_finite_b: int
    exposure: float
    mean_a: tuple[float, float, float]
    mean_b: tuple[float, float, float]
    relative_bias: float
    mse: float
    rmse: float
    rel_mse: float
    mape: float
    smape: float
    flip_ldr: float
    flip_hdr: float
    mse_of_b: float | None
    mse_corrected: float | None
    rel_mse_corrected: float | None
    z_rms: float | None
    z_above_3: float | None

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON, which has no infinities: None stands for them."""
        return {
            name: None if isinstance(value, float) and not isfinite(value) else value
            for name, value in asdict(self).items()
        }


def compare(
    a: Image, b: Image, out: Path | None = None, names: tuple[str, str] = ("A", "B")
) -> Comparison:
    """Judge image A against image B, the truth.

    Parameters
    ----------
    a, b : Image
        Of one size; a layer ``"standard_error"`` in either is used.
    out : Path, optional
        Folder for the pictures and ``index.html``; made if it is missing.
    names : (str, str)
        What messages and the page call them.

    Returns
    -------
    Comparison
        The numbers.

    Raises
    ------
    UsageError
        Sizes differ, no pixel is finite in both, or ``out`` cannot be written.
    """
    if (a.width, a.height) != (b.width, b.height):
        raise UsageError(
            f"{names[0]} has {a.width}x{a.height} pixels and {names[1]}"
            f" {b.width}x{b.height}; compare images of one size"
        )
    finite = _finite(a) & _finite(b)
    if not finite.any():
        raise UsageError(
            f"no pixel is finite in both {names[0]} and {names[1]};"
            " render them again without NaN and infinities"
        )
    # Pixels left out: NaN in the maps, and black in both where FLIP looks around.
    kept = finite[..., None]
    marked_a, marked_b = (
        np.where(kept, image.color, np.nan).astype(np.float64) for image in (a, b)
    )
    full_a, full_b = (np.where(kept, marked, 0.0) for marked in (marked_a, marked_b))
    pixels_a, pixels_b = full_a[finite], full_b[finite]
    variance_a, variance_b = (_variance(image)[finite] for image in (a, b))
    z = metrics.z_scores(pixels_a, pixels_b, variance_a + variance_b)
    exposure = auto_exposure(full_b)
    shown_a, shown_b = (to_display(full, exposure) for full in (full_a, full_b))
    flip_error, mean_flip = flip_hdr(full_a, full_b)
    knows_b = LAYER in b.layers
    knows_any = knows_b or LAYER in a.layers
    numbers = Comparison(
        width=a.width,
        height=a.height,
        not_finite_a=int(np.sum(~_finite(a))),
        not_finite_b=int(np.sum(~_finite(b))),
        exposure=exposure,
        mean_a=metrics.channel_means(pixels_a),
        mean_b=metrics.channel_means(pixels_b),
        relative_bias=metrics.relative_bias(pixels_a, pixels_b),
        mse=metrics.mse(pixels_a, pixels_b),
        rmse=metrics.rmse(pixels_a, pixels_b),
        rel_mse=metrics.rel_mse(pixels_a, pixels_b),
        mape=metrics.mape(pixels_a, pixels_b),
        smape=metrics.smape(pixels_a, pixels_b),
        flip_ldr=flip_ldr(shown_a, shown_b)[1],
        flip_hdr=mean_flip,
        mse_of_b=float(np.mean(variance_b)) if knows_b else None,
        mse_corrected=(
            metrics.mse(pixels_a, pixels_b, variance_b) if knows_b else None
        ),
        rel_mse_corrected=(
            metrics.rel_mse(pixels_a, pixels_b, variance_b) if knows_b else None
        ),
        z_rms=metrics.rms(z) if knows_any else None,
        z_above_3=metrics.excess(z, 3.0) if knows_any else None,
    )
    if out is not None:
        maps = [
            difference_map(marked_a, marked_b),
            relative_error_map(marked_a, marked_b),
            flip_map(np.where(finite, flip_error, np.nan)),
        ]
        if knows_any:
            full_z = np.full(a.color.shape, np.nan)
            full_z[finite] = z
            maps.append(z_map(full_z))
        write_pages(out, (a, b), names, numbers, maps)
    return numbers


def _finite(image: Image) -> NDArray[np.bool_]:
    """Pixels with no NaN or infinity in the layers that are compared, (H, W)."""
    used = [image.layers[name] for name in ("color", LAYER) if name in image.layers]
    return np.logical_and.reduce([np.isfinite(layer).all(axis=-1) for layer in used])


def _variance(image: Image) -> NDArray[np.float64]:
    """Squared standard error, (H, W, 3); 0 where it is unknown."""
    error = image.layers.get(LAYER, np.zeros(image.color.shape))
    return np.broadcast_to(error, image.color.shape).astype(np.float64) ** 2
