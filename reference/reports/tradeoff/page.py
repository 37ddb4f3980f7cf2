"""The folder of a sweep: figures, numbers, and one page that needs nothing else."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.reference.reports.figures.canvas import png_of
from restir_gi.reference.reports.page import render_page
from restir_gi.reference.reports.tradeoff.change import draw_recoveries
from restir_gi.reference.reports.tradeoff.charts import (
    LINES,
    bars,
    curves,
    front,
    neighbours,
)
from restir_gi.reference.reports.tradeoff.maps import deviations, draw_maps
from restir_gi.reference.reports.tradeoff.report import COLUMNS, as_csv, as_plain, cells
from restir_gi.reference.reports.tradeoff.results import Results
from restir_gi.reference.reports.tradeoff.scores import DesignScore
from restir_gi.reference.reports.tradeoff.store import Store
from restir_gi.reference.system.files import write_file
from restir_gi.reference.system.json_text import json_text
from restir_gi.reference.system.machine import machine

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

NEAR = ("radius", "temporal_cap", "spatial_cap")
"""Knobs on which it depends how far, and for how long, pixels err alike."""


def write_results(out: Path, results: Results, store: Store) -> None:
    """Write ``numbers.json``, ``numbers.csv``, a PNG a figure, and ``index.html``.

    Raises UsageError: a file cannot be written.

    Parameters
    ----------
    out : Path; folder that exists
    """
    figures = [
        (name, title, words, png_of(draw(results, store)))
        for name, title, words, draw, wanted in FIGURES
        if wanted(results)
    ]
    plain = as_plain(results)
    for name, _, _, png in figures:
        write_file(out / f"{name}.png", png)
    write_file(out / "numbers.json", json_text(plain).encode())
    write_file(out / "numbers.csv", as_csv(results).encode())
    write_file(out / "index.html", _page(results, figures))


def _page(results: Results, figures: list[tuple[str, str, str, bytes]]) -> bytes:
    values = {
        "sweep": results.sweep,
        "truth": results.truth,
        "advice": results.advice,
        "columns": COLUMNS,
        "rows": cells(results),
        "machine": machine(),
        "figures": figures,
    }
    return render_page("restir_gi.reference.reports.tradeoff", "tradeoff.html", values)


def _shown(results: Results) -> list[DesignScore]:
    """Those of the first knob, or as many as there is room for."""
    groups = results.groups
    first = groups[0][1] if groups else []
    found = {s.point.key: s for s in (*results.scores[:1], *first)}
    return list(found.values())[:LINES]


def _curves(results: Results, store: Store) -> "Figure":
    return curves(_shown(results), results.light)


def _bars(results: Results, store: Store) -> "Figure":
    return bars(_turned(results), results.light)


def _front(results: Results, store: Store) -> "Figure":
    return front(results.once, results.light)


def _maps(results: Results, store: Store) -> "Figure":
    maps = []
    truth, width = results.truth, results.sweep.named.width
    for score in _shown(results):
        runs = [store.get(task).color for task in results.sweep.runs_of(score.point)]
        maps.append((score.point.label, deviations(np.array(runs), truth)))
    return draw_maps(maps, width)


def _after(results: Results, store: Store) -> "Figure":
    return draw_recoveries(results.recoveries)


def _near(results: Results, store: Store) -> "Figure":
    return neighbours([(n, s) for n, s in results.groups if n in NEAR])


def _turned(results: Results) -> list[tuple[str, list[DesignScore]]]:
    return [(name, s) for name, s in results.groups if name != "several"]


Draw = Callable[[Results, Store], "Figure"]
Wanted = Callable[[Results], bool]

FIGURES: tuple[tuple[str, str, str, Draw, Wanted], ...] = (
    (
        "curves",
        "Error against time and rays",
        "Means of ever more independent frames. What has no bias falls for ever; dashed"
        " is the bias that is certain, below which the others never come.",
        _curves,
        lambda results: True,
    ),
    (
        "bars",
        "What of the error is bias",
        "One knob turned, all else as in the base.",
        _bars,
        lambda results: bool(_turned(results)),
    ),
    (
        "front",
        "What is worth taking",
        "Grey points are as slow, as biased and as noisy as another one, or worse.",
        _front,
        lambda results: True,
    ),
    (
        "maps",
        "Where it is biased",
        "Mean of the runs less the truth in standard errors, from -6 (blue, too dark)"
        " to 6 (red, too bright). Unbiased settings are noise without a pattern.",
        _maps,
        lambda results: True,
    ),
    (
        "near",
        "Who errs alike",
        "The side of the square, and the number of frames, in which errors are alike.",
        _near,
        lambda results: any(name in NEAR for name, _ in results.groups),
    ),
    (
        "change",
        "After a change of light",
        "All lights were four times as bright before.",
        _after,
        lambda results: bool(results.recoveries),
    ),
)
