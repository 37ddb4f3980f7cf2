"""Cells of the grid: how large, how full, and whose samples pixels reuse."""

from typing import TYPE_CHECKING

import numpy as np

from restir_gi.figures.paths import sized_world
from restir_gi.hashgrid.grid import BUCKET, Grid, edges, jittered, keys_of, levels
from restir_gi.hashgrid.light_method import METHOD
from restir_gi.hashgrid.report import occupancy
from restir_gi.hashgrid.world_reservoirs import LightFrame, render_light_frames
from restir_gi.reference.images.display import Bytes
from restir_gi.reference.images.image import to_image
from restir_gi.reference.numerics.arrays import Indices, Masks, Vec3s
from restir_gi.reference.numerics.rng import (
    KeyedUniforms,
    Stream,
    pcg4d,
    to_unit_interval,
)
from restir_gi.reference.reports.figures.canvas import (
    BIG,
    COLORS,
    Tile,
    blank,
    draw_tiles,
    split,
    tidy,
)
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "cells"
SCENES = ("many-lights", "night-market", "cornell-box")
BOUNCES = 2
FRAMES = 6
"""Until the cells are filled."""


def cells(work: Work) -> PaperFigure:
    """Cells that visible points lie in, and whose samples their paths take over.

    A row a scene, with the counts of its grid.

    Parameters
    ----------
    work : Work; size, seed of the last run, and schedule
    """
    found = {name: _last(name, work) for name in SCENES}
    return PaperFigure(
        NAME,
        "Cells of the grid: sizes, borders, and whose samples pixels reuse",
        _picture(found, work),
        tuple(_row(name, frame) for name, frame in found.items()),
        (
            f"Frame {FRAMES} of world-reservoirs at {work.size} x {work.size},"
            f" {BOUNCES} bounces: the grid holds the second and later points of all"
            " paths. A cell is some 16 pixels wide, rounded down to a power of two of"
            " a millimetre.",
            "The last picture has the colour of the cell whose vertex held the light"
            " sample at the path's second point; black where the vertex kept what it"
            " drew itself, or nothing.",
            f"Buckets have {BUCKET} slots; 'probes' is how many of them a look-up"
            " reads in the mean, 'shared' how many cells a grid would mix up that"
            " compares checksums alone.",
        ),
    )


def _last(name: str, work: Work) -> LightFrame:
    world = sized_world(name, work.size)
    made = render_light_frames(
        world, METHOD.settings, BOUNCES, work.runs, work.schedule
    )
    *_, last = (next(made) for _ in range(FRAMES))
    return last


def _row(name: str, frame: LightFrame) -> Row:
    counts = occupancy(frame.cache.grid)
    return {
        "scene": name,
        "vertices": counts.vertices,
        "lost": counts.lost,
        "cells": counts.cells,
        "vertices a cell": counts.vertices / max(counts.cells, 1),
        "most": counts.longest,
        "probes": counts.probes,
        "shared": counts.shared,
    }


def _picture(found: dict[str, LightFrame], work: Work) -> "Figure":
    picture = blank(4 * BIG, len(found) * (BIG + 0.3) + 2.6)
    above, below = split(picture, 2, 1, [len(found) * 1.3, 1.0])
    rows = [_tiles(frame, work, n == 0) for n, frame in enumerate(found.values())]
    draw_tiles(above, rows, tuple(found))
    left, right = below.subplots(1, 2)
    for color, (name, frame) in zip(COLORS, found.items(), strict=False):
        _histograms(left, right, name, color, frame.cache.grid)
    tidy(left, "", "vertices of a cell", "cells")
    tidy(right, "", "cells of a bucket", "buckets")
    right.locator_params(axis="x", integer=True)
    left.set_xscale("log", base=2)
    for axes in (left, right):
        axes.set_yscale("log")
        axes.legend(fontsize=8, frameon=False)
    return picture


def _tiles(frame: LightFrame, work: Work, first: bool) -> list[Tile]:
    lattice, visible = frame.cache.lattice, frame.visible
    level = levels(lattice, visible.surface.position)
    seen = visible.surface.hit
    pixel = np.arange(len(seen), dtype=np.uint32)
    u = KeyedUniforms(pixel, 1, 0, Stream.CELLS).draw(0)
    x, n = visible.surface.position, visible.surface.normal
    own = keys_of(lattice, x, n).hashes
    moved = keys_of(lattice, jittered(lattice, x, n, u), n).hashes
    source = _source(frame)
    least, most = edges(np.array([level[seen].min(), level[seen].max()]))
    pictures = [
        ("level of detail", _levels(level, seen), f"edges {least:.3g} to {most:.3g} m"),
        ("cells", _by_name(own, seen), "each in a colour of its own"),
        ("cells that are looked up", _by_name(moved, seen), "jitter of up to √2 cells"),
        (
            "whose light sample is shown",
            _by_name(source, source > 0),
            f"{np.mean(source[seen] > 0):.0%} taken over",
        ),
    ]
    return [
        Tile(_image(rows, work.size), title if first else "", caption)
        for title, rows, caption in pictures
    ]


def _source(frame: LightFrame) -> Indices:
    """Cells that the samples at x_2 were taken over from, by pixel; 0 for none."""
    at = np.flatnonzero(frame.vertex == 2)
    kept = frame.cache.reservoirs
    source = np.zeros(len(frame.color), np.int64)
    source[frame.pixel[at]] = np.where(kept.W[at] > 0, kept.y.cell[at], 0)
    return source


def _levels(level: Indices, seen: Masks) -> Vec3s:
    from matplotlib import colormaps

    low, high = level[seen].min(), level[seen].max()
    shade = (level - low) / max(high - low, 1)
    colors: Vec3s = colormaps["viridis"](np.clip(shade, 0, 1))[:, :3]
    return np.where(seen[:, None], colors, 0.0)


def _by_name(name: Indices, there: Masks) -> Vec3s:
    """A colour that hangs on a number alone."""
    key = np.asarray(name).astype(np.uint32)
    zero = np.zeros_like(key)
    r, g, b, _ = (to_unit_interval(word) for word in pcg4d(key, zero, zero, zero))
    colors: Vec3s = 0.15 + 0.8 * np.stack([r, g, b], axis=1)
    return np.where(there[:, None], colors, 0.0)


def _image(rows: Vec3s, size: int) -> Bytes:
    pixels: Bytes = np.rint(255 * to_image(rows, size, size)).astype(np.uint8)
    return pixels


def _histograms(left: "Axes", right: "Axes", name: str, color: str, grid: Grid) -> None:
    counts = grid.counters
    bins = 2.0 ** np.arange(np.ceil(np.log2(counts.max() + 1)) + 1)
    sizes, _ = np.histogram(counts, bins)
    left.step(bins[:-1], np.maximum(sizes, 0), where="post", color=color, label=name)
    buckets = occupancy(grid).buckets
    full = np.flatnonzero(buckets)
    right.plot(full, np.array(buckets)[full], "o-", color=color, label=name)


FIGURE = FigureEntry(NAME, cells, 2)
