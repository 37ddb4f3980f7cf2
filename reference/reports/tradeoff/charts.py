"""Figures of a sweep: error against cost, what of it is bias, what is dominated."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.intervals import Interval
from restir_gi.reference.reports.figures.canvas import COLORS, INK, QUIET, blank, tidy
from restir_gi.reference.reports.tradeoff.front import on_front
from restir_gi.reference.reports.tradeoff.scores import DesignScore

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = 8
"""At most, in a chart of curves."""
MOST_FRAMES = 4096
DOMINATED = "#c3c7cb"


def curves(scores: Sequence[DesignScore], light: float) -> "Figure":
    """MSE against time, and against rays, of means of ever more runs.

    Parameters
    ----------
    scores : sequence of DesignScore; at most `LINES`
    light : float; mean of the truth

    Returns
    -------
    Figure
        bias² + variance / n at n times the cost: a straight line, until it meets the
        bias, which is dashed where it is certain.  Bands are the sums of the ends of
        both intervals.
    """
    picture = blank(11, 4.2)
    costs = (
        ("ms on one thread", [s.ms.value for s in scores]),
        ("rays a pixel", [s.all_rays for s in scores]),
    )
    for axes, (label, cost) in zip(picture.subplots(1, 2), costs, strict=True):
        for index, (score, each) in enumerate(zip(scores, cost, strict=True)):
            _curve(axes, score, each, light, index)
        axes.set(xscale="log", yscale="log")
        tidy(axes, "", label, "MSE, of the squared mean light")
    axes.legend(fontsize=7, frameon=False, loc="upper right")
    return picture


def _curve(
    axes: "Axes", score: DesignScore, cost: float, light: float, index: int
) -> None:
    n = np.geomspace(1, MOST_FRAMES, 60)
    error, scale = score.error, light**2 or 1.0
    color = COLORS[index % len(COLORS)]
    style = "-" if index < len(COLORS) else ":"

    def at(bias2: float, variance: float) -> Scalars:
        return np.maximum(max(bias2, 0.0) + variance / n, 1e-300) / scale

    middle = at(score.bias**2, error.variance.value)
    label = score.point.label
    axes.plot(n * cost, middle, style, color=color, label=label, linewidth=1.4)
    low = at(error.bias2.low, error.variance.low)
    high = at(error.bias2.high, error.variance.high)
    axes.fill_between(n * cost, low, high, color=color, alpha=0.12, linewidth=0)
    if score.bias > 0:
        floor = score.bias**2 / scale
        axes.axhline(floor, linestyle="--", color=color, linewidth=0.8)


def bars(groups: Sequence[tuple[str, Sequence[DesignScore]]], light: float) -> "Figure":
    """Squared bias and variance, stacked, a panel a knob.

    The line over each bar is the interval of their sum, the MSE.

    Parameters
    ----------
    groups : sequence of (str, sequence of DesignScore)
        A knob, and its levels; at least one.
    light : float; mean of the truth
    """
    columns = min(3, len(groups))
    rows = -(-len(groups) // columns)
    picture = blank(3.9 * columns, 2.7 * rows)
    panels = picture.subplots(rows, columns, squeeze=False).ravel()
    scale = light**2 or 1.0
    for axes, (name, scores) in zip(panels, groups, strict=False):
        place = np.arange(len(scores))
        bias2 = [max(s.error.bias2.value, 0.0) / scale for s in scores]
        variance = [s.error.variance.value / scale for s in scores]
        axes.bar(place, variance, color=COLORS[0], width=0.6, label="variance")
        axes.bar(
            place, bias2, bottom=variance, color=COLORS[1], width=0.6, label="bias²"
        )
        _whiskers(axes, place, [s.error.mse for s in scores], scale)
        tidy(axes, name, "", "MSE / mean²")
        slanted = {"rotation": 35, "ha": "right"}
        axes.set_xticks(place, [s.point.label for s in scores], fontsize=7, **slanted)
        axes.grid(False, axis="x")
    panels[0].legend(fontsize=7, frameon=False)
    for axes in panels[len(groups) :]:
        axes.set_visible(False)
    return picture


def front(scores: Sequence[DesignScore], light: float) -> "Figure":
    """All points by time, standard deviation and certain bias; dominated ones grey.

    Names stand at the points that nothing dominates, where there is something to be
    seen of them.

    Parameters
    ----------
    light : float; mean of the truth
    """
    picture = blank(11, 5)
    scale = light or 1.0
    best = on_front(scores)
    deviation = [np.sqrt(max(s.error.variance.value, 0.0)) / scale for s in scores]
    shares = [100 * s.bias / scale for s in scores]
    heights = (("standard deviation / mean", deviation), ("certain bias, %", shares))
    for axes, (label, values) in zip(picture.subplots(1, 2), heights, strict=True):
        for score, good, value in zip(scores, best, values, strict=True):
            color = COLORS[0] if good else DOMINATED
            axes.plot(score.ms.value, value, "o", color=color, markersize=5)
            if good and value > 0:
                axes.annotate(
                    score.point.name,
                    (score.ms.value, value),
                    fontsize=6,
                    color=INK,
                    xytext=(4, 3),
                    textcoords="offset points",
                )
        tidy(axes, "", "ms a frame on one thread", label)
        axes.set_xscale("log")
        axes.margins(x=0.15)
    return picture


def neighbours(groups: Sequence[tuple[str, Sequence[DesignScore]]]) -> "Figure":
    """How far, and for how long, pixels err alike.

    A row a knob: correlation length, and lag.

    Parameters
    ----------
    groups : sequence of (str, sequence of DesignScore)
        A knob, and its levels; at least one.
    """
    picture = blank(7.5, 2.5 * len(groups))
    panels = picture.subplots(len(groups), 2, squeeze=False)
    for (left, right), (name, scores) in zip(panels, groups, strict=True):
        place = np.arange(len(scores))
        parts = (
            (left, "correlation length, pixels", [s.length for s in scores]),
            (right, "lag, frames", [s.lag for s in scores]),
        )
        for axes, label, values in parts:
            axes.plot(place, [v.value for v in values], "o-", color=COLORS[0])
            _whiskers(axes, place, values, 1.0)
            axes.set_ylim(bottom=0)
            tidy(axes, name, "", label)
            axes.set_xticks(place, [s.point.label for s in scores], fontsize=7)
    return picture


def _whiskers(
    axes: "Axes", place: Scalars, values: Sequence[Interval], scale: float
) -> None:
    low, high = ([getattr(v, end) / scale for v in values] for end in ("low", "high"))
    axes.vlines(place, low, high, color=QUIET, linewidth=1.2)
