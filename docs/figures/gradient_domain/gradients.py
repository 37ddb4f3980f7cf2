"""Figure 7: differences by each method, and their error in the same time."""

from typing import TYPE_CHECKING

from restir_gi.figures.gradient_domain.rounds import (
    FRAMES,
    Rounds,
    RoundScene,
    by_rounds,
)
from restir_gi.figures.gradient_domain.scores import (
    gradient_errors,
    gradient_flips,
    gradient_picture,
    relative_gradient_errors,
)
from restir_gi.figures.gradient_domain.variants import (
    AFTER,
    ALONE,
    BY_ITSELF,
    METHODS,
    scene_of,
)
from restir_gi.gradient_domain.reconstruction import Differences
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.intervals import (
    Interval,
    mean_interval,
    ratio_interval,
)
from restir_gi.reference.reports.figures.canvas import BIG, Tile, blank, draw_tiles
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "gradients"
SCENES = ("cornell-box", "checker", "glossy-floor", "door-ajar", "moving-camera")
TRUTH = 64  # path-traced samples a run
VARIANTS = {**METHODS, ALONE: BY_ITSELF}


def gradients(work: Work) -> PaperFigure:
    """Error of differences by path tracing, after ReSTIR, and with it.

    A row a scene and method.
    """
    return of_scenes([scene_of(name, work.size) for name in SCENES], work)


def of_scenes(scenes: list[RoundScene], work: Work) -> PaperFigure:
    """The same of any scenes; a row a scene and method."""
    rows: list[Row] = []
    grid: list[list[Tile]] = []
    for scene in scenes:
        rounds = by_rounds(scene, VARIANTS, work, TRUTH, like="")
        rows += [_row(rounds, name) for name in VARIANTS]
        grid.append(_tiles(rounds, first=not grid))
    return PaperFigure(
        NAME,
        "Figure 7: differences to the right neighbour, one frame of each method",
        _picture(grid, [scene.name for scene in scenes]),
        tuple(rows),
        (
            f"Frame {FRAMES} of {work.runs} runs at {work.size} x {work.size}, the"
            " primal pass included in its time. MSE is that of differences to the"
            " right and down, the spread of the runs, relMSE relative to the light of"
            " their two pixels. 'times smaller' than after ReSTIR in one frame, and 'in"
            " the same time'. FLIP is that of the pictures shown."
            " Intervals: 95 %, bootstrap over runs.",
        ),
    )


def times_smaller(rounds: Rounds, name: str, than: str, same_time: bool) -> Interval:
    """How many times smaller the error of differences is.

    Parameters
    ----------
    rounds : Rounds; one copy of each

    Returns
    -------
    Interval; errors of means of frames fall as time grows: times MSE times seconds
    """
    theirs, mine = (gradient_errors(rounds.estimates[n]) for n in (than, name))
    ratio = rounds.seconds[than] / rounds.seconds[name] if same_time else 1.0
    return ratio_interval(theirs, mine, ratio)


def _row(rounds: Rounds, name: str) -> Row:
    found = rounds.estimates[name]
    width = rounds.scene.world.camera.width
    return {
        "scene": rounds.scene.name,
        "method": name,
        "ms": 1000 * rounds.seconds[name],
        "MSE": mean_interval(gradient_errors(found)),
        "relMSE": mean_interval(relative_gradient_errors(found, rounds.truth, width)),
        "times smaller": times_smaller(rounds, name, AFTER, same_time=False),
        "in the same time": times_smaller(rounds, name, AFTER, same_time=True),
        "FLIP": mean_interval(gradient_flips(found, rounds.truth, width)),
    }


def difference_tile(
    rounds: Rounds, estimates: Scalars, title: str, caption: str
) -> Tile:
    """Picture of differences to the right, grey for no difference.

    Parameters
    ----------
    rounds : Rounds; with the truth that tells what is black and white
    estimates : (N, 9) float64; pixels, and differences to the right and down
    """
    d = Differences(estimates[:, 3:6], estimates[:, 6:9])
    width = rounds.scene.world.camera.width
    return Tile(gradient_picture(d, rounds.truth, width), title, caption)


def _tiles(rounds: Rounds, first: bool) -> list[Tile]:
    found = []
    for name in VARIANTS:
        times = times_smaller(rounds, name, AFTER, same_time=True)
        words = f"{times.value:.2f} [{times.low:.2f}, {times.high:.2f}] times smaller"
        title = name if first else ""
        found.append(difference_tile(rounds, rounds.estimates[name][0], title, words))
    return found


def _picture(grid: list[list[Tile]], names: list[str]) -> "Figure":
    picture = blank(len(grid[0]) * BIG, len(grid) * (BIG + 0.3))
    draw_tiles(picture, grid, names)
    return picture


FIGURE = FigureEntry(NAME, gradients, 8, 3)
