"""Figures 6, 9 and 10: reuse of pairs around, and reservoirs of both signs."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.gradient_domain.gradients import difference_tile, times_smaller
from restir_gi.figures.gradient_domain.rounds import FRAMES, Rounds, Variant, by_rounds
from restir_gi.figures.gradient_domain.scores import gradient_errors
from restir_gi.figures.gradient_domain.variants import scene_of, with_restir
from restir_gi.gradient_domain.gradient_restir import unlike
from restir_gi.gradient_domain.pairs import pixel_pairs
from restir_gi.gradient_domain.settings import GradientSettings
from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.numerics.intervals import mean_interval
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.reports.figures.canvas import BIG, Tile, blank, draw_tiles
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.transport.world import World

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

TRUTH = 16  # path-traced samples a run, that tell what is black and white
SCENES = ("checker", "cornell-box", "glossy-floor", "moving-camera")

AROUND = {
    "edges": with_restir(GradientSettings()),
    "random": with_restir(GradientSettings(around="random")),
    "nobody": with_restir(GradientSettings(around="none")),
    "edges, no past": with_restir(GradientSettings(temporal=False)),
    "random, no past": with_restir(GradientSettings(temporal=False, around="random")),
    "nobody, no past": with_restir(GradientSettings(temporal=False, around="none")),
}

SIGNS = {
    "within the sign": with_restir(GradientSettings()),
    "across signs": with_restir(GradientSettings(signs="across")),
    "one reservoir": with_restir(GradientSettings(signs="without")),
}


def reuse(work: Work, scenes: Sequence[str] | None = None) -> PaperFigure:
    """Error of differences, with pairs around that are edges, any, or none.

    A row a scene and variant.

    Parameters
    ----------
    scenes : sequence of str, optional
        Names of the catalogue, those of `SCENES` if none are given.
    """
    return _ablation(
        "gradient-reuse",
        "Figures 6 and 10: whose samples pairs take over, and what it is good for",
        AROUND,
        "nobody",
        work,
        scenes,
    )


def signs(work: Work, scenes: Sequence[str] | None = None) -> PaperFigure:
    """Error of differences, with a reservoir for each sign, or for both.

    A row a scene and variant.

    Parameters
    ----------
    scenes : sequence of str, optional
        Names of the catalogue, those of `SCENES` if none are given.
    """
    return _ablation(
        "gradient-signs",
        "Figure 9: positivization, within the sign, across signs, and without",
        SIGNS,
        "one reservoir",
        work,
        scenes,
    )


def _ablation(
    name: str,
    title: str,
    variants: Mapping[str, Variant],
    than: str,
    work: Work,
    scenes: Sequence[str] | None,
) -> PaperFigure:
    names = tuple(scenes or SCENES)
    rows: list[Row] = []
    grid: list[list[Tile]] = []
    for scene_name in names:
        scene = scene_of(scene_name, work.size)
        rounds = by_rounds(scene, variants, work, TRUTH, like="")
        across = _across(scene.shown)
        rows += [_row(rounds, variant, than, across) for variant in variants]
        grid.append(
            [
                difference_tile(
                    rounds, rounds.estimates[v][0], v if not grid else "", ""
                )
                for v in variants
            ]
        )
    return PaperFigure(
        name,
        title,
        _picture(grid, names),
        tuple(rows),
        (
            f"Frame {FRAMES} of {work.runs} runs at {work.size} x {work.size}: MSE of"
            " differences to the right and down, of edge pairs and of the others, the"
            f" spread of the runs. 'times smaller' than '{than}' in one frame, and 'in"
            " the same time'. Intervals: 95 %, bootstrap over runs.",
        ),
    )


def _across(world: World) -> Masks:
    """Which differences to the right and down are those of edges, (N, 2)."""
    camera = world.camera
    visible = visible_points(world, *pixel_centers(camera.width, camera.height))
    pairs = pixel_pairs(camera.width, camera.height)
    found = np.zeros((camera.width * camera.height, 2), bool)
    found[pairs.first, pairs.axis] = unlike(visible, pairs.first, pairs.second)
    return found


def _row(rounds: Rounds, name: str, than: str, across: Masks) -> Row:
    found = rounds.estimates[name]
    return {
        "scene": rounds.scene.name,
        "variant": name,
        "ms": 1000 * rounds.seconds[name],
        "MSE, edges": mean_interval(gradient_errors(found, across)),
        "MSE, others": mean_interval(gradient_errors(found, ~across)),
        "times smaller": times_smaller(rounds, name, than, same_time=False),
        "in the same time": times_smaller(rounds, name, than, same_time=True),
    }


def _picture(grid: list[list[Tile]], names: Sequence[str]) -> "Figure":
    picture = blank(len(grid[0]) * BIG * 0.8, len(grid) * (BIG * 0.8 + 0.2))
    draw_tiles(picture, grid, names)
    return picture


REUSE = FigureEntry("gradient-reuse", reuse, 8, 3)
SIGN = FigureEntry("gradient-signs", signs, 8, 3)
