"""``restir check``: the verdict on a backend, and the name of the bug."""

import argparse
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from restir_gi.reference.cli.arguments import add_json, add_reading, add_scheduler
from restir_gi.reference.cli.console import emit, progress, remark, show
from restir_gi.reference.cli.opening import size_in_shape
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import amount, limit, seconds, tiled_size, whole
from restir_gi.reference.oracle.backends.command import PLACE
from restir_gi.reference.oracle.backends.files import FilesBackend
from restir_gi.reference.oracle.backends.find import backend_names, is_python
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.blackbox.judge import renderer_levels
from restir_gi.reference.oracle.blackbox.renderer import PLACES, Renderer
from restir_gi.reference.oracle.blackbox.truth import TILES, Truth, path_traced
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.golden import read_golden
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import Verdict, run_ladder
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.reports.verdict.table import table
from restir_gi.reference.scene.named import find_scene_or_file
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.workers import ahead, workers

BUDGET = 600.0
SCENE = "cornell-box"
TRUTH_SAMPLES = 4096
PIXELS = 64 * 64
AHEAD = 32  # pictures that a cluster renders before they are wanted
EXIT = {"PASS": 0, "FAIL": 1, "UNDECIDED": 3}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    names = ", ".join(backend_names())
    parser.add_argument(
        "backend",
        metavar="BACKEND",
        help=f"{names}; module:object or file.py[:object]; a command line with {PLACE};"
        " or a folder with outputs beside golden inputs; or the command line of a"
        f" renderer with {', '.join(PLACES)}",
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
        help="in which the backend is loaded and asked; what has no time then is told"
        f" (default {BUDGET:g})",
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
        "--scene",
        default=SCENE,
        metavar="SCENE",
        help=f"what a renderer renders: built-in or a file (default {SCENE})",
    )
    add_reading(parser)
    parser.add_argument(
        "--bounces",
        type=whole(1, 30),
        default=1,
        metavar="K",
        help="of the renderer's indirect light (default 1)",
    )
    parser.add_argument(
        "--frames",
        type=whole(1, 2**27 - 1),
        default=8,
        metavar="F",
        help="of a renderer, from an empty history to the picture (default 8)",
    )
    parser.add_argument(
        "--size",
        type=tiled_size,
        metavar="WxH",
        help="pixels of the renderer's picture, multiples of 4; one number for a square"
        f" (default: the shape of the scene's camera, about {PIXELS} pixels)",
    )
    parser.add_argument(
        "--layer",
        metavar="NAME",
        help="which picture of a renderer's file of several, such as Combined",
    )
    parser.add_argument(
        "--bound",
        type=amount,
        metavar="B",
        help="your word that no tile's mean in one picture exceeds B times its truth",
    )
    parser.add_argument(
        "--out", type=new_folder, metavar="DIR", help="folder for the report"
    )
    add_scheduler(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Judge, and tell the verdict.

    Exit code: 0 pass, 1 fail, 3 undecided; 1 also if the backend is wrong and the
    report cannot be written.

    Raises UsageError: there is no such backend or folder, or the report of a backend
    that is not known to be wrong cannot be written.
    """
    verdict = _judge(arguments)
    plain = as_plain(verdict, arguments.backend, whole_contract())
    emit(plain) if arguments.json else show(table(plain))
    if arguments.out is not None:
        try:
            write_page(arguments.out, verdict, plain)
        except UsageError as error:
            if verdict.status != "FAIL":
                raise
            remark(f"the report is not written: {error}")
        else:
            if not arguments.json:
                show(f"{arguments.out / 'index.html'} shows where and why")
    return EXIT[verdict.status]


def _judge(arguments: argparse.Namespace) -> Verdict:
    backend: Any = arguments.backend
    against = arguments.against
    if "{out}" in backend:
        return _judge_renderer(arguments)
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
        )


def _cluster(arguments: argparse.Namespace, stack: ExitStack) -> Executor | None:
    if not arguments.scheduler:
        return None
    return stack.enter_context(workers(1, arguments.scheduler))


def _judge_renderer(arguments: argparse.Namespace) -> Verdict:
    scene = find_scene_or_file(
        arguments.scene, arguments.lenient, arguments.allow_outside
    )
    size = arguments.size or size_in_shape(scene.camera, PIXELS, TILES)
    limits = Limits(arguments.limit)
    start = time.monotonic()

    def remaining() -> float:
        return float(start + arguments.budget - time.monotonic())

    about = arguments.backend, arguments.scene, arguments.frames, size, limits
    renderer = Renderer(*about, remaining, layer=arguments.layer)

    def truth() -> Truth:
        return path_traced(scene, size, arguments.bounces, TRUTH_SAMPLES, remaining)

    with progress("check") as tick, ExitStack() as stack:
        cluster = _cluster(arguments, stack)
        pictures = None
        if cluster is not None:  # whose machines have clocks of their own
            remote = Renderer(*about, layer=arguments.layer)
            pictures = partial(_ahead, cluster, remote, remaining)
        levels = renderer_levels(renderer, truth, arguments.bound, remaining, pictures)
        verdict = run_ladder(
            {},
            "float32",
            levels,
            arguments.budget,
            time.monotonic,
            lambda title: tick(0, 1, title),
        )
    return replace(verdict, left_running=sum(renderer.left_running))


def _ahead(
    cluster: Executor,
    renderer: Renderer,
    remaining: Callable[[], float],
    seeds: Iterator[int],
) -> Iterator[Any]:
    return ahead(cluster, renderer.render, seeds, AHEAD, remaining)
