"""Figure 11: the sun turns at once, and stored samples are validated, or not."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.contest import PATH_SEED
from restir_gi.figures.paths import sized_world
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.moments import Moments, add_samples, no_samples
from restir_gi.reference.reports.demo.score import relative_bias
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
from restir_gi.reference.reports.figures.record import Deviation, PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry
from restir_gi.reference.reports.figures.tiles import (
    TILE,
    rms_without_noise,
    tile_luminance,
)
from restir_gi.reference.restir_gi import Frame, render_frames
from restir_gi.reference.scene.catalogue.animations import CHANGE
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import BIASED, UNBIASED, Settings
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.transport.world import World, build_world

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import SubFigure

NAME = "validation"
SCENE = "sunlight-turns"
LAST = 48
SHOWN = 12  # frames after the change, as in the paper
TOLD = (-1, 0, 2, 5, SHOWN, 31)  # frames after it that have a row
SAMPLES = 512  # a pixel, of the truth
EVERY = BIASED.validate_every
VARIANTS: dict[str, Settings] = {
    "without validation": replace(BIASED, validate_every=0),
    f"with, every {EVERY} frames": BIASED,
    "unbiased form": UNBIASED,
}
VARIANT_COLORS = (COLORS[1], COLORS[2], COLORS[0])


@dataclass(frozen=True, slots=True, eq=False)
class _Film:
    """What is wrong with each frame, and one frame's mean over the runs."""

    means: list[Deviation]
    tiles: list[float]
    picture: Vec3s


def validation(work: Work) -> PaperFigure:
    """Error of the picture's mean from frame to frame around a sudden change of light.

    [Ouyang21, Fig. 11].

    A row a frame and variant: deviations from the truth of that frame.
    """
    before = sized_world(SCENE, work.size)
    animation = find_animation(SCENE, before.scene)
    after = build_world(validate(animation(CHANGE)))
    truths = [_truth(world, work) for world in (before, after)]
    films = {}
    for done, (name, settings) in enumerate(VARIANTS.items()):
        work.tick(done, len(VARIANTS), "variants")
        runs = [
            render_frames(before, settings, 1, seed, work.schedule, animation)
            for seed in range(work.runs)
        ]
        films[name] = _film(runs, truths, work.size)
    picture = blank(5 * SIDE, 2 * SIDE + 0.9)
    above, below = split(picture, 2, 1, [SIDE + 0.4, SIDE + 0.4])
    draw_tiles(above, [_tiles(films, truths, work)])
    _charts(below, films)
    return PaperFigure(
        NAME,
        "Figure 11: sample validation after a sudden change of sunlight",
        picture,
        tuple(
            _row(name, film, CHANGE + later)
            for later in TOLD
            for name, film in films.items()
        ),
        (
            f"{SCENE}, one bounce, {work.size} x {work.size}: mean luminance over that"
            f" of the truth of the same frame, less 1, of {work.runs} runs. Tiles: of"
            f" {TILE} x {TILE} pixels; root mean square of their deviations, as a share"
            f" of the picture's mean, without the noise. The light changes in frame"
            f" {CHANGE}; the truth has {SAMPLES} path-traced samples a pixel.",
            "The paper shows pictures alone: without validation there is bias on a"
            f" wall still {SHOWN} frames later; with it the picture adapts rapidly, and"
            " stays too bright for a while.",
        ),
    )


def _truth(world: World, work: Work) -> Moments:
    drawn = path_samples(
        world, work.schedule, light="indirect", bounces=1, seed=PATH_SEED
    )
    none = no_samples(drawn.rows)
    return add_samples(none, drawn.radiance, SAMPLES, work.schedule)


def _film(runs: list[Iterator[Frame]], truths: list[Moments], size: int) -> _Film:
    means, tiles, picture = [], [], truths[1].mean
    for frame in range(LAST):
        colors = [next(run).color for run in runs]
        truth = truths[int(frame >= CHANGE)]
        means.append(Deviation(*relative_bias(colors, truth)))
        tiles.append(_of_tiles(colors, truth, size))
        if frame == CHANGE + SHOWN:
            picture = np.mean(colors, axis=0)
    return _Film(means, tiles, picture)


def _of_tiles(colors: list[Vec3s], truth: Moments, size: int) -> float:
    """Root mean square deviation of the tiles, as a share of the mean."""
    true = tile_luminance(truth.mean, size)
    found = np.array([tile_luminance(color, size) for color in colors])
    deviations = (found - true).reshape(len(colors), -1) / true.mean()
    return rms_without_noise(deviations)


def _row(name: str, film: _Film, frame: int) -> Row:
    return {
        "frames after the change": frame - CHANGE,
        "variant": name,
        "mean less truth": film.means[frame],
        "rms of tiles": film.tiles[frame],
    }


def _tiles(films: dict[str, _Film], truths: list[Moments], work: Work) -> list[Tile]:
    exposure = exposure_of(truths[1].mean, work.size)
    later = f"{SHOWN} frames later"
    return [
        Tile(shown(truths[0].mean, work.size, exposure), "truth before"),
        *(
            Tile(shown(film.picture, work.size, exposure), name, later)
            for name, film in films.items()
        ),
        Tile(shown(truths[1].mean, work.size, exposure), "truth after"),
    ]


def _charts(area: "SubFigure", films: dict[str, _Film]) -> None:
    """Of the whole picture, and of where the light lies in it."""
    whole, parts = area.subplots(1, 2)
    frames = np.arange(LAST) - CHANGE
    for color, (name, film) in zip(VARIANT_COLORS, films.items(), strict=True):
        value = np.array([cell.value for cell in film.means])
        reach = 2 * np.array([cell.error for cell in film.means])
        whole.plot(frames, value, color=color, linewidth=1.4)
        whole.fill_between(
            frames, value - reach, value + reach, color=color, alpha=0.15, linewidth=0
        )
        parts.plot(frames, film.tiles, color=color, linewidth=1.4, label=name)
    titles = {
        whole: "whole picture over the truth, less 1; two standard errors",
        parts: f"rms deviation of {TILE} x {TILE} pixels, share of the mean",
    }
    for axes, title in titles.items():
        axes.axhline(0, color=QUIET, linewidth=0.8)
        axes.axvline(-0.5, color=QUIET, linewidth=0.8, linestyle=":")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        tidy(axes, title, "frames after the change of light", "")
    parts.legend(fontsize=8, frameon=False)


FIGURE = FigureEntry(NAME, validation, 8)
