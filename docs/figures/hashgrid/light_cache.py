"""Light reservoirs in a grid, and next-event estimation in the same time."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.hashgrid.turns import COUNTED, WARM, Turns, by_turns
from restir_gi.figures.paths import sized_world
from restir_gi.hashgrid.light_method import METHOD
from restir_gi.hashgrid.light_settings import LightSettings
from restir_gi.hashgrid.world_reservoirs import render_light_frames
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.intervals import (
    Interval,
    mean_interval,
    ratio_interval,
)
from restir_gi.reference.numerics.schedule import Schedule
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
from restir_gi.reference.transport.world import World

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NAME = "light-cache"
PLANS = (
    ("night-market", 1),
    ("night-market", 2),
    ("night-market", 3),
    ("many-lights", 1),
)
PLAIN, UNBIASED, WIDE, BIASED = "next event", "balance", "2 cells, cap 100", "1/M"
VARIANTS = {
    PLAIN: replace(METHOD.settings, candidates=1, cells=0),
    "8 candidates": replace(METHOD.settings, cells=0),
    UNBIASED: METHOD.settings,
    WIDE: replace(METHOD.settings, cells=2, cap=100.0),
    BIASED: replace(METHOD.settings, mis="1/M"),
}


def light_cache(work: Work) -> PaperFigure:
    """Error of light reservoirs, and of next-event estimation in the same time.

    A row a scene, number of bounces and variant.
    """
    rows: list[Row] = []
    grid: list[list[Tile]] = []
    for scene, bounces in PLANS:
        world = sized_world(scene, work.size)
        variants = {
            name: partial(_colors, world, settings, bounces, work.schedule)
            for name, settings in VARIANTS.items()
        }
        turns = by_turns(world, bounces, variants, work)
        rows += [_row(turns, scene, bounces, name) for name in VARIANTS]
        grid.append(_tiles(turns, work, first=not grid))
    names = [f"{scene}, bounces: {bounces}" for scene, bounces in PLANS]
    return PaperFigure(
        NAME,
        "Light reservoirs at every path vertex, and next-event estimation",
        _picture(grid, names),
        tuple(rows),
        (
            f"{COUNTED} frames after the first {WARM}, of {work.runs} runs at"
            f" {work.size} x {work.size}. MSE is the spread of frames of one number"
            " over the runs. 'times smaller' is that of next-event estimation with one"
            " light a vertex, drawn by power and not weighted against BSDF sampling, in"
            " the same time; 'than paths' that of the path tracer, which is. Intervals:"
            " 95 %, bootstrap over runs; tails are heavy, and intervals of few runs"
            " too narrow.",
            "Pictures: next-event estimation has as many frames as fit into the time"
            " of one with reservoirs.",
        ),
    )


def _colors(
    world: World, settings: LightSettings, bounces: int, schedule: Schedule, seed: int
) -> Iterator[Vec3s]:
    made = render_light_frames(world, settings, bounces, seed, schedule)
    return (frame.color for frame in made)


def _times(turns: Turns, name: str) -> Interval:
    factor = turns.seconds[PLAIN] / turns.seconds[name]
    return ratio_interval(turns.errors(PLAIN), turns.errors(name), factor)


def _row(turns: Turns, scene: str, bounces: int, name: str) -> Row:
    mine, factor = turns.errors(name), turns.path_seconds / turns.seconds[name]
    return {
        "scene": scene,
        "bounces": bounces,
        "variant": name,
        "ms a frame": 1000 * turns.seconds[name],
        "MSE": mean_interval(mine),
        "times smaller": _times(turns, name),
        "than paths": ratio_interval(turns.path_errors(), mine, factor),
        "bias of the mean": Deviation(*turns.bias(name)),
    }


def _tiles(turns: Turns, work: Work, first: bool) -> list[Tile]:
    truth, (run, *_) = turns.truth, turns.colors[PLAIN]
    exposure = exposure_of(truth.mean, work.size)
    count = max(1, round(turns.seconds[UNBIASED] / turns.seconds[PLAIN]))
    plain = np.mean(run[:count], axis=0)
    times = _times(turns, UNBIASED)
    frame = f"MSE {times.value:.1f} times smaller [{times.low:.1f}, {times.high:.1f}]"
    pictures = [
        ("next event, equal time", plain, f"{min(count, len(run))} samples"),
        ("reservoirs, unbiased", turns.colors[UNBIASED][0][-1], frame),
        ("reservoirs, 1/M", turns.colors[BIASED][0][-1], "biased"),
        ("truth", truth.mean, f"{truth.count} path-traced samples"),
    ]
    return [
        Tile(shown(rows, work.size, exposure), title if first else "", caption)
        for title, rows, caption in pictures
    ]


def _picture(grid: list[list[Tile]], names: list[str]) -> "Figure":
    picture = blank(len(grid[0]) * BIG, len(grid) * (BIG + 0.3))
    draw_tiles(picture, grid, names)
    return picture


FIGURE = FigureEntry(NAME, light_cache, 16)
