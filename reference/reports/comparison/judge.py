"""Two images side by side: the numbers, and the folder of pictures that shows them."""

from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from restir_gi.reference.images import metrics
from restir_gi.reference.images.display import auto_exposure, to_display
from restir_gi.reference.images.flip import flip_hdr, flip_ldr
from restir_gi.reference.images.image import Floats, Image
from restir_gi.reference.reports.comparison.maps import (
    ErrorMap,
    difference_map,
    flip_map,
    relative_error_map,
    z_map,
)
from restir_gi.reference.reports.comparison.page import write_pages
from restir_gi.reference.reports.comparison.pair import ImagePair, match


@dataclass(frozen=True, slots=True)
class Comparison:
    """Image A judged against image B, the truth; formulas in `metrics` and `flip`.

    Attributes
    ----------
    not_finite_a, not_finite_b : int
        Pixels with a NaN or an infinity, in the colour or the standard error.  All
        that follows is over the pixels finite in both.
    exposure : float
        Factor under which both are displayed, and ``flip_ldr`` is taken: that of B.
    mean_a, mean_b : (float, float, float); mean of each channel
    relative_bias, mse, rmse, rel_mse, mape, smape, flip_ldr, flip_hdr : float
        A against B as they are; the noise of B counts as error.
    mse_of_b : float or None; mean squared standard error of B: its share of ``mse``
    mse_corrected, rel_mse_corrected : float or None
        Without that share.  None where B has no layer ``"standard_error"``.
    z_rms : float or None
        Root mean square of the z scores: 1 without bias, if both standard errors are
        known and honest.  None where neither is known.
    z_above_3 : float or None; share of |z| > 3
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
    mse_of_b: float | None = None
    mse_corrected: float | None = None
    rel_mse_corrected: float | None = None
    z_rms: float | None = None
    z_above_3: float | None = None

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
    a, b : Image; of one size; a layer ``"standard_error"`` in either is used
    out : Path, optional
        Folder for the pictures and ``index.html``; made if it is missing.
    names : (str, str); what messages and the page call them

    Raises
    ------
    UsageError
        Sizes differ, no pixel is finite in both, or ``out`` cannot be written.
    """
    pair = match(a, b, names)
    # FLIP looks around each pixel: those left out are black in both.
    full_a, full_b = np.nan_to_num(pair.a), np.nan_to_num(pair.b)
    exposure = auto_exposure(full_b)
    shown_a, shown_b = (to_display(full, exposure) for full in (full_a, full_b))
    flip, mean_flip = flip_hdr(full_a, full_b)
    numbers = Comparison(
        width=a.width,
        height=a.height,
        not_finite_a=int(np.sum(~pair.finite_a)),
        not_finite_b=int(np.sum(~pair.finite_b)),
        exposure=exposure,
        flip_ldr=flip_ldr(shown_a, shown_b)[1],
        flip_hdr=mean_flip,
        **_distances(pair),
        **_significance(pair),
    )
    if out is not None:
        write_pages(out, (a, b), names, numbers.as_dict(), _maps(pair, flip))
    return numbers


def _distances(pair: ImagePair) -> dict[str, Any]:
    a, b = pair.a[pair.finite], pair.b[pair.finite]
    return {
        "mean_a": metrics.channel_means(a),
        "mean_b": metrics.channel_means(b),
        "relative_bias": metrics.relative_bias(a, b),
        "mse": metrics.mse(a, b),
        "rmse": metrics.rmse(a, b),
        "rel_mse": metrics.rel_mse(a, b),
        "mape": metrics.mape(a, b),
        "smape": metrics.smape(a, b),
    }


def _significance(pair: ImagePair) -> dict[str, Any]:
    """Numbers that need a standard error, as far as it is known."""
    a, b = pair.a[pair.finite], pair.b[pair.finite]
    found = {}
    if pair.variance_b is not None:
        variance_b = pair.variance_b[pair.finite]
        found["mse_of_b"] = float(np.mean(variance_b))
        found["mse_corrected"] = metrics.mse(a, b, variance_b)
        found["rel_mse_corrected"] = metrics.rel_mse(a, b, variance_b)
    if pair.variance is not None:
        variance = pair.variance[pair.finite]
        z = metrics.z_scores(a, b, variance)
        found["z_above_3"] = metrics.excess(z, 3.0)
        if variance.any():
            found["z_rms"] = metrics.rms(z[variance > 0])
    return found


def _maps(pair: ImagePair, flip: Floats) -> list[ErrorMap]:
    maps = [
        difference_map(pair.a, pair.b),
        relative_error_map(pair.a, pair.b),
        flip_map(np.where(pair.finite, flip, np.nan)),
    ]
    if pair.variance is not None:
        z = np.full(pair.a.shape, np.nan)
        z[pair.finite] = metrics.z_scores(
            pair.a[pair.finite], pair.b[pair.finite], pair.variance[pair.finite]
        )
        maps.append(z_map(z))
    return maps
