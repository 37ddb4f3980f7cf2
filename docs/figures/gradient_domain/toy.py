"""Figure 3: the difference of two functions, by samples of either, or of the pair."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.extensions.area_shift import PlacedValue
from restir_gi.gradient_domain.after_restir import one_sided
from restir_gi.gradient_domain.gradient_restir import (
    MINUS,
    PLUS,
    WHOLE,
    PairValue,
    contribution,
    target,
)
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.intervals import (
    Numbers,
    mean_interval,
    ratio_interval,
)
from restir_gi.reference.reports.figures.canvas import COLORS, SIDE, blank, tidy
from restir_gi.reference.reports.figures.record import Deviation, PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    finalize,
    initial_candidates,
    merge,
)
from restir_gi.reference.resampling.target import luminance

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "gradient-toy"
REPEATS = 500  # as in the article, a run
CANDIDATES = 16  # of each function, a repeat
EDGE = 2.0
DENSITY = 1.0 / (2.0 * EDGE)


def functions(x: Scalars) -> tuple[Scalars, Scalars]:
    """Two functions that agree at the origin, where they are large, and not beside it.

    Parameters
    ----------
    x : (N,) float64; in [-2, 2]

    Returns
    -------
    (N,), (N,) float64; f_1 and f_2
    """

    def bump(middle: float, width: float) -> Scalars:
        found: Scalars = np.exp(-0.5 * ((x - middle) / width) ** 2)
        return found

    common = 4.0 * bump(0.0, 0.3)
    return common + 0.6 * bump(1.2, 0.15), common + 0.4 * bump(-1.2, 0.15)


def _value(x: Scalars, k: int, sign: int) -> PairValue:
    """As base and offset path: the shift from one function to the other is x to x."""
    f, g = functions(x) if k == 0 else functions(x)[::-1]
    none, grey = np.zeros(len(x)), np.ones((1, 3))
    placed = PlacedValue(x, none, f[:, None] * grey, none + 1.0)
    ks, signs = (np.full(len(x), n, np.int8) for n in (k, sign))
    return PairValue(ks, placed, g[:, None] * grey, none + 1.0, signs)


def after_restir(x: Scalars, u: Scalars) -> tuple[Scalars, Numbers]:
    """Resample each function by itself, and take differences of what is kept.

    Parameters
    ----------
    x : (2, M, N) float64; new samples of each function
    u : (2, M, N) float64; numbers in [0, 1) that decide

    Returns
    -------
    (2, N), (N,) float64; what is kept, and estimates of the difference of the integrals
    """
    kept, terms = [], []
    for k in (0, 1):
        found = [_new(some, k, WHOLE, _own) for some in x[k]]
        merged = _merged(found, u[k])
        r = finalize(merged, merged.M)
        kept.append(r.y.base.x)
        terms.append(one_sided(r.y)[:, 0] * r.W)
    return np.array(kept), np.sum(terms, axis=0)


def with_restir(
    x: Scalars, u: Scalars, signs: tuple[int, ...]
) -> tuple[Scalars, Numbers]:
    """Resample the pair by what a sample says of the difference.

    Parameters
    ----------
    x : (2, M, N) float64; new samples of each function
    u : (2, M, N) float64; numbers in [0, 1) that decide, of each reservoir the same

    Returns
    -------
    (S, N), (N,) float64; what is kept for each sign, and estimates of the difference
    """
    kept, terms = [], []
    for sign in signs:
        found = [_new(some, k, sign, target) for k in (0, 1) for some in x[k]]
        merged = _merged(found, np.concatenate(u))
        # Both k are parts of the domain: each is sampled M times, not 2 M.
        r = finalize(merged, merged.M / 2)
        kept.append(r.y.base.x)
        terms.append(contribution(r.y)[:, 0] * r.W)
    return np.array(kept), np.sum(terms, axis=0)


def _own(value: PairValue) -> Scalars:
    return luminance(value.base.value)


def _new(
    x: Scalars, k: int, sign: int, p_hat: Callable[[PairValue], Scalars]
) -> Candidates:
    value = _value(x, k, sign)
    return initial_candidates(value, p_hat(value), np.full(len(x), DENSITY))


def _merged(found: list[Candidates], u: Scalars) -> Candidates:
    kept = found[0]
    for candidate, numbers in zip(found[1:], u[1:], strict=True):
        kept = merge(kept, candidate, numbers)
    return kept


VARIANTS: dict[str, Callable[[Scalars, Scalars], tuple[Scalars, Numbers]]] = {
    "after ReSTIR": after_restir,
    "with ReSTIR, one reservoir": partial(with_restir, signs=(WHOLE,)),
    "with ReSTIR, one a sign": partial(with_restir, signs=(PLUS, MINUS)),
}


def toy(work: Work) -> PaperFigure:
    """Variance of the difference, and which samples are kept for it; a row a variant.

    Parameters
    ----------
    work : Work; runs, of 500 repeats each; a size does not matter
    """
    grid = np.linspace(-EDGE, EDGE, 4001)
    f = functions(grid)
    truth = float(np.trapezoid(f[0] - f[1], grid))
    errors: dict[str, list[float]] = {name: [] for name in VARIANTS}
    found: dict[str, list[Numbers]] = {name: [] for name in VARIANTS}
    kept: dict[str, Scalars] = {}
    for run in range(work.runs):
        work.tick(run, work.runs, "runs")
        rng = np.random.default_rng(run)
        shape = 2, CANDIDATES, REPEATS
        x, u = rng.uniform(-EDGE, EDGE, shape), rng.random(shape)
        for name, make in VARIANTS.items():
            kept[name], estimates = make(x, u)
            found[name].append(estimates)
            errors[name].append(float(np.mean((estimates - truth) ** 2)))
    work.tick(work.runs, work.runs, "runs")
    first, *_ = VARIANTS
    rows: list[Row] = [
        {
            "variant": name,
            "MSE": mean_interval(np.array(errors[name])),
            "times smaller": ratio_interval(
                np.array(errors[first]), np.array(errors[name])
            ),
            "mean less truth": _bias(found[name], truth),
        }
        for name in VARIANTS
    ]
    return PaperFigure(
        NAME,
        "Figure 3: the difference of two functions, by samples of either or of both",
        _picture(grid, kept),
        tuple(rows),
        (
            f"{work.runs} runs of {REPEATS} repeats; {CANDIDATES} new samples of each"
            f" function a repeat, drawn evenly. The integral is {truth:.4f}. 'mean less"
            " truth' is in parts of it, with its standard error. Intervals: 95 %,"
            " bootstrap over runs. The article prints no number.",
        ),
    )


def _bias(found: list[Numbers], truth: float) -> Deviation:
    every = np.concatenate(found)
    error = every.std(ddof=1) / np.sqrt(len(every))
    return Deviation(float(every.mean() / truth - 1), float(error / truth))


def _picture(grid: Scalars, kept: dict[str, Scalars]) -> "Figure":
    picture = blank(2 * SIDE * (1 + len(kept)) / 2, 1.6 * SIDE)
    first, *others = picture.subplots(1, 1 + len(kept))
    for f, color, name in zip(functions(grid), COLORS, ("f1", "f2"), strict=False):
        first.plot(grid, f, color=color, linewidth=1.2, label=name)
    first.legend(fontsize=7, frameon=False)
    tidy(first, "two functions", "x", "")
    bins = np.linspace(-EDGE, EDGE, 81)
    for axes, (name, x) in zip(others, kept.items(), strict=True):
        for part, color in zip(x, COLORS, strict=False):
            axes.hist(part, bins, color=color, alpha=0.6)
        tidy(axes, name, "x that was kept", "")
    return picture


FIGURE = FigureEntry(NAME, toy, 64)
