"""Pictures of pictures: where their mean is off, to which side, and how far."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.display import (
    Bytes,
    auto_exposure,
    encode_png,
    to_display,
)
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.oracle.blackbox.judge import PicturesVerdict
from restir_gi.reference.oracle.blackbox.tiles import TILES
from restir_gi.reference.oracle.blackbox.truth import Truth
from restir_gi.reference.reports.comparison.maps import (
    SIGNED,
    Z_SCALE,
    ErrorMap,
    scale_of,
)

GREY = (128, 128, 128)
"""Of a pixel of which nothing can be said: no colour of the scale."""

IN_ERRORS = (
    "(mean − truth) / its standard error, both means over the channels, and the errors"
    " of the pictures and of the truth taken together: red where the renderer is too"
    " bright, blue where too dark. Noise is speckle of both colours, bias an area of"
    " one. Grey where neither varies; beyond the ends of the scale the colour stays."
)
IN_PERCENT = (
    "100 (mean − truth) / truth of each pixel, means over the channels: red where the"
    " renderer is too bright, blue where too dark. The scale ends at the 99th"
    " percentile of its size. Grey where the truth is dark."
)


def shown(verdict: PicturesVerdict) -> tuple[bytes, bytes | None]:
    """PNG of the truth, and of the mean of the pictures, at one exposure."""
    truth = verdict.truth.picture[0]
    exposure = auto_exposure(truth)
    mean = None
    if verdict.pixels is not None:
        pixels = verdict.pixels.mean.reshape(truth.shape)
        mean = encode_png(to_display(pixels, exposure))
    return encode_png(to_display(truth, exposure)), mean


def error_maps(verdict: PicturesVerdict) -> list[ErrorMap]:
    """Mean minus truth in units of its error and in per cent; of two pictures or more.

    Errors of channels, which share their paths, add up at most; so they do here.
    """
    pixels = verdict.pixels
    if pixels is None or pixels.count < 2:
        return []
    return [_in_errors(pixels, verdict.truth), _in_percent(pixels, verdict.truth)]


def _in_errors(pixels: Moments, truth: Truth) -> ErrorMap:
    expected, error = (each.mean(axis=-1) for each in truth.picture)
    mean, own_error = (
        each.mean(axis=-1).reshape(expected.shape)
        for each in (pixels.mean, pixels.standard_error())
    )
    values = _ratio(mean - expected, np.hypot(error, own_error))
    title = "Mean − truth, in units of its error"
    return ErrorMap("z", title, IN_ERRORS, values, -Z_SCALE, Z_SCALE, SIGNED, GREY)


def _in_percent(pixels: Moments, truth: Truth) -> ErrorMap:
    expected = truth.picture[0].mean(axis=-1)
    difference = pixels.mean.mean(axis=-1).reshape(expected.shape) - expected
    values = 100 * _ratio(difference, expected)
    known = values[np.isfinite(values)]
    limit = scale_of(known) if known.size else 1.0
    title = "Mean − truth, % of the truth"
    return ErrorMap("percent", title, IN_PERCENT, values, -limit, limit, SIGNED, GREY)


def _ratio(difference: NDArray[np.float64], unit: NDArray[np.float64]) -> Scalars:
    """NaN where the unit is 0."""
    unknown = np.full(difference.shape, np.nan)
    found: Scalars = np.divide(difference, unit, out=unknown, where=unit > 0)
    return found


def tints(means: Sequence[Mapping[str, Any]]) -> Bytes:
    """Colours behind the numbers of tiles, (TILES, TILES, 3) uint8.

    The half of the scale about its middle: dark letters can be read on all of it.
    """
    values = np.full((TILES, TILES), np.nan)
    for one in means:
        if one["x"] is not None and one["relative"] is not None:
            values[one["y"], one["x"]] = one["relative"]
    known = values[np.isfinite(values)]
    limit = 2 * float(np.abs(known).max(initial=0.0)) or 1.0
    light = (160, 160, 160)
    return ErrorMap("", "", "", values, -limit, limit, SIGNED, light).pixels()
