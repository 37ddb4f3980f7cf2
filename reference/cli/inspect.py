"""``restir inspect``: look into the reservoirs of a run."""

import argparse
from pathlib import Path
from typing import Any

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.memory import refuse_what_does_not_fit
from restir_gi.reference.cli.targets import new_file
from restir_gi.reference.cli.values import MOST_SAMPLES, whole
from restir_gi.reference.images.display import auto_exposure
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.reports.inspector.page import page
from restir_gi.reference.reports.inspector.recorded import recorded
from restir_gi.reference.reports.inspector.runs import (
    as_it_is,
    job_of,
    method_of,
    standing,
)
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import write_file

ROOM = 48 << 20  # bytes of frames that are kept where nobody says how many


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    parser.add_argument(
        "runs",
        nargs="+",
        type=Path,
        metavar="RUN.exr",
        help="picture of restir render, which is made again from its header; a second"
        " one to compare it with; or any other picture with layers as --aov names them",
    )
    parser.add_argument(
        "--out",
        type=new_file(".html"),
        required=True,
        metavar="PAGE.html",
        help="the page",
    )
    parser.add_argument(
        "--last",
        type=whole(1, MOST_SAMPLES),
        metavar="F",
        help=f"frames that the page holds (default: those that fit {ROOM >> 20} MiB)",
    )
    parser.add_argument(
        "--scene",
        metavar="SCENE",
        help="file that the pictures were rendered from, where it is not built in",
    )
    options.add_reading(parser)
    parser.add_argument(
        "--layer",
        metavar="NAME",
        help="which picture of a file of several, such as ViewLayer.Combined; it is"
        " shown as the file has it",
    )
    options.add_schedule(parser)
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Make the runs again, and write the page.

    Raises UsageError: a file cannot be read, the pictures are not of one size, or the
    page cannot be written.
    """
    paths, out = arguments.runs, arguments.out
    if len(paths) > 2:
        raise UsageError(f"one run or two, not {len(paths)}")
    images = [read_exr(path, arguments.layer) for path in paths]
    sizes = {(image.width, image.height) for image in images}
    if len(sizes) > 1:
        a, b = (f"{image.width}x{image.height}" for image in images)
        raise UsageError(f"{paths[0]} is {a} and {paths[1]} {b}: sizes must agree")
    refuse_what_does_not_fit(images[0].width, images[0].height)
    labels = ["A: ", "B: "] if len(paths) > 1 else [""]
    runs = [
        _run(arguments, path, image, label)
        for path, image, label in zip(paths, images, labels, strict=True)
    ]
    title = " and ".join(path.name for path in paths)
    write_file(out, page(title, runs, auto_exposure(images[0].color)))
    _report(arguments, runs)


def _run(
    arguments: argparse.Namespace, path: Path, image: Image, label: str
) -> dict[str, Any]:
    about = {
        "label": label,
        "name": str(path),
        "words": dict(image.metadata),
        "width": image.width,
        "height": image.height,
    }
    method = None if arguments.layer else method_of(image)
    if method is None:
        return about | {
            "standing": f"Shown as the file has it: {', '.join(image.layers)}. How it"
            " came about is not known, so there are no candidates.",
            "replayed": False,
            "frames": [as_it_is(image)],
        }
    schedule = options.schedule(arguments, image.width * image.height)
    job = job_of(
        path,
        image,
        scene=arguments.scene,
        lenient=arguments.lenient,
        allow_outside=arguments.allow_outside,
        schedule=schedule,
    )
    with progress(str(path)) as tick:
        found = recorded(
            method,
            job,
            arguments.last,
            ROOM,
            lambda p: tick(p.done, p.total, p.unit),
        )
    return about | {
        "standing": standing(image, found.layers),
        "replayed": True,
        "frames": found.frames,
    }


def _report(arguments: argparse.Namespace, runs: list[dict[str, Any]]) -> None:
    out = arguments.out
    if arguments.json:
        emit(
            {
                "out": str(out),
                "runs": [
                    {
                        "run": run["name"],
                        "replayed": run["replayed"],
                        "standing": run["standing"],
                        "frames": [frame["number"] for frame in run["frames"]],
                    }
                    for run in runs
                ],
            }
        )
        return
    show(f"{out} shows what a browser can look into")
    for run in runs:
        numbers = [frame["number"] for frame in run["frames"]]
        held = f"Frames {numbers[0]} to {numbers[-1]}. " if run["replayed"] else ""
        show(f"{run['name']}: {held}{run['standing']}")
