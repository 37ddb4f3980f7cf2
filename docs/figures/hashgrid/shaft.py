"""Light by few ways: ReSTIR GI, ReSTIR PT, and paths that look into cells."""

from dataclasses import replace
from typing import TYPE_CHECKING

import restir_gi.extensions.method
from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import sized_world
from restir_gi.hashgrid.regir_method import METHOD
from restir_gi.reference.methods.method import Method
from restir_gi.reference.methods.restir_gi import UNBIASED
from restir_gi.reference.numerics.intervals import (
    Interval,
    mean_interval,
    ratio_interval,
)
from restir_gi.reference.reports.demo.score import relative_bias
from restir_gi.reference.reports.figures.canvas import (
    BIG,
    Tile,
    blank,
    draw_tiles,
    exposure_of,
    shown,
)
from restir_gi.reference.reports.figures.record import Deviation, PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.reports.figures.spread import spreads

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "shaft"
SCENES = ("shaft", "specular-floor")
BOUNCES = 2
PATHS = 16  # path-traced samples beside each frame
SCREEN = "ReSTIR GI"
WHOLE_PATHS = restir_gi.extensions.method.METHOD
ARTICLE = replace(
    METHOD.settings, cell_mis="1/M", nulls="dropped", writers="every-bounce"
)
VARIANTS: dict[str, Method] = {
    SCREEN: UNBIASED,
    "ReSTIR PT": replace(
        WHOLE_PATHS, settings=replace(WHOLE_PATHS.settings, mis="1/Z")
    ),
    "ReGIR GI": METHOD,
    "ReGIR GI, the article's form": replace(METHOD, settings=ARTICLE),
}


def shaft(work: Work) -> PaperFigure:
    """Error of paths that look into cells, and of screen-space reuse in equal time."""
    rows: list[Row] = []
    grid: list[list[Tile]] = []
    contenders = [Contender(name, m, BOUNCES) for name, m in VARIANTS.items()]
    for scene in SCENES:
        world = sized_world(scene, work.size)
        contest = compete(world, contenders, BOUNCES, work, PATHS)
        rows += [_row(contest, scene, name) for name in VARIANTS]
        grid.append(_tiles(contest, work, first=not grid))
    return PaperFigure(
        NAME,
        "Light that comes by few ways, two bounces: reuse on the screen and in cells",
        _picture(grid),
        tuple(rows),
        (
            f"Frame {FRAMES} of {work.runs} runs at {work.size} x {work.size}. MSE is"
            " the spread of the runs, without the bias of the article's form. 'times"
            " smaller' is that of ReSTIR GI (1/Z) in the same time, 'in a frame' that"
            " of one frame. Intervals: 95 %, bootstrap over runs.",
            "The truth is path traced, and noisy where few paths find the light:"
            f" {contest.truth.count} samples a pixel.",
        ),
    )


def _times(contest: Contest, name: str, factor: float) -> Interval:
    theirs, mine = (spreads(contest.runs[n].colors) for n in (SCREEN, name))
    return ratio_interval(theirs, mine, factor)


def _equal_time(contest: Contest, name: str) -> float:
    return contest.runs[SCREEN].seconds / contest.runs[name].seconds


def _row(contest: Contest, scene: str, name: str) -> Row:
    runs = contest.runs[name]
    return {
        "scene": scene,
        "variant": name,
        "ms a frame": 1000 * runs.seconds,
        "MSE": mean_interval(spreads(runs.colors)),
        "in a frame": _times(contest, name, 1.0),
        "times smaller": _times(contest, name, _equal_time(contest, name)),
        "bias of the mean": Deviation(*relative_bias(runs.colors, contest.truth)),
    }


def _tiles(contest: Contest, work: Work, first: bool) -> list[Tile]:
    exposure = exposure_of(contest.truth.mean, work.size)
    tiles = []
    for name in VARIANTS:
        times = _times(contest, name, _equal_time(contest, name))
        tiles.append(
            Tile(
                shown(contest.runs[name].colors[0], work.size, exposure),
                name if first else "",
                f"{times.value:.1f} times smaller [{times.low:.1f}, {times.high:.1f}]",
            )
        )
    truth = shown(contest.truth.mean, work.size, exposure)
    words = f"{contest.truth.count} path-traced samples"
    return [*tiles, Tile(truth, "truth" if first else "", words)]


def _picture(grid: list[list[Tile]]) -> "Figure":
    picture = blank(len(grid[0]) * BIG, len(grid) * (BIG + 0.3))
    draw_tiles(picture, grid, SCENES)
    return picture


FIGURE = FigureEntry(NAME, shaft, 16)
