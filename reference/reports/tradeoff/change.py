"""How long the past is seen after a change of light."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.reference.methods import Method
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.figures.canvas import COLORS, blank, tidy
from restir_gi.reference.reports.figures.tiles import tile_means
from restir_gi.reference.reports.tradeoff.knobs import Knob, usable
from restir_gi.reference.reports.tradeoff.points import Design
from restir_gi.reference.reports.tradeoff.store import Store
from restir_gi.reference.reports.tradeoff.sweep import Sweep, pixel_of
from restir_gi.reference.transport.accumulate import Pixel

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure

STORED = ("motion=as-stored", "validate_every=0")

WAYS = Knob(
    "after a change of light",
    (
        ("looked up again", ("motion=shifted",)),
        *(
            (f"as stored, cap {cap}", (*STORED, f"temporal_cap={cap}"))
            for cap in (1, 8, 30, 100)
        ),
        ("as stored, validated every 6", ("motion=as-stored", "validate_every=6")),
        ("as stored, validated every 2", ("motion=as-stored", "validate_every=2")),
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class Recovery:
    """Error of a point after a change of light.

    Attributes
    ----------
    point : Design; method and settings
    error : (F,) float64
        Root mean squared error of the tiles of frame 0, 1, ... after the change, as a
        share of the mean light.
    mean : (F,) float64
        Of the whole picture, relative to the truth: 3 where all is as it was before.
    """

    point: Design
    error: Scalars
    mean: Scalars


def points_after_change(base: Design, method: Method) -> tuple[Design, ...]:
    """What is looked at after a change of light.

    Ways to treat the past; the base alone where the method knows but one.
    """
    found = usable([WAYS], method)
    if not found:
        return (base,)
    return tuple(
        Design(base.method, (*base.values, *values), WAYS.name, label)
        for label, values in found[0].levels
    )


def recoveries(
    sweep: Sweep, store: Store, truths: Mapping[Pixel, Moments]
) -> list[Recovery]:
    """Errors after a change of light.

    Parameters
    ----------
    truths : mapping of 'center' and 'box' to Moments; of the light after the change
    """
    found = []
    for point in sweep.changed:
        truth = truths[pixel_of(point)]
        true = tile_means(truth.mean, sweep.named.width)
        light = float(truth.mean.mean()) or 1.0
        runs = [store.get(task) for task in sweep.runs_after_change(point)]
        tiles = np.array([run.tiles[sweep.frames :] for run in runs], np.float64)
        squares = ((tiles - true) ** 2).mean(axis=(0, 2, 3))
        means = tiles.mean(axis=(0, 2, 3)) / (float(true.mean()) or 1.0) - 1.0
        found.append(Recovery(point, np.sqrt(squares) / light, means))
    return found


def draw_recoveries(found: Sequence[Recovery]) -> "Figure":
    """Error against frame after the change.

    Parameters
    ----------
    found : sequence of Recovery; at least one

    Returns
    -------
    Figure; left the error of tiles, right that of the whole picture
    """
    picture = blank(11, 3.8)
    parts = (
        ("error of tiles / mean light", "log", [r.error for r in found]),
        ("error of the whole picture", "linear", [r.mean for r in found]),
    )
    for axes, (label, scale, lines) in zip(picture.subplots(1, 2), parts, strict=True):
        for index, (recovery, line) in enumerate(zip(found, lines, strict=True)):
            style = "-" if index < len(COLORS) else ":"
            color = COLORS[index % len(COLORS)]
            axes.plot(line, style, color=color, label=recovery.point.label)
        axes.set_yscale(scale)
        tidy(axes, "", "frames after the change", label)
    axes.legend(fontsize=7, frameon=False)
    return picture
