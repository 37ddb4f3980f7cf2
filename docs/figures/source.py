"""Figure 14: uniform against cosine-weighted initial directions under grazing light."""

from dataclasses import replace
from typing import TYPE_CHECKING

from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import sized_world
from restir_gi.figures.regions import floor_points, zones
from restir_gi.reference.methods.restir_gi import UNBIASED
from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.numerics.intervals import (
    Interval,
    mean_interval,
    ratio_interval,
)
from restir_gi.reference.reports.figures.canvas import (
    COLORS,
    QUIET,
    SIDE,
    Tile,
    blank,
    draw_tiles,
    exposure_of,
    shown,
    split,
    tidy,
)
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.resampling.source import Source

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "source"
SCENE = "grazing-light"
WALL = -1.0  # m, x of the lit wall
EDGES = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)  # m from it
COSINE, UNIFORM = "cosine-weighted", "uniform"
DENSITIES: dict[str, Source] = {COSINE: "cosine", UNIFORM: "uniform"}
ALONE = ", no reuse"


def source(work: Work) -> PaperFigure:
    """Error by the density of initial directions, with reuse and without.

    [Ouyang21, Fig. 14].  The further from the wall, the closer is its light to the
    horizon of the floor, where cosine-weighted directions are rare.

    A row a zone of the floor, and one for the whole picture.
    """
    contenders = [
        _contender(name + suffix, density, reuse)
        for suffix, reuse in ((ALONE, False), ("", True))
        for name, density in DENSITIES.items()
    ]
    contest = compete(sized_world(SCENE, work.size), contenders, 1, work, paths=4)
    position, _, floor = floor_points(contest.world, work)
    places = zones(position[:, 0] - WALL, floor, EDGES)
    ratios = {ends: _ratio(contest, "", mask) for ends, mask in places.items()}
    alone = {ends: _ratio(contest, ALONE, mask) for ends, mask in places.items()}
    return PaperFigure(
        NAME,
        "Figure 14: density of initial directions, light at grazing angles",
        _picture(contest, {"with reuse": ratios, "without": alone}, work),
        (
            _row(contest, "whole picture", None),
            *(
                _row(contest, f"floor, {low:g} to {high:g} m", mask)
                for (low, high), mask in places.items()
            ),
        ),
        (
            f"{SCENE}, one bounce, {work.size} x {work.size}: frame {FRAMES} of"
            f" {work.runs} runs, unbiased form, against {contest.truth.count}"
            " path-traced samples a pixel. Intervals: 95 %, bootstrap over runs.",
            "The paper shows pictures alone: noisy with cosine-weighted directions,"
            " and much better with uniform ones.",
        ),
    )


def _contender(name: str, density: Source, reuse: bool) -> Contender:
    settings = replace(UNBIASED.settings, source=density, temporal=reuse, spatial=reuse)
    return Contender(name, replace(UNBIASED, settings=settings), 1)


def _ratio(contest: Contest, suffix: str, pixels: Masks | None) -> Interval:
    cosine = contest.errors(COSINE + suffix, pixels)
    return ratio_interval(cosine, contest.errors(UNIFORM + suffix, pixels))


def _row(contest: Contest, where: str, pixels: Masks | None) -> Row:
    return {
        "where": where,
        f"MSE, {COSINE}": mean_interval(contest.errors(COSINE, pixels)),
        f"MSE, {UNIFORM}": mean_interval(contest.errors(UNIFORM, pixels)),
        "their ratio": _ratio(contest, "", pixels),
        "ratio without reuse": _ratio(contest, ALONE, pixels),
    }


def _picture(
    contest: Contest,
    lines: dict[str, dict[tuple[float, float], Interval]],
    work: Work,
) -> "Figure":
    truth = contest.truth
    exposure = exposure_of(truth.mean, work.size)
    tiles = [
        Tile(
            shown(contest.runs[name].colors[0], work.size, exposure),
            f"{name}, frame {FRAMES}",
            f"MSE {contest.errors(name).mean():.2g}",
        )
        for name in (COSINE, UNIFORM)
    ]
    words = f"{truth.count} samples"
    tiles.append(Tile(shown(truth.mean, work.size, exposure), "truth", words))
    picture = blank((len(tiles) + 1.5) * SIDE, SIDE + 0.5)
    left, right = split(picture, 1, 2, [len(tiles), 1.5])
    draw_tiles(left, [tiles])
    _chart(right.subplots(), lines)
    return picture


def _chart(axes: "Axes", lines: dict[str, dict[tuple[float, float], Interval]]) -> None:
    for color, (name, ratios) in zip(COLORS, lines.items(), strict=False):
        middles = [(low + high) / 2 for low, high in ratios]
        cells = ratios.values()
        axes.plot(
            middles, [c.value for c in cells], "o-", color=color, label=name, ms=4
        )
        axes.fill_between(
            middles,
            [c.low for c in cells],
            [c.high for c in cells],
            color=color,
            alpha=0.15,
            linewidth=0,
        )
    axes.axhline(1, color=QUIET, linewidth=0.8)
    tidy(axes, "MSE, cosine over uniform", "distance from the lit wall, m", "")
    axes.legend(fontsize=8, frameon=False)


FIGURE = FigureEntry(NAME, source, 32)
