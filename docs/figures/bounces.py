"""Figure 8: direct light, one and two bounces, and what each of them costs."""

from dataclasses import replace
from typing import TYPE_CHECKING

from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.paths import path_traced, sized_world
from restir_gi.reference.methods.restir_gi import UNBIASED
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

NAME = "bounces"
SCENE = "cornell-box"
ROULETTE = 0.25  # share of the tiles that follow the second bounce, section 5
DIRECT_SAMPLES = 64
ONE, TWO, SOME = "one bounce", "two bounces", "two in 25 % of the tiles"
VARIANTS = {ONE: (1, 1.0), TWO: (2, 1.0), SOME: (2, ROULETTE)}
INITIAL = ", initial samples"


def bounces(work: Work) -> PaperFigure:
    """Pictures with more and more light, and the time of each part of a frame.

    [Ouyang21, Fig. 8].

    A row a variant: the time of initial samples is that of a frame without reuse, that
    of reuse is what a whole frame takes beyond it.
    """
    contenders = [
        _contender(name + suffix, *variant, reuse=reuse)
        for name, variant in VARIANTS.items()
        for suffix, reuse in (("", True), (INITIAL, False))
    ]
    contest = compete(sized_world(SCENE, work.size), contenders, 2, work)
    first = contest.runs[ONE + INITIAL].seconds
    return PaperFigure(
        NAME,
        "Figure 8: one and two bounces, and their cost",
        _picture(contest, work),
        tuple(_row(contest, name, first) for name in VARIANTS),
        (
            f"{SCENE}, {work.size} x {work.size}, unbiased form: medians of the last"
            f" frames of {work.runs} runs of {FRAMES} frames. Two-bounce path tracing"
            f" takes {1000 * contest.path_seconds:.1f} ms a sample; its mean of"
            f" {contest.truth.count} samples a pixel is the truth.",
            "In the paper, on a GPU: initial samples 3.2 ms with one bounce and 4.2 ms"
            " (+32 %) with two in 25 % of the tiles, reuse 4.6 ms with either,"
            " two-bounce path tracing 6.9 ms.",
        ),
    )


def _contender(name: str, depth: int, share: float, reuse: bool) -> Contender:
    settings = replace(UNBIASED.settings, roulette=share, temporal=reuse, spatial=reuse)
    return Contender(name, replace(UNBIASED, settings=settings), depth)


def _row(contest: Contest, name: str, first: float) -> Row:
    frame, initial = contest.runs[name], contest.runs[name + INITIAL].seconds
    return {
        "variant": name,
        "ms, initial samples": 1000 * initial,
        "to one bounce": initial / first,
        "ms, reuse": 1000 * (frame.seconds - initial),
        "mean light less the truth's": Deviation(
            *relative_bias(frame.colors, contest.truth)
        ),
    }


def _picture(contest: Contest, work: Work) -> "Figure":
    direct = path_traced(contest.world, "direct", 0, DIRECT_SAMPLES, work)
    light = {name: contest.runs[name].colors[0] for name in (ONE, TWO)}
    full = exposure_of(direct + contest.truth.mean, work.size)
    alone = exposure_of(contest.truth.mean, work.size)
    samples = max(1, round(contest.runs[TWO].seconds / contest.path_seconds))
    paths = path_traced(contest.world, "indirect", 2, samples, work)
    rows = (
        (
            full,
            ("direct light", direct),
            ("with one bounce", direct + light[ONE]),
            ("with two bounces", direct + light[TWO]),
        ),
        (
            alone,
            (f"two bounces, path traced, {samples} samples", paths),
            ("one bounce, ReSTIR GI", light[ONE]),
            ("two bounces, ReSTIR GI", light[TWO]),
        ),
    )
    grid = [
        [Tile(shown(rows, work.size, exposure), name) for name, rows in pictures]
        for exposure, *pictures in rows
    ]
    picture = blank(3 * BIG, 2 * BIG + 0.6)
    draw_tiles(picture, grid, ("all light", "indirect light alone"))
    return picture


FIGURE = FigureEntry(NAME, bounces, 8)
