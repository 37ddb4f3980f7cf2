"""``restir reference``: accumulate the path-traced truth and its standard error."""

import argparse
from contextlib import ExitStack

import numpy as np

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.opening import open_named
from restir_gi.reference.cli.targets import check_file
from restir_gi.reference.cli.values import MOST_SAMPLES, seconds, whole
from restir_gi.reference.images.display import auto_exposure, write_png
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.methods.metadata import Words, header, metadata
from restir_gi.reference.methods.path import PATH, PathTracerSettings
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.system.workers import workers
from restir_gi.reference.transport.world import build_world
from restir_gi.reference.truth.distributed import sampled_by
from restir_gi.reference.truth.truth import (
    accumulate_truth,
    checkpoint_beside,
    truth_image,
)

EVERY = 30.0  # seconds between checkpoints
TRUTH_SEED = 1_000_003  # another than anybody's first seeds
"""Default seed: another one than that of `render`, so that a picture is not compared
with its own samples."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    options.add_scene(parser)
    options.add_out(parser)
    parser.add_argument(
        "--spp",
        type=whole(2, MOST_SAMPLES),
        default=1024,
        metavar="N",
        help="samples a pixel (default 1024)",
    )
    options.add_light(parser, seed=TRUTH_SEED)
    options.add_set(parser, "a setting of the method path: pixel=center or pixel=box")
    parser.add_argument(
        "--checkpoint",
        type=seconds,
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
    options.add_scheduler(parser)
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Accumulate, and write the mean and its standard error.

    Raises UsageError: bad input, all of it found before the first ray but a full disk.
    """
    settings = with_values(PathTracerSettings(), arguments.set)
    out = arguments.out
    if arguments.png:
        check_file(out.with_suffix(".png"), ".png")
    named, animation = open_named(arguments)
    scene = animation(0)
    job = options.job(
        arguments, build_world(scene), {"spp": arguments.spp}, settings, (), animation
    )
    checkpoint = checkpoint_beside(out)
    with progress(f"{scene.name}, truth") as tick, ExitStack() as stack:
        source_of = None
        if arguments.scheduler:
            cluster = stack.enter_context(workers(1, arguments.scheduler))
            source_of = sampled_by(cluster, named)
        state = accumulate_truth(
            scene, job, checkpoint, arguments.checkpoint, tick, source_of
        )
    words = metadata(scene, PATH, job, state.rays, state.seconds)
    image = truth_image(state, job, header(words))
    write_exr(out, image)
    if arguments.png:
        write_png(out.with_suffix(".png"), image.color, auto_exposure(image.color))
    if not arguments.keep:
        checkpoint.unlink(missing_ok=True)
    _report(arguments, words, image)


def _report(arguments: argparse.Namespace, words: Words, image: Image) -> None:
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
                "metadata": words,
            }
        )
        return
    show(
        f"{arguments.out}: {words['spp']} samples of {words['scene']},"
        f" {words['seconds']} s; standard error {error:.3g}, mean {mean:.3g}"
    )
