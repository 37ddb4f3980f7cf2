"""Every kernel at every extreme, in 16, 32 and 64 bits."""

from typing import TYPE_CHECKING

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.exact.extremes import EXTREMES
from restir_gi.reference.oracle.exact.matrix import TYPES, MatrixCell, matrix
from restir_gi.reference.oracle.exact.registry import kernels
from restir_gi.reference.reports.figures.canvas import QUIET, blank
from restir_gi.reference.reports.figures.record import PaperFigure, Row, Work
from restir_gi.reference.reports.figures.registry import FigureEntry

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "kernels"


def kernels_at_extremes(work: Work) -> PaperFigure:
    """Errors of all kernels beside exact numbers; a row a cell.

    Parameters
    ----------
    work : Work; ``runs`` rows in each cell
    """
    cells = matrix(kernels(), work.runs, lambda done, of: work.tick(done, of, "cells"))
    return PaperFigure(
        NAME,
        "Every kernel at every extreme: error in units in the last place",
        _picture(cells),
        tuple(_row(cell) for cell in cells),
        (
            f"{work.runs} rows a cell. Error: distance to the exact result for the very"
            " numbers that the kernel was given, in units in its last place. Share: the"
            " same as a share of the bound of running error analysis, which grows where"
            " numbers cancel; 1 would be a fault. Open rows are those that rounding"
            " leaves open, or whose numbers leave the type: they are finite. A cell"
            " with a warning, NaN or infinity says so.",
        ),
    )


def _row(cell: MatrixCell) -> Row:
    ulp = cell.judged.ulp
    return {
        "kernel": cell.kernel,
        "extreme": cell.extreme,
        "type": cell.type,
        "largest error, ulp": float(ulp.max()),
        "99.9 %": float(np.quantile(ulp, 0.999)),
        "largest share of the bound": float(cell.judged.share.max()),
        "open": f"{cell.judged.open.mean():.0%}",
        "verdict": cell.fault or ("exact enough" if cell.passed else "wrong"),
    }


def _picture(cells: list[MatrixCell]) -> "Figure":
    rows = [kernel.name for kernel in kernels()]
    columns = [extreme.name for extreme in EXTREMES]
    picture = blank(14, 15)
    axes = picture.subplots(2, len(TYPES), sharey=True, sharex=True)
    for column, dtype in enumerate(TYPES):
        name = np.dtype(dtype).name
        ulp, share = (np.full((len(rows), len(columns)), np.nan) for _ in range(2))
        for cell in cells:
            if cell.type == name:
                at = rows.index(cell.kernel), columns.index(cell.extreme)
                ulp[at] = np.log2(max(cell.judged.ulp.max(), 0.5))
                share[at] = cell.judged.share.max()
        _heat(axes[0, column], ulp, f"{name}: log2 of the error in ulp", 12.0)
        _heat(axes[1, column], share, f"{name}: share of the bound", 1.0)
    for line in axes:
        line[0].set_yticks(range(len(rows)), rows, fontsize=7)
    for one in axes[1]:
        one.set_xticks(range(len(columns)), columns, fontsize=7, rotation=90)
    return picture


def _heat(axes: "Axes", values: Scalars, title: str, most: float) -> None:
    least = -1.0 if most > 1 else 0.0
    shown = axes.imshow(values, aspect="auto", cmap="viridis", vmin=least, vmax=most)
    axes.set_title(title, fontsize=9)
    axes.set_facecolor("white")
    axes.tick_params(length=0, colors=QUIET)
    axes.figure.colorbar(shown, ax=axes)


FIGURE = FigureEntry(NAME, kernels_at_extremes, 64)
