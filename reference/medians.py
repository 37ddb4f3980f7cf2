"""Medians, with intervals that hold whatever the law."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import quantile_test


def median_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Median of independent numbers, and its 95 % interval by the sign test.

    Median and ends.  Of fewer than 6 no two hold the median at 95 %: then the ends are
    those of all.

    Parameters
    ----------
    values : sequence of float; at least one
    """
    found = quantile_test(values, p=0.5).confidence_interval(0.95)
    ends = zip(found, (min(values), max(values)), strict=True)
    low, high = (float(end if np.isfinite(end) else last) for end, last in ends)
    return float(np.median(values)), low, high
