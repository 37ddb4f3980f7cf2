"""Figures 1 and 13: mean squared error against path tracing's in equal time."""

from dataclasses import replace
from typing import TYPE_CHECKING

from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import path_traced, sized_world
from restir_gi.reference.methods.restir_gi import BIASED, UNBIASED
from restir_gi.reference.numerics.intervals import Interval, ratio_interval
from restir_gi.reference.reports.demo.score import relative_bias
from restir_gi.reference.reports.figures.canvas import (
    COLORS,
    SIDE,
    Tile,
    blank,
    draw_tiles,
    exposure_of,
    shown,
    split,
    tidy,
)
from restir_gi.reference.reports.figures.record import Deviation, PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes

NAME = "equal-time"
SCENES = (
    "door-ajar",
    "grazing-light",
    "sunlight-turns",
    "cornell-box",
    "many-lights",
    "glossy-floor",
)
BOUNCES = 2
PAIRWISE = replace(UNBIASED, settings=replace(UNBIASED.settings, mis="defensive"))
CONTENDERS = (
    Contender("biased", BIASED, BOUNCES),
    Contender("unbiased", UNBIASED, BOUNCES),
    Contender("pairwise", PAIRWISE, BOUNCES),
)
"""The paper's two forms, and the unbiased one with defensive pairwise weights."""

PAPER = {"biased": (14.6, 141.0), "unbiased": (9.3, 166.0)}  # section 6


def equal_time(work: Work, scenes: tuple[str, ...] = SCENES) -> PaperFigure:
    """Error of one frame of ReSTIR GI, and of path tracing that takes the same time.

    [Ouyang21, Fig. 1 and 13].  Camera rays are in neither time.

    A row a scene and variant; the number that counts is "times smaller".
    """
    rows: list[Row] = []
    grid: list[list[Tile]] = []
    for name in scenes:
        contest = compete(sized_world(name, work.size), CONTENDERS, BOUNCES, work)
        ratios = {c.name: ratio(contest, c.name) for c in CONTENDERS}
        rows += [_row(contest, name, c.name, ratios[c.name]) for c in CONTENDERS]
        grid.append(_tiles(contest, ratios, work, first=not grid))
    picture = blank((len(CONTENDERS) + 2) * SIDE, len(scenes) * (SIDE + 0.2) + 2.6)
    above, below = split(picture, 2, 1, [len(scenes), 1.1])
    draw_tiles(above, grid, scenes)
    _chart(below.subplots(), rows, scenes)
    return PaperFigure(
        NAME,
        "Figures 1 and 13: mean squared error in equal time, two bounces",
        picture,
        tuple(rows),
        (
            f"Frame {FRAMES} of {work.runs} runs at {work.size} x {work.size}, against"
            f" {contest.truth.count} path-traced samples a pixel, whose own noise is"
            " taken off. Path tracing has as many samples, also fractions of one, as"
            " fit into the time of a frame at the end of a run; times are medians, and"
            " frames and samples take turns. Intervals: 95 %, bootstrap over runs.",
            *(_beside_the_paper(rows, name) for name in PAPER),
        ),
    )


def ratio(contest: Contest, name: str) -> Interval:
    """How many times smaller the error is than path tracing's in the same time.

    (Variance of one path-traced sample · its seconds) over (MSE · seconds).

    Parameters
    ----------
    contest : Contest; with path tracing of as many bounces
    """
    factor = contest.path_seconds / contest.runs[name].seconds
    return ratio_interval(contest.path_variances(), contest.errors(name), factor)


def _row(contest: Contest, scene: str, name: str, times: Interval) -> Row:
    runs = contest.runs[name]
    samples = runs.seconds / contest.path_seconds
    return {
        "scene": scene,
        "variant": name,
        "ms a frame": 1000 * runs.seconds,
        "paths in that time": samples,
        "MSE of paths": float(contest.path_variances().mean() / samples),
        "MSE": float(contest.errors(name).mean()),
        "times smaller": times,
        "bias of the mean": Deviation(*relative_bias(runs.colors, contest.truth)),
    }


def _tiles(
    contest: Contest, ratios: dict[str, Interval], work: Work, first: bool
) -> list[Tile]:
    truth = contest.truth
    exposure = exposure_of(truth.mean, work.size)
    samples = contest.runs["unbiased"].seconds / contest.path_seconds
    whole = max(1, round(samples))
    paths = path_traced(contest.world, "indirect", BOUNCES, whole, work)
    pictures = [
        ("path traced, equal time", paths, f"{whole} samples"),
        *(
            (f"ReSTIR GI, {name}", contest.runs[name].colors[0], _times(ratios[name]))
            for name in ratios
        ),
        ("truth", truth.mean, f"{truth.count} samples"),
    ]
    return [
        Tile(shown(rows, work.size, exposure), title if first else "", caption)
        for title, rows, caption in pictures
    ]


def _times(interval: Interval) -> str:
    return (
        f"MSE {interval.value:.1f} times smaller"
        f" [{interval.low:.1f}, {interval.high:.1f}]"
    )


def _chart(axes: "Axes", rows: list[Row], scenes: tuple[str, ...]) -> None:
    """Ratios scene by scene, and at the right the ranges that the paper states."""
    for index, name in enumerate(c.name for c in CONTENDERS):
        color, shift = COLORS[index], 0.16 * (index - 1)
        cells = _ratios(rows, name)
        values = [cell.value for cell in cells]
        ends = [
            [cell.value - cell.low for cell in cells],
            [cell.high - cell.value for cell in cells],
        ]
        places = [place + shift for place in range(len(scenes))]
        axes.errorbar(places, values, ends, fmt="o", color=color, capsize=3, label=name)
        if name in PAPER:
            last = len(scenes) + shift
            axes.vlines(last, *PAPER[name], colors=color, linewidth=5, alpha=0.4)
    axes.set_yscale("log")
    axes.set_xticks(range(len(scenes) + 1), [*scenes, "the paper's\nscenes"])
    axes.set_xlim(-0.6, len(scenes) + 0.6)
    tidy(axes, "", "", "times smaller MSE in equal time")
    axes.legend(fontsize=8, frameon=False, loc="lower left")


def _ratios(rows: list[Row], name: str) -> list[Interval]:
    cells = [row["times smaller"] for row in rows if row["variant"] == name]
    return [cell for cell in cells if isinstance(cell, Interval)]


def _beside_the_paper(rows: list[Row], name: str) -> str:
    values = [cell.value for cell in _ratios(rows, name)]
    low, high = PAPER[name]
    return (
        f"The {name} form: {min(values):.1f} to {max(values):.1f} times smaller; in"
        f" the paper, on other scenes and on a GPU, {low:g} to {high:g}."
    )


FIGURE = FigureEntry(NAME, equal_time, 32)
