"""``restir check``: the verdict on a backend, and the name of the bug."""

import argparse
import os
import shlex
from concurrent.futures import Executor
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

from restir_gi.reference.cli.arguments import add_json, add_reading, add_scheduler
from restir_gi.reference.cli.check_captures import is_capture, judge_capture
from restir_gi.reference.cli.check_outputs import (
    ShowFile,
    add_output_arguments,
    baseline_of,
    conclude,
)
from restir_gi.reference.cli.check_pictures import (
    add_picture_arguments,
    judge_renderer,
)
from restir_gi.reference.cli.console import progress, remark
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import (
    MOST_SEED,
    limit,
    seconds,
    whole,
    words,
)
from restir_gi.reference.oracle.backends.command import PLACE
from restir_gi.reference.oracle.backends.files import FilesBackend
from restir_gi.reference.oracle.backends.find import backend_names, is_python
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.blackbox.renderer import PLACES
from restir_gi.reference.oracle.checking import judge, selection_of
from restir_gi.reference.oracle.declaration.schema import PUBLISHED
from restir_gi.reference.oracle.golden import read_golden, write_failing
from restir_gi.reference.oracle.parts import SEED, whole_contract
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.reports.verdict.table import table
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.workers import workers

BUDGET = 600.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    names = ", ".join(backend_names())
    parser.add_argument(
        "backend",
        metavar="BACKEND",
        help=f"{names}; module:object or file.py[:object]; a command line with {PLACE};"
        " a folder with outputs beside golden inputs; a folder with capture.toml, which"
        " restir capture-template describes; or the command line of a"
        f" renderer with {', '.join(PLACES)}",
    )
    parser.add_argument(
        "--against",
        type=Path,
        metavar="DIR",
        help="golden folder whose cases are judged (default: cases are made)",
    )
    parser.add_argument(
        "--case",
        metavar="NAME",
        help="ask this one case alone, as the report names it",
    )
    parser.add_argument(
        "--only",
        type=words,
        default=frozenset(),
        metavar="NAMES",
        help="passes that alone are asked, with commas between them",
    )
    parser.add_argument(
        "--skip",
        type=words,
        default=frozenset(),
        metavar="NAMES",
        help="passes that are not asked",
    )
    parser.add_argument(
        "--require",
        type=words,
        default=frozenset(),
        metavar="NAMES",
        help="passes that must be there and be judged, else it is FAIL",
    )
    parser.add_argument(
        "--declare",
        type=words,
        default=frozenset(),
        metavar="NAMES",
        help="choices that your renderer makes, such as visibility-in-final-shading",
    )
    parser.add_argument(
        "--declaration",
        type=Path,
        metavar="FILE",
        help="TOML file that says what your renderer has and which choices it makes",
    )
    parser.add_argument(
        "--declaration-schema",
        action=ShowFile,
        nargs=0,
        const=PUBLISHED,
        help="show the JSON schema of such a file, and exit",
    )
    parser.add_argument(
        "--accept",
        type=words,
        default=frozenset(),
        metavar="NAMES",
        help="declared choices whose bias does not fail, such as jacobian-clamped",
    )
    parser.add_argument(
        "--seed",
        type=whole(0, MOST_SEED),
        default=SEED,
        metavar="S",
        help=f"of all rows that are random (default {SEED})",
    )
    parser.add_argument(
        "--extremes",
        action="store_true",
        help="FAIL also for what is wrong beyond the working range alone",
    )
    parser.add_argument(
        "--budget",
        type=seconds,
        default=BUDGET,
        metavar="SECONDS",
        help="in which the backend is loaded and asked; what has no time then is told"
        f" (default {BUDGET:g})",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="the cheapest steps alone, as before a commit: FAIL is known as ever, and"
        " what is not wrong is QUICK, exit code 0, and no verdict of the whole",
    )
    parser.add_argument(
        "--limit",
        type=limit,
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
    parser.add_argument(
        "--out", type=new_folder, metavar="DIR", help="folder for the report"
    )
    parser.add_argument(
        "--keep",
        type=partial(new_folder, option="--keep"),
        metavar="DIR",
        help="golden folder for the cases that failed, for --against",
    )
    add_scheduler(parser)
    add_json(parser)
    add_output_arguments(parser)
    add_picture_arguments(parser)
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Judge, and tell the verdict.

    Exit code: 0 pass, 1 fail, 3 undecided; 1 also if the backend is wrong and the
    report or the failing cases cannot be written; 0 also if it is wrong in nothing but
    what the baseline knows, or if nothing is wrong in the quick steps.

    Raises UsageError: there is no such backend, folder, pass or case, or the report of
    a backend that is not known to be wrong cannot be written.
    """
    if "{out}" in arguments.backend or "{list}" in arguments.backend:
        return judge_renderer(arguments)
    captured = is_capture(arguments.backend)
    _refuse_slow(arguments)
    kind, asked = ("capture" if captured else "passes"), _asked(arguments, captured)
    baseline = baseline_of(arguments, kind, asked)
    verdict = judge_capture(arguments) if captured else _judge(arguments)
    kept = _keep(arguments, verdict)
    again = "" if captured else _again(arguments, kept)
    contract = whole_contract()
    plain = as_plain(verdict, arguments.backend, contract, again, kind, asked)
    many = f"{arguments.keep} holds the {len(kept)} cases that are wrong"
    return conclude(
        arguments,
        plain,
        baseline,
        table,
        lambda out: write_page(out, verdict, plain),
        many if kept else "",
    )


def _refuse_slow(arguments: argparse.Namespace) -> None:
    """Raise where ``--quick`` stands beside what is chosen otherwise.

    Raises UsageError.
    """
    for option in ("against", "case", "scheduler"):
        if arguments.quick and getattr(arguments, option) is not None:
            raise UsageError(
                f"--quick chooses what is asked, and so does --{option}; leave one out"
            )
    if arguments.quick and os.path.isdir(arguments.backend):
        raise UsageError(
            "--quick chooses what is asked, and the cases of a folder are as they are;"
            " leave it out"
        )


def _asked(arguments: argparse.Namespace, captured: bool) -> dict[str, Any]:
    """Options that decide what is asked, for programs."""
    if captured:
        return {"extremes": arguments.extremes}
    against = arguments.against
    return {
        "seed": arguments.seed,
        "precision": arguments.precision,
        "extremes": arguments.extremes,
        "quick": arguments.quick,
        "only": sorted(arguments.only),
        "skip": sorted(arguments.skip),
        "case": arguments.case,
        "require": sorted(arguments.require),
        "against": None if against is None else str(against),
    }


def _keep(arguments: argparse.Namespace, verdict: Verdict) -> list[str]:
    """Names of the failing cases that are kept."""
    if arguments.keep is None:
        return []
    try:
        kept = write_failing(
            arguments.keep, whole_contract(), verdict, arguments.backend
        )
    except UsageError as error:
        if verdict.status != "FAIL":
            raise
        remark(f"the failing cases are not kept: {error}")
        return []
    if not kept:
        remark(f"no single case is wrong: nothing is kept in {arguments.keep}")
    return kept


def _again(arguments: argparse.Namespace, kept: list[str]) -> str:
    """The command of this check, to which the name of a case is added.

    Of cases that are kept it asks for these very files.
    """
    line = ["restir", "check", arguments.backend]
    against = arguments.keep if kept else arguments.against
    if against is not None:
        line += ["--against", str(against)]
    if arguments.seed != SEED and against is None:
        line += ["--seed", str(arguments.seed)]
    if arguments.precision != "float32":
        line += ["--precision", arguments.precision]
    if arguments.limit != Limits().seconds:
        line += ["--limit", f"{arguments.limit:g}"]
    if arguments.declare:
        line += ["--declare", ",".join(sorted(arguments.declare))]
    if arguments.declaration is not None:
        line += ["--declaration", str(arguments.declaration)]
    if arguments.accept:
        line += ["--accept", ",".join(sorted(arguments.accept))]
    return shlex.join(line)


def _judge(arguments: argparse.Namespace) -> Verdict:
    backend: Any = arguments.backend
    against = arguments.against
    folder = Path(backend)
    # A command line may be longer than any name: that is no error.
    if os.path.isdir(backend) and not is_python(backend):
        against = folder if against is None else against
        backend = FilesBackend(folder, read_golden(against)[0])
    if arguments.scheduler and against is not None:
        raise UsageError(
            "--scheduler is for whole runs, and golden folders have none; leave it out"
        )
    with progress("check") as tick, ExitStack() as stack:
        return judge(
            backend,
            arguments.budget,
            limits=Limits(arguments.limit),
            precision=arguments.precision,
            against=against,
            tell=lambda title: tick(0, 1, title),
            executor=_cluster(arguments, stack),
            seed=arguments.seed,
            selection=selection_of(arguments.only, arguments.skip, arguments.case),
            require=sorted(arguments.require),
            extremes=arguments.extremes,
            declared=arguments.declare,
            declaration=arguments.declaration,
            accept=arguments.accept,
            quick=arguments.quick,
        )


def _cluster(arguments: argparse.Namespace, stack: ExitStack) -> Executor | None:
    if not arguments.scheduler:
        return None
    return stack.enter_context(workers(1, arguments.scheduler))
