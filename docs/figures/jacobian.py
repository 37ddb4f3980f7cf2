"""Figure 7: the Jacobian of Equation 11 multiplied, left out, and divided."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import sized_world
from restir_gi.figures.regions import floor_points, zones
from restir_gi.reference.images.image import luminance
from restir_gi.reference.methods.restir_gi import UNBIASED
from restir_gi.reference.numerics.arrays import Masks, Vec3s
from restir_gi.reference.numerics.intervals import Numbers
from restir_gi.reference.reports.figures.canvas import (
    COLORS,
    INK,
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
from restir_gi.reference.reports.figures.record import Deviation, PaperFigure, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.reports.figures.tiles import mean_and_error
from restir_gi.reference.scene.catalogue.answers import sunlit_wall_indirect
from restir_gi.reference.settings import JacobianUse, Mis

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import SubFigure

NAME = "jacobian"
SCENE = "sunlit-wall"
HALF = 1.0  # m, half the width of the wall
EDGES = (0.0, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # m from the wall
USES: tuple[JacobianUse, ...] = ("left-out", "multiplied", "divided")
PATHS, BALANCED = "path tracing", "multiplied, balance"
TICKS, CLOSER = (0.5, 1.0, 2.0, 4.0, 8.0), (0.8, 1.2)  # of the vertical axes

Zones = dict[tuple[float, float], Masks]
Profile = dict[tuple[float, float], Deviation]


def jacobian(work: Work) -> PaperFigure:
    """Light of the floor before a sunlit wall, by what becomes of the Jacobian.

    [Ouyang21, Fig. 7].  Divided is what line 11 of their Algorithm 4 prints.

    A row a zone of the floor: deviations of its mean from the closed form.
    """
    contenders = [_contender(use, use, "1/Z") for use in USES]
    contenders.append(_contender(BALANCED, "multiplied", "balance"))
    contest = compete(sized_world(SCENE, work.size), contenders, 1, work, paths=2)
    position, normal, floor = floor_points(contest.world, work)
    before = floor & (np.abs(position[:, 0]) < HALF)
    places = zones(position[:, 2], before, EDGES)
    answer = sunlit_wall_indirect(position, normal)
    found = {
        name: _deviations(colors, answer, places)
        for name, colors in _colors(contest).items()
    }
    picture = blank(4 * SIDE, 2 * SIDE + 0.9)
    above, below = split(picture, 2, 1, [SIDE + 0.3, SIDE + 0.6])
    draw_tiles(above, [_tiles(contest, answer, work)])
    _charts(below, found)
    return PaperFigure(
        NAME,
        "Figure 7: the Jacobian left out, multiplied, divided; bias of the floor",
        picture,
        tuple(
            {
                "before the wall": f"{low:g} to {high:g} m",
                **{name: cells[low, high] for name, cells in found.items()},
            }
            for low, high in places
        ),
        (
            f"{SCENE}, one bounce, {work.size} x {work.size}: mean of {FRAMES} frames"
            f" of {work.runs} runs, unbiased form, less the closed form, as a share of"
            f" it; {contest.truth.count} path-traced samples a pixel. Bars: two"
            " standard errors.",
            "Close to the wall the weights 1/Z have a heavy tail: most runs are a"
            " little too dark there, a few far too bright, and a standard error of some"
            " runs says less than it seems to. The balance heuristic has no such tail.",
            "The paper shows pictures alone, and says that without the Jacobian the"
            " floor is too bright at the base of the wall and has edges in its light.",
        ),
    )


def _contender(name: str, use: JacobianUse, mis: Mis) -> Contender:
    settings = replace(UNBIASED.settings, jacobian=use, mis=mis, image="mean")
    return Contender(name, replace(UNBIASED, settings=settings), 1)


def _colors(contest: Contest) -> dict[str, list[Vec3s]]:
    paths = [batch.mean for batch in contest.batches]
    return {PATHS: paths} | {name: runs.colors for name, runs in contest.runs.items()}


def _deviations(colors: list[Vec3s], answer: Vec3s, places: Zones) -> Profile:
    """Mean luminance of each zone over that of the closed form, less 1."""
    found = {}
    for ends, mask in places.items():
        true = luminance(answer[mask]).mean()
        shares: Numbers = np.array([luminance(c[mask]).mean() / true for c in colors])
        mean, error = mean_and_error(shares)
        found[ends] = Deviation(mean - 1, error)
    return found


def _tiles(contest: Contest, answer: Vec3s, work: Work) -> list[Tile]:
    exposure = exposure_of(answer, work.size)
    captions = {
        "left-out": "as if it were 1",
        "multiplied": "Equation 11",
        "divided": "as Algorithm 4 prints it",
    }
    tiles = [
        Tile(
            shown(np.mean(contest.runs[use].colors, axis=0), work.size, exposure),
            f"Jacobian {use.replace('-', ' ')}",
            captions[use],
        )
        for use in USES
    ]
    words = f"{contest.truth.count} samples"
    truth = shown(contest.truth.mean, work.size, exposure)
    return [*tiles, Tile(truth, "path traced", words)]


def _charts(area: "SubFigure", found: dict[str, Profile]) -> None:
    """All of them on a logarithmic axis, and what it squeezes on a linear one."""
    whole, closer = area.subplots(1, 2)
    for color, (name, cells) in zip(COLORS, found.items(), strict=False):
        middles = [(low + high) / 2 for low, high in cells]
        values = [1 + cell.value for cell in cells.values()]
        errors = [2 * cell.error for cell in cells.values()]
        for axes in (whole, closer):
            axes.errorbar(
                middles,
                values,
                errors,
                fmt="o-",
                markersize=3,
                linewidth=1.2,
                capsize=2,
                color=color,
                label=name.replace("-", " "),
            )
    for axes in (whole, closer):
        axes.axhline(1, color=QUIET, linewidth=0.8)
        tidy(axes, "light over the closed form", "distance from the wall, m", "")
    whole.set_yscale("log")
    whole.set_yticks(TICKS, [f"{tick:g}" for tick in TICKS], minor=False)
    whole.set_yticks([], minor=True)
    whole.legend(fontsize=8, frameon=False)
    closer.set(ylim=CLOSER)
    closer.set_title("the same, closer", fontsize=9, color=INK)


FIGURE = FigureEntry(NAME, jacobian, 16)
