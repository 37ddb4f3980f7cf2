"""Shifts on a polished floor: replay until a path can be joined, or join at once."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.extensions.method import METHOD
from restir_gi.extensions.pt_settings import CRITERIA
from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import sized_world
from restir_gi.figures.regions import floor_points
from restir_gi.reference.numerics.arrays import Masks
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

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "specular-floor"
SCENE = "specular-floor"
BOUNCES = 2
PATHS = 4  # path-traced samples beside each frame
PURE = "reconnection"


def specular_floor(work: Work) -> PaperFigure:
    """Error of ReSTIR PT by each of its shifts, of as many samples.

    A row a shift and region; the number that counts is "times smaller" than that of
    pure reconnection.
    """
    contenders = [
        Contender(
            kind,
            replace(METHOD, settings=replace(METHOD.settings, shift=kind)),
            BOUNCES,
        )
        for kind in CRITERIA
    ]
    world = sized_world(SCENE, work.size)
    contest = compete(world, contenders, BOUNCES, work, PATHS)
    _, _, floor = floor_points(world, work)
    return PaperFigure(
        NAME,
        "Shifts of whole paths on a polished floor, two bounces of indirect light",
        _picture(contest, work),
        tuple(
            _row(contest, kind, where, pixels)
            for where, pixels in (("whole picture", None), ("floor", floor))
            for kind in CRITERIA
        ),
        (
            f"{SCENE}: frame {FRAMES} of {work.runs} runs at {work.size} x {work.size},"
            " one new tree of paths a pixel and frame for each shift, the same for all;"
            f" truth of {contest.truth.count} path-traced samples a pixel, whose own"
            " noise is taken off. Intervals: 95 %, bootstrap over runs.",
            f"{np.mean(floor):.0%} of the pixels see the floor. What it mirrors cannot"
            " be joined at the next point: pure reconnection takes over nothing there.",
            "Replay alone loses paths on the diffuse walls, where joined ones stay.",
        ),
    )


def _times(contest: Contest, kind: str, pixels: Masks | None) -> Interval:
    return ratio_interval(contest.errors(PURE, pixels), contest.errors(kind, pixels))


def _row(contest: Contest, kind: str, where: str, pixels: Masks | None) -> Row:
    runs = contest.runs[kind]
    return {
        "where": where,
        "shift": kind,
        "MSE": mean_interval(contest.errors(kind, pixels)),
        "times smaller": _times(contest, kind, pixels),
        "ms a frame": 1000 * runs.seconds,
        "bias, whole picture": Deviation(*relative_bias(runs.colors, contest.truth)),
    }


def _picture(contest: Contest, work: Work) -> "Figure":
    exposure = exposure_of(contest.truth.mean, work.size)
    tiles = []
    for kind in CRITERIA:
        times = _times(contest, kind, None)
        tiles.append(
            Tile(
                shown(contest.runs[kind].colors[0], work.size, exposure),
                f"{kind}, frame {FRAMES}",
                f"MSE {times.value:.1f} times smaller"
                f" [{times.low:.1f}, {times.high:.1f}]",
            )
        )
    words = f"{contest.truth.count} samples"
    tiles.append(Tile(shown(contest.truth.mean, work.size, exposure), "truth", words))
    picture = blank(len(tiles) * BIG, BIG + 0.45)
    draw_tiles(picture, [tiles])
    return picture


FIGURE = FigureEntry(NAME, specular_floor, 16)
