"""Options that several commands share."""

import argparse
from collections.abc import Mapping
from typing import Any

from restir_gi.reference.cli.targets import new_file
from restir_gi.reference.cli.values import MOST_SAMPLES, MOST_SEED, size, whole
from restir_gi.reference.methods import Job
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.system.workers import processors
from restir_gi.reference.transport.path_tracer import MAX_BOUNCES
from restir_gi.reference.transport.world import World

BAND = Schedule().band
BANDS_A_THREAD = 2  # at least: threads then end nearly together

Parser = argparse.ArgumentParser


def add_scene(parser: Parser, **options: str) -> None:
    """Add SCENE, how it is read, and which frame of it is meant.

    Parameters
    ----------
    **options : str; ``nargs`` and ``default`` of the positional argument
    """
    parser.add_argument(
        "scene",
        metavar="SCENE",
        help="built-in scene, or a glTF, GLB, OBJ, PLY, Mitsuba XML or JSON file",
        **options,  # type: ignore[arg-type]
    )
    add_reading(parser)
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels")
    parser.add_argument(
        "--frame",
        type=whole(0, MOST_SAMPLES),
        default=0,
        metavar="T",
        help="of an animated scene the frame to begin at (default 0)",
    )


def add_reading(parser: Parser) -> None:
    """Add how a scene file is read: --lenient, --allow-outside."""
    parser.add_argument(
        "--lenient",
        action="store_true",
        help="replace what a scene file holds and is not modelled, and say so",
    )
    parser.add_argument(
        "--allow-outside",
        action="store_true",
        help="read files outside the scene's folder, if it names them",
    )


def add_light(parser: Parser, seed: int = 0) -> None:
    """Add what is estimated: --light, --bounces, --seed."""
    parser.add_argument(
        "--light",
        choices=("indirect", "direct", "full"),
        default="indirect",
        help="which paths count (default indirect)",
    )
    add_bounces(parser, 0)
    parser.add_argument(
        "--seed",
        type=whole(0, MOST_SEED),
        default=seed,
        metavar="S",
        help=f"runs of different seeds are independent (default {seed})",
    )


def add_bounces(parser: Parser, least: int) -> None:
    """Add --bounces.

    Parameters
    ----------
    least : int; number allowed
    """
    parser.add_argument(
        "--bounces",
        type=whole(least, MAX_BOUNCES),
        default=1,
        metavar="K",
        help=f"bounces of indirect light, {least} to {MAX_BOUNCES} (default 1)",
    )


def add_preset(parser: Parser) -> None:
    """Add --preset NAME, beneath what --set says."""
    parser.add_argument(
        "--preset",
        metavar="NAME",
        help="settings that go together, before --set: such as paper, rtxdi or"
        " restir_pt of ReSTIR GI; an unknown name lists those of the method",
    )


def add_set(parser: Parser, help: str) -> None:
    """Add --set KEY=VALUE, as often as wanted."""
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help=help
    )


def add_schedule(parser: Parser) -> None:
    """Add --threads and --band, which change no bit of a result."""
    parser.add_argument(
        "--threads",
        type=whole(1, 1024),
        metavar="N",
        help="bands worked on at once (default: all processors)",
    )
    parser.add_argument(
        "--band",
        type=whole(1, 2**28),
        metavar="ROWS",
        help=f"pixels worked on together (default: up to {BAND})",
    )


def add_workers(parser: Parser) -> None:
    """Add --processes and --scheduler: who does the work."""
    parser.add_argument(
        "--processes",
        type=whole(1, 1024),
        metavar="N",
        help="runs done at once on this machine (default: all processors)",
    )
    add_scheduler(parser)


def add_scheduler(parser: Parser) -> None:
    """Add --scheduler: a cluster that does the work."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a Dask cluster that does the work, such as tcp://127.0.0.1:8786",
    )


def add_json(parser: Parser) -> None:
    """Add --json."""
    parser.add_argument(
        "--json",
        action="store_true",
        help="results as JSON, and nothing else, on stdout",
    )


def add_out(parser: Parser) -> None:
    """Add --out X.exr and --png."""
    parser.add_argument(
        "--out", type=new_file(), required=True, metavar="X.exr", help="the picture"
    )
    parser.add_argument(
        "--png", action="store_true", help="write a preview beside it, too"
    )


def schedule(arguments: argparse.Namespace, pixels: int) -> Schedule:
    """Bands and threads.

    By default each thread has several bands, so that none waits long for another.
    """
    threads = arguments.threads or processors()
    parts = BANDS_A_THREAD * threads if threads > 1 else 1
    band = arguments.band or max(256, min(BAND, -(-pixels // parts)))
    return Schedule(band, threads)


def job(
    arguments: argparse.Namespace,
    world: World,
    counts: Mapping[str, int],
    settings: Any,
    aovs: tuple[str, ...],
    animation: Animation,
) -> Job:
    """Put together what to render.

    Parameters
    ----------
    world : World; the scene of ``animation`` in frame 0
    animation : Animation; from frame ``frame`` of the arguments on
    """
    return Job(
        world=world,
        light=arguments.light,
        bounces=arguments.bounces,
        seed=arguments.seed,
        counts=counts,
        settings=settings,
        aovs=aovs,
        schedule=schedule(arguments, world.camera.width * world.camera.height),
        animation=animation,
        frame=arguments.frame,
    )
