"""What ``restir check`` tells and writes: verdict, report, JUnit, SARIF, baseline."""

import argparse
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import RenderableType

from restir_gi.reference.cli.console import emit, remark, show
from restir_gi.reference.cli.targets import new_file
from restir_gi.reference.reports.integration.baseline import (
    as_plain,
    compared,
    read_baseline,
    refuse_other,
)
from restir_gi.reference.reports.integration.junit import junit_text
from restir_gi.reference.reports.integration.sarif import sarif_of
from restir_gi.reference.reports.verdict.schema import PUBLISHED
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import write_file
from restir_gi.reference.system.json_text import json_text

EXIT = {"PASS": 0, "FAIL": 1, "UNDECIDED": 3, "QUICK": 0}
Plain = dict[str, Any]


class ShowFile(argparse.Action):
    """An option that shows a file of the package, its ``const``, and exits."""

    def __call__(self, parser: argparse.ArgumentParser, *rest: Any) -> None:
        """Show it."""
        assert isinstance(self.const, Path)
        show(self.const.read_text(encoding="utf-8").rstrip())
        parser.exit()


def add_output_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments of continuous integration."""
    group = parser.add_argument_group("of continuous integration")
    group.add_argument(
        "--junit",
        type=new_file(".xml", "--junit"),
        metavar="FILE",
        help="write the verdict as JUnit XML: a test case for each pass",
    )
    group.add_argument(
        "--sarif",
        type=new_file(".sarif", "--sarif"),
        metavar="FILE",
        help="write the verdict as SARIF 2.1.0: a result for each mistake",
    )
    group.add_argument(
        "--baseline",
        type=Path,
        metavar="FILE",
        help="a verdict.json of before: only what is new since then is FAIL",
    )
    group.add_argument(
        "--verdict-schema",
        action=ShowFile,
        nargs=0,
        const=PUBLISHED,
        help="show the JSON schema of verdict.json and of --json, and exit",
    )


def baseline_of(arguments: argparse.Namespace, kind: str, asked: Plain) -> Plain | None:
    """The baseline, if one is named; looked at before anything is asked.

    Raises UsageError: it cannot be read, or is of another check.
    """
    if arguments.baseline is None:
        return None
    found = read_baseline(arguments.baseline)
    refuse_other(arguments.baseline, found, kind, arguments.backend, asked)
    return found


def conclude(
    arguments: argparse.Namespace,
    plain: Plain,
    baseline: Plain | None,
    table: Callable[[Plain], RenderableType],
    write: Callable[[Path], None] | None,
    more: str = "",
) -> int:
    """Tell a verdict and write what is asked for.

    The exit code is that of the verdict, beside its baseline if there is one.

    Raises UsageError: a file cannot be written, of what is not known to be wrong.

    Parameters
    ----------
    write : callable, optional; writes the report into a folder; None: there is none
    more : str; a further line for people
    """
    if baseline is not None:
        found = compared(plain, baseline)
        plain["baseline"] = as_plain(arguments.baseline, found, plain)
    status = plain["baseline"]["status"] if baseline is not None else plain["status"]
    if arguments.json:
        emit(plain)
    else:
        show(table(plain))
        for line in plain["baseline"]["told"] if baseline is not None else ():
            show(line)
        if more:
            show(more)
    for what, made in _outputs(arguments, plain, write):
        try:
            made()
        except UsageError as error:
            if status != "FAIL":
                raise
            remark(f"{what} is not written: {error}")
        else:
            if what == REPORT and not arguments.json:
                show(f"{arguments.out / 'index.html'} shows where and why")
    return EXIT[status]


REPORT = "the report"


def _outputs(
    arguments: argparse.Namespace, plain: Plain, write: Callable[[Path], None] | None
) -> Iterator[tuple[str, Callable[[], None]]]:
    """What is written, and what writes it."""
    if arguments.out is not None and write is not None:
        yield REPORT, partial(write, arguments.out)
    if arguments.junit is not None:
        yield "--junit", lambda: write_text(arguments.junit, junit_text(plain))
    if arguments.sarif is not None:
        yield "--sarif", lambda: write_text(arguments.sarif, json_text(sarif_of(plain)))


def write_text(path: Path, text: str) -> None:
    """Replace a file in one step; letters that have no form are written out.

    Raises UsageError: it cannot be written.
    """
    write_file(path, text.encode("utf-8", "backslashreplace"))
