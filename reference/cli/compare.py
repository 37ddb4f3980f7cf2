"""``restir compare``: judge a picture against another one, the truth."""

import argparse
from dataclasses import asdict
from pathlib import Path

from rich.table import Table

from restir_gi.reference.cli.arguments import add_json
from restir_gi.reference.cli.console import emit, show
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import amount
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.reports.comparison import Comparison, compare
from restir_gi.reference.reports.comparison.labels import NUMBERS
from restir_gi.reference.reports.comparison.likeness import Difference, differences
from restir_gi.reference.system.errors import UsageError

BEYOND = 1  # exit code


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    parser.add_argument("a", type=Path, metavar="A.exr", help="the picture")
    parser.add_argument("b", type=Path, metavar="B.exr", help="the truth")
    parser.add_argument(
        "--layer",
        action="append",
        default=[],
        metavar="NAME",
        help="which picture of a file of several, such as ViewLayer.Combined; color is"
        " R, G, B; given twice, the first is of A and the second of B",
    )
    parser.add_argument(
        "--tolerance",
        type=amount,
        metavar="X",
        help=f"exit code {BEYOND} where relMSE is above X or a pixel is not finite",
    )
    parser.add_argument(
        "--out", type=new_folder, metavar="DIR", help="folder for maps and an HTML page"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compare, print the numbers, and write the page.

    Exit code: 0, or 1 beyond the tolerance.

    Raises UsageError: a file cannot be read, the two do not match, or the folder not be
    written.
    """
    layers = arguments.layer or [None]
    if len(layers) > 2:
        raise UsageError(
            f"--layer may be given twice, for A and for B, not {len(layers)} times"
        )
    a, b, out = arguments.a, arguments.b, arguments.out
    picture, truth = read_exr(a, layers[0]), read_exr(b, layers[-1])
    numbers = compare(picture, truth, out, names=(str(a), str(b)))
    unlike = differences(picture.metadata, truth.metadata)
    within = _within(numbers, arguments.tolerance)
    if arguments.json:
        emit(
            {
                "a": str(a),
                "b": str(b),
                "page": None if out is None else str(out / "index.html"),
                "differences": [asdict(one) for one in unlike],
                "tolerance": arguments.tolerance,
                "within": within,
                **numbers.as_dict(),
            }
        )
    else:
        if unlike:
            certain = "" if any(one.certain for one in unlike) else " known to be"
            show(f"Not{certain} pictures of the same thing:")
            show(_differences(unlike))
        show(_table(numbers, str(a), str(b)))
        if within is not None:
            verdict = "within" if within else "beyond"
            show(f"relMSE {numbers.rel_mse:.4g}: {verdict} {arguments.tolerance:g}")
        if out is not None:
            show(f"{out / 'index.html'} shows the maps")
    return BEYOND if within is False else 0


def _within(numbers: Comparison, tolerance: float | None) -> bool | None:
    if tolerance is None:
        return None
    # Pixels that are not finite are left out of relMSE: they pass for nothing.
    finite = numbers.not_finite_a == numbers.not_finite_b == 0
    return finite and numbers.rel_mse <= tolerance


def _differences(unlike: list[Difference]) -> Table:
    table = Table("differs", "A", "B")
    for one in sorted(unlike, key=lambda one: not one.certain):
        table.add_row(one.what, one.a or "not known", one.b or "not known")
    return table


def _table(numbers: Comparison, a: str, b: str) -> Table:
    values = numbers.as_dict()
    table = Table(title=f"A = {a}, B = {b}", title_justify="left")
    table.add_column("")
    table.add_column("", justify="right")
    table.add_column("meaning")
    for number in NUMBERS:
        if values[number.name] is not None:
            table.add_row(
                number.label, number.text(values[number.name]), number.meaning
            )
    return table
