"""The page of the demonstration, and its table."""

from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from restir_gi.reference.reports.demo.score import RunScore
from restir_gi.reference.reports.page import render_page
from restir_gi.reference.system.files import write_file

COLUMNS = (
    "method",
    "s/image",
    "MSE",
    "times better in equal time",
    "bias of the mean",
)


def cells(score: RunScore) -> tuple[str, ...]:
    """Score as text, a cell a column, in the order of `COLUMNS`."""
    return (
        score.name,
        f"{score.seconds:.3f}",
        f"{score.mse:.3g}",
        f"{score.gain:.3g}",
        f"{score.bias:+.2%} ± {score.bias_error:.2%}",
    )


def table(scores: Sequence[RunScore], title: str) -> Table:
    """Scores as a table for a terminal."""
    made = Table(title=title, title_justify="left")
    for column in COLUMNS:
        made.add_column(column, justify="left" if column == "method" else "right")
    for score in scores:
        made.add_row(*cells(score))
    return made


def write_page(
    path: Path, title: str, remarks: Sequence[str], scores: Sequence[RunScore]
) -> None:
    """Write the page that links everything.

    Parameters
    ----------
    path : Path; in the folder where the pictures are
    remarks : sequence of str; how the numbers came about
    scores : sequence of RunScore
        Each with pictures ``NAME.exr``, ``NAME.png`` and a page
        ``NAME/index.html``.
    """
    values = {
        "title": title,
        "remarks": remarks,
        "columns": COLUMNS,
        "rows": [(score.name, cells(score)) for score in scores],
    }
    write_file(
        path, render_page("restir_gi.reference.reports.demo", "demo.html", values)
    )
