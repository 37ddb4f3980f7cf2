"""Figure 9: what spatial reuse without the right weights makes of thin shadows."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import sized_world
from restir_gi.reference.methods.restir_gi import UNBIASED
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.intervals import Numbers
from restir_gi.reference.reports.comparison.maps import SIGNED, ErrorMap
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
from restir_gi.reference.reports.figures.tiles import (
    TILE,
    largest_of_half,
    mean_and_error,
    tile_luminance,
)
from restir_gi.reference.settings import Mis

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "bias"
SCENE = "glossy-floor"
UNBIASED_FORM, BIASED_FORM = "unbiased", "biased"
FACTOR = 10.0  # of the difference, as in the paper
BLOCKS = 32  # a side, over which the difference is averaged to be seen


def bias(work: Work) -> PaperFigure:
    """Unbiased and biased spatial reuse, and ten times their difference.

    [Ouyang21, Fig. 9].  The two forms differ in the weights of spatial reuse alone, 1/Z
    with visibility and 1/M.  The target has the glossy lobe in it, as in the paper's
    text, which is Equation 9.  Light of sample points that are not Lambertian is path
    traced in both, so that nothing else is biased.

    The numbers are deviations of the two forms from path tracing, and of one from the
    other.

    Parameters
    ----------
    work : Work; size, schedule, and at least four runs
    """
    contenders = [_contender(UNBIASED_FORM, "1/Z"), _contender(BIASED_FORM, "1/M")]
    contest = compete(sized_world(SCENE, work.size), contenders, 1, work, paths=2)
    return PaperFigure(
        NAME,
        "Figure 9: bias of spatial reuse around thin legs on a glossy floor",
        _picture(contest, work),
        tuple(_rows(contest, work.size)),
        (
            f"{SCENE}, one bounce, {work.size} x {work.size}: mean of {FRAMES} frames"
            f" of {work.runs} runs; truth of {contest.truth.count} path-traced samples"
            " a pixel. Run i of both forms has the same initial samples, so that their"
            " difference has less noise than either.",
            f"The tile, of {TILE} x {TILE} pixels, is the one with the largest"
            " difference; all shares are of the mean luminance of the picture. It was"
            " chosen by half of the runs and measured by the others, since the largest"
            " of many noisy numbers is too large.",
            "The paper shows pictures alone: bias in the shadows of the chair legs,"
            " worse on the glossy floor.",
        ),
    )


def _contender(name: str, mis: Mis) -> Contender:
    settings = replace(UNBIASED.settings, mis=mis, image="mean")
    return Contender(name, replace(UNBIASED, settings=settings), 1)


def _rows(contest: Contest, size: int) -> list[Row]:
    mean = float(np.mean(_tiles(contest.truth.mean, size)))
    tiles = {
        name: np.array([_tiles(color, size) for color in runs.colors]) / mean
        for name, runs in contest.runs.items()
    }
    difference = tiles[BIASED_FORM] - tiles[UNBIASED_FORM]
    index, *largest = largest_of_half(difference)
    y, x = TILE * np.array(np.unravel_index(index, (size // TILE, size // TILE)))
    found = {
        f"{name} less truth, whole picture": relative_bias(runs.colors, contest.truth)
        for name, runs in contest.runs.items()
    }
    found["biased less unbiased, whole picture"] = mean_and_error(
        difference.mean(axis=1)
    )
    found[f"biased less unbiased, tile at {x}, {y}"] = largest[0], largest[1]
    return [
        {"difference": name, "share of the truth": Deviation(*cell)}
        for name, cell in found.items()
    ]


def _tiles(color: Vec3s, size: int) -> Numbers:
    return tile_luminance(color, size).ravel()


def _picture(contest: Contest, work: Work) -> "Figure":
    size = work.size
    means = {name: np.mean(runs.colors, axis=0) for name, runs in contest.runs.items()}
    exposure = exposure_of(contest.truth.mean, size)
    block = max(1, size // BLOCKS)
    difference = tile_luminance(means[BIASED_FORM] - means[UNBIASED_FORM], size, block)
    limit = 1 / (exposure * FACTOR)
    signed = ErrorMap("", "", "", difference, -limit, limit, SIGNED)
    pictures = [
        Tile(shown(means[UNBIASED_FORM], size, exposure), "unbiased, weights 1/Z"),
        Tile(shown(means[BIASED_FORM], size, exposure), "biased, weights 1/M"),
        Tile(
            signed.pixels(),
            f"{FACTOR:g} x difference",
            f"blue: too dark; means of {block} x {block} pixels",
        ),
    ]
    picture = blank(len(pictures) * BIG, BIG + 0.45)
    draw_tiles(picture, [pictures])
    return picture


FIGURE = FigureEntry(NAME, bias, 16, 4)
