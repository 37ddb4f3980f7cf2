"""``restir reference``: accumulate the path-traced truth and its standard error."""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from reference.accumulate import path_samples
from reference.checkpoint import Checkpoint
from reference.commands import arguments as options
from reference.commands.console import emit, progress, show
from reference.commands.metadata import metadata
from reference.commands.opening import open_scene
from reference.commands.targets import check_file
from reference.display import auto_exposure, write_png
from reference.exr import write_exr
from reference.fingerprint import fingerprint
from reference.images import Image, to_image
from reference.methods.path import PathSettings
from reference.options import as_text, with_values
from reference.resumable import accumulate_resumably
from reference.scene.scene import Scene
from reference.version import project_version
from reference.world import World, build_world

NAME = "reference"
EVERY = 30.0  # seconds between checkpoints


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments.

    Parameters
    ----------
    parser : ArgumentParser
        Of this command.
    """
    options.add_scene(parser)
    options.add_out(parser)
    parser.add_argument(
        "--spp",
        type=options.whole(2, options.MOST_SAMPLES),
        default=1024,
        metavar="N",
        help="samples a pixel (default 1024)",
    )
    options.add_light(parser)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a setting of the method path: pixel=center or pixel=box",
    )
    parser.add_argument(
        "--checkpoint",
        type=options.seconds,
        default=EVERY,
        metavar="SECONDS",
        help=f"time between checkpoints (default {EVERY:g})",
    )
    parser.add_argument(
        "--keep",
        action="store_true",
        help="keep the checkpoint in the end: a larger --spp then goes on from it",
    )
    options.add_schedule(parser)
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Accumulate, and write the mean and its standard error.

    Parameters
    ----------
    arguments : Namespace
        Parsed.

    Raises
    ------
    UsageError
        Bad input, all of it found before the first ray but a full disk.
    """
    settings = with_values(PathSettings(), arguments.set)
    out = arguments.out
    check_file(out)
    if arguments.png:
        check_file(out.with_suffix(".png"), ".png")
    scene = open_scene(arguments)
    checkpoint = checkpoint_beside(out)
    world = build_world(scene)
    state = truth(scene, world, arguments, settings, checkpoint)
    words = metadata(
        scene, arguments, "path", as_text(settings), {"spp": arguments.spp},
        state.rays, state.seconds,
    )  # fmt: skip
    image = truth_image(state, world, words)
    write_exr(out, image)
    if arguments.png:
        write_png(out.with_suffix(".png"), image.color, auto_exposure(image.color))
    if not arguments.keep:
        checkpoint.unlink(missing_ok=True)
    _report(arguments, words, image)


def checkpoint_beside(out: Path) -> Path:
    """Where the checkpoint of a picture lies.

    Parameters
    ----------
    out : Path
        The picture.

    Returns
    -------
    Path
        In the same folder.
    """
    return out.with_name(out.name + ".checkpoint")


def truth(
    scene: Scene,
    world: World,
    arguments: argparse.Namespace,
    settings: PathSettings,
    checkpoint: Path,
) -> Checkpoint:
    """Accumulate the truth of a scene, with a checkpoint.

    Parameters
    ----------
    scene, world : Scene, World
        The scene, as it is and as it was built.
    arguments : Namespace
        With ``light``, ``bounces``, ``seed``, ``spp``, ``checkpoint`` and those of the
        schedule.
    settings : PathSettings
        Of path tracing.
    checkpoint : Path
        Of the checkpoint.

    Returns
    -------
    Checkpoint
        Complete.
    """
    width, height = scene.camera.width, scene.camera.height
    schedule = options.schedule_of(arguments, width * height)
    samples = path_samples(
        world,
        schedule,
        light=arguments.light,
        bounces=arguments.bounces,
        seed=arguments.seed,
        pixel=settings.pixel,
    )
    one = replace(scene, camera=replace(scene.camera, width=1, height=1), notes=())
    run_of = {
        "version": project_version(),
        "scene": f"{scene.name} {fingerprint(one)[:16]}",
        "size": f"{width}x{height}",
        "light": arguments.light,
        "bounces": str(arguments.bounces),
        "seed": str(arguments.seed),
        **as_text(settings),
    }
    with progress(f"{scene.name}, truth") as tick:
        return accumulate_resumably(
            samples,
            arguments.spp,
            schedule,
            checkpoint,
            run_of,
            arguments.checkpoint,
            lambda count: tick(count, arguments.spp, "samples"),
        )


def truth_image(state: Checkpoint, world: World, words: Mapping[str, str]) -> Image:
    """Mean and standard error as a picture.

    Parameters
    ----------
    state : Checkpoint
        Complete.
    world : World
        For the size.
    words : mapping of str to str
        Metadata.

    Returns
    -------
    Image
        Layers ``"color"`` and ``"standard_error"``.
    """
    size = world.camera.width, world.camera.height
    layers = {
        "color": to_image(state.moments.mean, *size),
        "standard_error": to_image(state.moments.standard_error(), *size),
    }
    return Image(layers, words)


def _report(
    arguments: argparse.Namespace, words: Mapping[str, str], image: Image
) -> None:
    error = float(np.sqrt(np.mean(image.layers["standard_error"] ** 2.0)))
    mean = float(np.mean(image.color))
    if arguments.json:
        png = str(arguments.out.with_suffix(".png")) if arguments.png else None
        emit(
            {
                "out": str(arguments.out),
                "png": png,
                "layers": list(image.layers),
                "mean": mean,
                "rms_standard_error": error,
                "metadata": dict(words),
            }
        )
        return
    show(
        f"{arguments.out}: {words['spp']} samples of {words['scene']},"
        f" {words['seconds']} s; standard error {error:.3g}, mean {mean:.3g}"
    )
