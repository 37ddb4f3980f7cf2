"""Figures 8 and 12: images from pixels and differences, in the time of one frame."""

from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.gradient_domain.rounds import (
    FRAMES,
    Rounds,
    RoundScene,
    by_rounds,
)
from restir_gi.figures.gradient_domain.scores import image_errors, image_flips
from restir_gi.figures.gradient_domain.variants import (
    AFTER,
    ALONE,
    AREA,
    BY_ITSELF,
    METHODS,
    PATHS,
    PRIMAL,
    WITH,
    scene_of,
)
from restir_gi.gradient_domain.method import RECONSTRUCT
from restir_gi.gradient_domain.reconstruction import Differences
from restir_gi.gradient_domain.settings import Reconstruction
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.intervals import (
    Numbers,
    mean_interval,
    ratio_interval,
)
from restir_gi.reference.reports.figures.canvas import (
    BIG,
    Tile,
    blank,
    draw_tiles,
    exposure_of,
    shown,
)
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "gradient-images"
SCENES = ("cornell-box", "glossy-floor", "moving-camera")
TRUTH = 1024  # path-traced samples a run: FLIP sees the noise of the truth, too
VARIANTS = {
    **METHODS,
    ALONE: BY_ITSELF,
    AREA: PRIMAL,
}
NORMS: tuple[Reconstruction, ...] = ("l1", "l2")

COMBINED = {
    PATHS: (PATHS, PATHS),
    AFTER: (AFTER, AFTER),
    WITH: (WITH, WITH),
    ALONE: (ALONE, ALONE),
    "pixels ReSTIR, differences PT": (WITH, PATHS),
    "pixels PT, differences ReSTIR": (PATHS, WITH),
}
"""Whose pixels, and whose differences."""

PAPER = (
    "Veach Ajar of the article, MSE by L1, L2, and FLIP: PT and Gradient-PT 0.113,"
    " 0.042; 0.932, 0.284. Area and Gradient-PT 0.081, 0.008; 0.923, 0.249. PT and"
    " theirs 0.029, 0.035; 0.175, 0.167. Area and theirs 0.003, 0.003; 0.168, 0.098."
)


def images(work: Work) -> PaperFigure:
    """Error of images of each method, of its pixels alone, and of mixtures.

    A row a scene, method and norm.
    """
    return of_scenes([scene_of(name, work.size) for name in SCENES], work)


def of_scenes(scenes: list[RoundScene], work: Work) -> PaperFigure:
    """The same of any scenes; a row a scene, method and norm."""
    rows: list[Row] = []
    grid: list[list[Tile]] = []
    for scene in scenes:
        rounds = by_rounds(scene, VARIANTS, work, TRUTH, like=ALONE)
        made = _images(rounds)
        rows += _rows(rounds, made)
        grid.append(_tiles(rounds, made, work, first=not grid))
    return PaperFigure(
        NAME,
        "Figures 8 and 12: images in the time of one frame of Gradient with ReSTIR",
        _picture(grid, [scene.name for scene in scenes]),
        tuple(rows),
        (
            f"Frame {FRAMES} of {work.runs} runs at {work.size} x {work.size}; as many"
            " copies of each method as take about the time of one of Gradient with"
            " ReSTIR with nobody around, at least one, averaged before the image is"
            " made; mixtures take pixels of the"
            " one and differences of the other. Errors are against path tracing over"
            f" the areas of pixels, {TRUTH * work.runs} samples a pixel. 'MSE, Area"
            " over it' and FLIP: how many times smaller than that of as many copies of"
            " Area ReSTIR, without differences. Intervals: 95 %, bootstrap over runs."
            " The time of reconstruction is not counted.",
            PAPER,
        ),
    )


Made = dict[tuple[str, str], list[Vec3s]]


def _images(rounds: Rounds) -> Made:
    width = rounds.scene.world.camera.width
    found: Made = {(AREA, "none"): [e[:, :3] for e in rounds.estimates[AREA]]}
    for name, (pixels, differences) in COMBINED.items():
        both = list(
            zip(rounds.estimates[pixels], rounds.estimates[differences], strict=True)
        )
        for kind in NORMS:
            found[name, kind] = [_image(kind, p, d, width) for p, d in both]
    return found


def _image(kind: Reconstruction, pixels: Scalars, of: Scalars, width: int) -> Vec3s:
    d = Differences(of[:, 3:6], of[:, 6:9])
    return RECONSTRUCT[kind](pixels[:, :3], d, width)


def _rows(rounds: Rounds, made: Made) -> list[Row]:
    width = rounds.scene.world.camera.width

    def scored(key: tuple[str, str]) -> tuple[Numbers, Numbers, Numbers]:
        flips = image_flips(made[key], rounds.truth, width)
        return *image_errors(made[key], rounds.truth), flips

    area = scored((AREA, "none"))
    rows: list[Row] = []
    for name, norm in made:
        mse, relative, flip = scored((name, norm))
        some = dict.fromkeys(COMBINED.get(name, (name,)))
        rows.append(
            {
                "scene": rounds.scene.name,
                "method": name,
                "norm": norm,
                "copies": " + ".join(str(rounds.copies[n]) for n in some),
                "ms": 1000 * max(rounds.spent(n) for n in some),
                "MSE": mean_interval(mse),
                "relMSE": mean_interval(relative),
                "FLIP": mean_interval(flip),
                "MSE, Area over it": ratio_interval(area[0], mse),
                "FLIP, Area over it": ratio_interval(area[2], flip),
            }
        )
    return rows


def _tiles(rounds: Rounds, made: Made, work: Work, first: bool) -> list[Tile]:
    exposure = exposure_of(rounds.truth.mean, work.size)
    width = rounds.scene.world.camera.width

    def tile(rows: Vec3s, title: str, words: str) -> Tile:
        pixels = shown(np.maximum(rows, 0.0), work.size, exposure)
        return Tile(pixels, title if first else "", words)

    keys = [
        (AREA, "none"),
        *((name, kind) for name in (*METHODS, ALONE) for kind in NORMS),
    ]
    found = []
    for name, norm in keys:
        flip = image_flips(made[name, norm][:1], rounds.truth, width)[0]
        title = name if norm == "none" else f"{name}, {norm.upper()}"
        found.append(tile(made[name, norm][0], title, f"FLIP {flip:.3f}"))
    words = f"{rounds.truth.count} path-traced samples"
    return [*found, tile(rounds.truth.mean, "truth", words)]


def _picture(grid: list[list[Tile]], names: list[str]) -> "Figure":
    picture = blank(len(grid[0]) * BIG * 0.8, len(grid) * (BIG * 0.8 + 0.3))
    draw_tiles(picture, grid, names)
    return picture


FIGURE = FigureEntry(NAME, images, 6, 3)
