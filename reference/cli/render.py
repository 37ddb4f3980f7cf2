"""``restir render``: make a picture with one method."""

import argparse
from pathlib import Path

import numpy as np

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.darkness import why_black
from restir_gi.reference.cli.opening import open_frames
from restir_gi.reference.cli.targets import check_file
from restir_gi.reference.cli.values import MOST_SAMPLES, whole
from restir_gi.reference.images.display import auto_exposure, write_png
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image, to_image
from restir_gi.reference.methods import (
    Layers,
    Method,
    drive,
    method_named,
    method_names,
)
from restir_gi.reference.methods.discovery import BUILT_IN
from restir_gi.reference.methods.metadata import Words, header, metadata
from restir_gi.reference.methods.method import preset_values
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.reports.effects import planner_of, prepared_for_all
from restir_gi.reference.reports.timing import timed
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown
from restir_gi.reference.transport.world import World, build_world


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    count = whole(1, MOST_SAMPLES)
    options.add_scene(parser)
    parser.add_argument("--method", required=True, metavar="M", help="see below")
    parser.epilog = "methods:\n" + "\n".join(map(_described, method_names()))
    options.add_out(parser)
    parser.add_argument("--frames", type=count, metavar="F", help="of reuse over time")
    parser.add_argument("--spp", type=count, metavar="N", help="samples a pixel")
    options.add_light(parser)
    parser.add_argument(
        "--aov",
        type=lambda text: tuple(dict.fromkeys(text.split(","))),
        default=(),
        metavar="NAME,...",
        help="further layers of the file; an unknown name lists those of the method",
    )
    options.add_preset(parser)
    options.add_set(parser, "a setting of the method; an unknown key lists them all")
    parser.add_argument(
        "--no-plan",
        action="store_true",
        help="run everything, also what the scene does not require (see restir plan)",
    )
    options.add_schedule(parser)
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Render, and write the picture.

    Raises UsageError: bad input, all of it found before the first ray but a full disk.
    """
    method = method_named(arguments.method)
    preset = preset_values(method, arguments.preset)
    settings = with_values(method.settings, (*preset, *arguments.set))
    counts = _counts(method, arguments)
    aovs = _aovs(method, arguments.aov)
    out, png = arguments.out, arguments.out.with_suffix(".png")
    if arguments.png:
        check_file(png, ".png")
    animation = open_frames(arguments)

    if arguments.no_plan:
        animation = prepared_for_all(animation)
    scene = animation(0)
    world = build_world(scene, planner=planner_of(arguments.no_plan))
    job = options.job(arguments, world, counts, settings, aovs, animation)
    with progress(f"{scene.name}, {method.name}") as tick:
        layers, seconds = timed(
            lambda: drive(method, job, lambda p: tick(p.done, p.total, p.unit))
        )
    words = metadata(scene, method, job, world.caster.counts, seconds)
    write_exr(out, _image(method, layers, world, words))
    if arguments.png:
        color = to_image(layers["color"], world.camera.width, world.camera.height)
        write_png(png, color, auto_exposure(color))
    black = None if np.any(layers["color"]) else why_black(job)
    _report(arguments, out, png, words, layers, black)


def _described(name: str) -> str:
    # Methods of other packages are imported when they are asked for, not before.
    summary = BUILT_IN[name].summary if name in BUILT_IN else "of another package"
    return f"  {name:20} {summary}"


def _image(method: Method, layers: Layers, world: World, words: Words) -> Image:
    width, height = world.camera.width, world.camera.height
    try:
        return Image(
            {name: to_image(rows, width, height) for name, rows in layers.items()},
            header(words),
        )
    except (ValueError, AttributeError) as error:
        raise UsageError(
            f"method {method.name!r} did not return a picture ({error}); repair it"
        ) from error


def _counts(method: Method, arguments: argparse.Namespace) -> dict[str, int]:
    given = {
        name: getattr(arguments, name)
        for name in ("frames", "spp")
        if getattr(arguments, name) is not None
    }
    for name in given.keys() - method.counts.keys():
        heeds = " and ".join(f"--{name}" for name in method.counts) or "neither"
        raise UsageError(f"method {method.name!r} has no --{name}; it takes {heeds}")
    return {**method.counts, **given}


def _aovs(method: Method, names: tuple[str, ...]) -> tuple[str, ...]:
    known = ("color", *method.aovs)
    for name in names:
        if name not in known:
            raise UsageError(
                f"--aov: {unknown('layer', name, known)} (method {method.name!r})"
            )
    return tuple(name for name in names if name != "color")


def _report(
    arguments: argparse.Namespace,
    out: Path,
    png: Path,
    words: Words,
    layers: Layers,
    black: str | None,
) -> None:
    if arguments.json:
        emit(
            {
                "out": str(out),
                "png": str(png) if arguments.png else None,
                "layers": list(layers),
                "black": black,
                "metadata": words,
            }
        )
        return
    show(f"{out}: {words['method']} on {words['scene']}, {words['seconds']} s")
    if black is not None:
        show(f"Every pixel is black: {black}")
    if "biases" in words:
        show(f"Biased here by {words['biases']}")
