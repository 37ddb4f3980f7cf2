"""Histogram of signed differences, as bars of a picture."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images.image import Floats


@dataclass(frozen=True, slots=True)
class Bar:
    """One bin: its middle, its count, and its height from 0 to 1."""

    middle: float
    count: int
    height: float


def histogram_bars(values: Floats, limit: float, bins: int = 61) -> list[Bar]:
    """Count values in bins from -limit to limit.

    Parameters
    ----------
    values : (...) float; NaN does not count
    limit : float; what lies beyond goes into the outermost bins
    bins : int; odd, so that 0 is the middle of one

    Returns
    -------
    list of Bar; heights are logarithmic, log(1 + count), for the tails are what matters
    """
    inside = np.clip(values[~np.isnan(values)], -limit, limit)
    counts, edges = np.histogram(inside, bins, (-limit, limit))
    heights = np.log1p(counts) / max(np.log1p(counts.max()), 1e-9)
    middles = (edges[1:] + edges[:-1]) / 2
    return [
        Bar(float(middle), int(count), float(height))
        for middle, count, height in zip(middles, counts, heights, strict=True)
    ]
