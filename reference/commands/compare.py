"""``restir compare``: judge a picture against another one, the truth."""

import argparse
from pathlib import Path

from rich.table import Table

from reference.commands.arguments import add_json
from reference.commands.console import emit, show
from reference.commands.targets import new_folder
from reference.comparison import Comparison, compare
from reference.comparison.labels import NUMBERS
from reference.exr import read_exr


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments.

    Parameters
    ----------
    parser : ArgumentParser
        Of this command.
    """
    parser.add_argument("a", type=Path, metavar="A.exr", help="the picture")
    parser.add_argument("b", type=Path, metavar="B.exr", help="the truth")
    parser.add_argument(
        "--out", type=new_folder, metavar="DIR", help="folder for maps and an HTML page"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Compare, print the numbers, and write the page.

    Parameters
    ----------
    arguments : Namespace
        Parsed.

    Raises
    ------
    UsageError
        A file cannot be read, the two do not match, or the folder not be written.
    """
    a, b, out = arguments.a, arguments.b, arguments.out
    numbers = compare(read_exr(a), read_exr(b), out, names=(str(a), str(b)))
    if arguments.json:
        page = None if out is None else str(out / "index.html")
        emit({"a": str(a), "b": str(b), "page": page, **numbers.as_dict()})
        return
    show(_table(numbers, str(a), str(b)))
    if out is not None:
        show(f"{out / 'index.html'} shows the maps")


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
