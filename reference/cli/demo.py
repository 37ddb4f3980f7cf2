"""``restir demo``: path tracing, biased and unbiased ReSTIR GI, against the truth."""

import argparse
from dataclasses import asdict, replace

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.darkness import why_black
from restir_gi.reference.cli.opening import open_frames, size_in_shape
from restir_gi.reference.cli.reference import EVERY, TRUTH_SEED
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import MOST_SAMPLES, whole
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.methods import method_named
from restir_gi.reference.methods.metadata import header, metadata
from restir_gi.reference.methods.path import PATH
from restir_gi.reference.reports.demo.gallery import write_gallery
from restir_gi.reference.reports.demo.page import table
from restir_gi.reference.reports.demo.runs import Runs, runs_of_frames, runs_of_paths
from restir_gi.reference.reports.demo.score import scores
from restir_gi.reference.scene.catalogue.registry import CATALOGUE
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.files import make_folder
from restir_gi.reference.transport.world import build_world, next_world
from restir_gi.reference.truth.truth import (
    accumulate_truth,
    checkpoint_beside,
    truth_image,
)

SCENE, SIZE = "door-ajar", (192, 144)
METHODS = ("restir-gi-biased", "restir-gi-unbiased")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""

    def add_count(name: str, least: int, most: int, default: int, of: str) -> None:
        parser.add_argument(
            name,
            type=whole(least, most),
            default=default,
            metavar="N",
            help=f"{of} (default {default})",
        )

    options.add_scene(parser, nargs="?", default=SCENE)
    parser.add_argument(
        "--out", type=new_folder, required=True, metavar="DIR", help="folder"
    )
    add_count("--spp", 2, MOST_SAMPLES, 2048, "samples a pixel of the truth")
    add_count("--frames", 1, MOST_SAMPLES, 32, "frames of ReSTIR GI")
    add_count("--runs", 2, 1000, 4, "runs of each method, with different seeds")
    options.add_bounces(parser, 1)
    options.add_schedule(parser)
    options.add_json(parser)
    parser.set_defaults(light="indirect", seed=0)


def run(arguments: argparse.Namespace) -> None:
    """Render, compare, and write the folder.

    Raises UsageError: bad input, or a file cannot be written.
    """
    out = arguments.out
    animation = open_frames(arguments, _quick)
    make_folder(out)
    world = build_world(animation(0))
    first = options.job(
        arguments, world, {"spp": arguments.spp}, PATH.settings, (), animation
    )
    # Paths are traced in the frame that methods which reuse samples arrive at.
    last = arguments.frames - 1
    scene = animation(last)
    paths = replace(first, world=next_world(world, scene), frame=arguments.frame + last)
    true_job = replace(paths, seed=TRUTH_SEED)

    checkpoint = checkpoint_beside(out / "truth.exr")
    with progress(f"{scene.name}, truth") as tick:
        state = accumulate_truth(scene, true_job, checkpoint, EVERY, tick)
    words = metadata(scene, PATH, true_job, state.rays, state.seconds)
    truth = truth_image(state, true_job, header(words))
    write_exr(out / "truth.exr", truth)

    with progress(f"{scene.name}, {arguments.runs} runs of each method") as tick:
        restir: list[Runs] = []
        for name in METHODS:
            tick(len(restir), len(METHODS) + 1, "methods")
            method = method_named(name)
            job = replace(
                first, counts={"frames": arguments.frames}, settings=method.settings
            )
            restir.append(runs_of_frames(method, job, arguments.runs))
        tick(len(restir), len(METHODS) + 1, "methods")
        traced = runs_of_paths(paths, restir[-1].seconds, arguments.runs)
    found = scores(state.moments, traced, restir)
    remarks = _remarks(arguments)
    black = None if truth.color.any() else why_black(true_job)
    if black is not None:
        remarks.append(f"Every pixel is black: {black}.")
    contenders = list(zip([traced, *restir], found, strict=True))
    write_gallery(out, scene, truth, contenders, remarks)
    checkpoint.unlink(missing_ok=True)
    if arguments.json:
        methods = [asdict(score) for score in found]
        emit(
            {
                "page": str(out / "index.html"),
                "scene": scene.name,
                "black": black,
                "methods": methods,
            }
        )
        return
    show(table(found, f"{scene.name}, {truth.width}x{truth.height}"))
    for remark in remarks:
        show(remark)
    show(f"Look at {out / 'index.html'}, or at the strip alone, {out / 'teaser.png'}.")


def _quick(scene: Scene) -> tuple[int, int]:
    """Size of a picture that is done in minutes, in the shape that the scene asks for.

    Built-in scenes ask for none: theirs is a square by default.
    """
    if scene.name in CATALOGUE:
        return SIZE
    return size_in_shape(scene.camera, SIZE[0] * SIZE[1])


def _remarks(arguments: argparse.Namespace) -> list[str]:
    return [
        f"Means over {arguments.runs} runs with different seeds. The time of ReSTIR GI"
        " is that of one frame at the end of a run; path tracing has as many samples as"
        " fit into the time of the unbiased one. Camera rays are not counted.",
        "MSE is against the truth, whose own noise is taken off. Times better: MSE"
        " times seconds of path tracing over that of the method.",
        "Bias of the mean: luminance of the whole picture over that of the truth, less"
        " 1, with its standard error.",
    ]
