"""``restir check``: the verdict on a backend, and the name of the bug."""

import argparse
import time
from itertools import chain
from pathlib import Path

from reference.commands.arguments import add_json
from reference.commands.console import emit, progress, show
from reference.commands.values import seconds
from reference.errors import UsageError
from reference.oracle.backends.backend import Backend, Limits
from reference.oracle.backends.command import PLACE, ProgramBackend
from reference.oracle.backends.files import FilesBackend
from reference.oracle.backends.find import backend_names, is_python
from reference.oracle.backends.process import PythonBackend
from reference.oracle.contract.fields import Precision
from reference.oracle.contract.registry import CONTRACT
from reference.oracle.golden import read_golden
from reference.oracle.ladder import golden_rungs, ladder, statistical_rungs
from reference.oracle.report.page import write_page
from reference.oracle.report.plain import as_plain
from reference.oracle.report.table import table
from reference.oracle.verdict import Verdict, climb

NAME = "check"
BUDGET = 600.0
EXIT = {"PASS": 0, "FAIL": 1, "UNDECIDED": 3}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments.

    Parameters
    ----------
    parser : ArgumentParser
        Of this command.
    """
    names = ", ".join(backend_names())
    parser.add_argument(
        "backend",
        metavar="BACKEND",
        help=f"{names}; module:object or file.py[:object]; a command line with {PLACE};"
        " or a folder with outputs beside golden inputs",
    )
    parser.add_argument(
        "--against",
        type=Path,
        metavar="DIR",
        help="golden folder whose cases are judged (default: cases are made)",
    )
    parser.add_argument(
        "--budget",
        type=seconds,
        default=BUDGET,
        metavar="SECONDS",
        help=f"no step of the ladder begins after that (default {BUDGET:g})",
    )
    parser.add_argument(
        "--limit",
        type=seconds,
        default=Limits().seconds,
        metavar="SECONDS",
        help=f"for one call of one pass (default {Limits().seconds:g})",
    )
    parser.add_argument(
        "--precision",
        choices=("float32", "float64"),
        default="float32",
        help="of a command (default float32); an object says its own",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the report")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Judge, and tell the verdict.

    Parameters
    ----------
    arguments : Namespace
        Parsed.

    Returns
    -------
    int
        Exit code: 0 pass, 1 fail, 3 undecided.

    Raises
    ------
    UsageError
        There is no such backend or folder.
    """
    verdict = _judge(arguments)
    plain = as_plain(verdict, arguments.backend, CONTRACT)
    if arguments.out is not None:
        write_page(arguments.out, verdict, plain)
    if arguments.json:
        emit(plain)
    else:
        show(table(plain))
        if arguments.out is not None:
            show(f"{arguments.out / 'index.html'} shows where and why")
    return EXIT[verdict.status]


def _judge(arguments: argparse.Namespace) -> Verdict:
    against, spec = arguments.against, arguments.backend
    folder = Path(spec)
    is_folder = folder.is_dir() and not is_python(spec)
    if is_folder and against is None:
        against = folder
    golden = read_golden(against) if against is not None else None
    precision: Precision = golden[0] if golden else arguments.precision
    backend = (
        FilesBackend(folder, precision)
        if is_folder
        else _open(spec, Limits(arguments.limit), precision)
    )
    try:
        if golden and backend.precision != golden[0]:
            raise UsageError(
                f"{against} is of {golden[0]}, and the backend calculates in"
                f" {backend.precision}; make one by restir golden --precision"
            )
        start = time.monotonic()

        def remaining() -> float:
            return float(start + arguments.budget - time.monotonic())

        rungs = (
            golden_rungs(CONTRACT, backend, golden[1])
            if golden
            else chain(
                ladder(CONTRACT, backend),
                statistical_rungs(CONTRACT, backend, remaining),
            )
        )
        with progress("check") as tick:
            return climb(
                CONTRACT,
                backend.precision,
                rungs,
                arguments.budget,
                time.monotonic,
                lambda title: tick(0, 1, title),
            )
    finally:
        backend.close()


def _open(spec: str, limits: Limits, precision: Precision) -> Backend:
    if PLACE in spec:
        return ProgramBackend(spec, limits, precision)
    if is_python(spec):
        return PythonBackend(spec, limits)
    raise UsageError(
        f"no backend {spec!r}; known are {', '.join(backend_names())}, module:object,"
        f" file.py[:object], a command line with {PLACE}, or a golden folder"
    )
