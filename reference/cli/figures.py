"""``restir figures``: the figures of the papers, measured and drawn again."""

import argparse
from dataclasses import replace
from typing import Any

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.memory import refuse_what_does_not_fit
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import whole
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures import registry
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import as_plain, table
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder, write_file
from restir_gi.reference.system.json_text import json_text
from restir_gi.reference.system.machine import machine

SIZE = 128


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    names = ", ".join(registry.figure_names())
    parser.add_argument(
        "figures",
        metavar="NAME",
        nargs="*",
        help=f"{names}, or numbers of the paper (default: all)",
    )
    parser.add_argument(
        "--out", type=new_folder, required=True, metavar="DIR", help="folder"
    )
    parser.add_argument(
        "--size",
        type=whole(16, 4096),
        default=SIZE,
        metavar="N",
        help=f"pixels of a side of each picture (default {SIZE})",
    )
    parser.add_argument(
        "--runs",
        type=whole(2, 1000),
        metavar="N",
        help="runs of each method, with different seeds (default: the figure's own)",
    )
    parser.add_argument(
        "--threads",
        type=whole(1, 1024),
        default=1,
        metavar="N",
        help="bands worked on at once (default 1: small pictures gain little by more)",
    )
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Make the figures and write each as soon as it is there.

    Raises UsageError: no such figure, too few runs for one, or a file cannot be
    written.
    """
    wanted = [
        registry.find_figure(name)
        for name in arguments.figures or registry.figure_names()
    ]
    entries = list(dict.fromkeys(wanted))
    works = [_work(arguments, entry) for entry in entries]
    refuse_what_does_not_fit(arguments.size, arguments.size)
    make_folder(arguments.out)
    results: list[dict[str, Any]] = []
    for entry, work in zip(entries, works, strict=True):
        with progress(f"figure {entry.name}") as tick:
            figure = entry.make(replace(work, tick=tick))
        picture = arguments.out / f"{entry.name}.png"
        numbers = {
            **as_plain(figure),
            "picture": picture.name,
            "size": work.size,
            "runs": work.runs,
            "machine": machine(),
        }
        write_file(picture, figure.png())
        write_file(picture.with_suffix(".json"), json_text(numbers).encode())
        results.append(numbers)
        if not arguments.json:
            show(figure.title)
            show(table(figure))
            for remark in figure.remarks:
                show(remark)
            show(f"Look at {picture}.")
    if arguments.json:
        emit({"figures": results})


def _work(arguments: argparse.Namespace, entry: registry.FigureEntry) -> Work:
    runs = arguments.runs or entry.runs
    if runs < entry.least_runs:
        raise UsageError(
            f"--runs {runs}: figure {entry.name} needs at least {entry.least_runs}"
        )
    pixels = arguments.size**2
    band = min(options.BAND, -(-pixels // arguments.threads))
    return Work(arguments.size, runs, Schedule(band, arguments.threads))
