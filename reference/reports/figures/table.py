"""Numbers of a figure as a table for a terminal, and as JSON for a program."""

from dataclasses import asdict
from math import isfinite
from typing import Any

from rich.table import Table

from restir_gi.reference.numerics.intervals import Interval
from restir_gi.reference.reports.figures.record import Cell, Deviation, PaperFigure


def text(cell: Cell) -> str:
    """A number as it is read.

    Three digits; an interval in brackets, a deviation in per cent.
    """
    match cell:
        case Interval(value, low, high):
            return f"{value:.3g} [{low:.3g}, {high:.3g}]"
        case Deviation(value, error):
            return f"{value:+.2%} ± {error:.2%}"
        case float():
            return f"{cell:.3g}"
        case _:
            return str(cell)


def table(figure: PaperFigure) -> Table:
    """Rows of a figure for a terminal.

    Parameters
    ----------
    figure : PaperFigure; with at least one row
    """
    made = Table()
    for column, cell in figure.rows[0].items():
        made.add_column(column, justify="left" if isinstance(cell, str) else "right")
    for row in figure.rows:
        made.add_row(*map(text, row.values()))
    return made


def as_plain(figure: PaperFigure) -> dict[str, Any]:
    """Numbers of a figure for a program.

    Text, numbers, lists and dicts alone; numbers that are not finite are None.

    Parameters
    ----------
    figure : PaperFigure; without its picture
    """
    rows = [{name: _plain(cell) for name, cell in row.items()} for row in figure.rows]
    return {
        "name": figure.name,
        "title": figure.title,
        "rows": rows,
        "remarks": list(figure.remarks),
    }


def _plain(cell: Cell) -> Any:
    if isinstance(cell, Interval | Deviation):
        return {name: _plain(number) for name, number in asdict(cell).items()}
    if isinstance(cell, float) and not isfinite(cell):
        return None
    return cell
