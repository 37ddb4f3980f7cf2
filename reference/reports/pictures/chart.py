"""How a mean comes closer to its truth, or does not, with ever more pictures."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from restir_gi.reference.reports.figures.canvas import COLORS, QUIET, blank, tidy

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

MARGIN = 1.15
"""Beside the first look and the last, as a factor."""

TICKS = 5
"""Of looks that are named, at most."""


def convergence(
    counts: Sequence[int],
    means: Sequence[Mapping[str, Any]],
    allowed: float | None,
) -> "Figure":
    """Mean minus truth against the number of pictures, in per cent of the truth.

    Parameters
    ----------
    counts : sequence of int; pictures at each look
    means : sequence of mapping; what was known of a mean of light at each look
    allowed : float or None; how far it may be off, relative; ``None`` for any
    """
    off, error = (
        100 * np.array([one[name] for one in means])
        for name in ("relative", "relative_error")
    )
    picture = blank(5.2, 3.3)
    axes = picture.subplots()
    if allowed is not None:
        axes.axhspan(-100 * allowed, 100 * allowed, color=COLORS[2], alpha=0.15)
    axes.axhline(0, color=QUIET, linewidth=0.8)
    axes.errorbar(
        counts, off, error, fmt="o-", color=COLORS[0], markersize=3, capsize=2
    )
    tidy(axes, "", "pictures", "mean − truth, % of the truth")
    axes.set(xscale="log", xlim=(counts[0] / MARGIN, counts[-1] * MARGIN))
    # Counted from the last look, which is the one that decided.
    named = counts[:: -ceil(len(counts) / TICKS)][::-1]
    axes.set_xticks(named, [f"{count:,}" for count in named])
    axes.set_xticks([], minor=True)
    return picture
