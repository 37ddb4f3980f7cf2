"""``restir tradeoff``: speed against accuracy, measured, and what to take."""

import argparse

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.opening import open_named
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import MOST_SAMPLES, MOST_SEED, amount, whole
from restir_gi.reference.methods import Job, method_named
from restir_gi.reference.methods.method import preset_values
from restir_gi.reference.methods.path import PathTracerSettings
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.tradeoff.change import points_after_change, recoveries
from restir_gi.reference.reports.tradeoff.design import (
    at_random,
    methods_beside,
    one_at_a_time,
)
from restir_gi.reference.reports.tradeoff.knobs import (
    Knob,
    built_in_knobs,
    knobs_of,
    usable,
)
from restir_gi.reference.reports.tradeoff.page import write_results
from restir_gi.reference.reports.tradeoff.points import Design, settings_of
from restir_gi.reference.reports.tradeoff.report import as_plain, table
from restir_gi.reference.reports.tradeoff.results import Results
from restir_gi.reference.reports.tradeoff.store import open_store
from restir_gi.reference.reports.tradeoff.sweep import (
    Sweep,
    pixel_of,
    pixels_of,
    run_sweep,
    scores_of,
)
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.fingerprint import fingerprint
from restir_gi.reference.scene.named import Named
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder
from restir_gi.reference.system.version import project_version
from restir_gi.reference.system.workers import processors, workers
from restir_gi.reference.transport.accumulate import Pixel
from restir_gi.reference.transport.world import build_world, next_world
from restir_gi.reference.truth.truth import accumulate_truth

METHOD = "restir-gi-unbiased"
SIDE = 64
RUNS, FRAMES, DESIGN, SAMPLES = 32, 16, 16, 4096
TRUTH_SEED = 1_000_003
EVERY = 30.0  # seconds between checkpoints of the truth


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    count = whole(1, MOST_SAMPLES)
    options.add_scene(parser)
    parser.add_argument(
        "--out",
        type=new_folder,
        required=True,
        metavar="DIR",
        help="folder for page, numbers and runs; goes on from the runs that are there",
    )
    parser.add_argument(
        "--method",
        default=METHOD,
        metavar="M",
        help=f"whose knobs are turned (default {METHOD})",
    )
    options.add_preset(parser)
    options.add_set(parser, "a setting of the base, from which all begins")
    parser.add_argument(
        "--sweep",
        action="append",
        default=[],
        metavar="KEY=VALUE,...",
        help="turn this knob, in place of all that are built in",
    )
    parser.add_argument(
        "--design",
        type=whole(0, 4096),
        default=DESIGN,
        metavar="N",
        help=f"further settings with all knobs turned at once (default {DESIGN})",
    )
    parser.add_argument(
        "--runs",
        type=whole(3, 4096),
        default=RUNS,
        metavar="N",
        help=f"of each setting, with different seeds (default {RUNS})",
    )
    parser.add_argument(
        "--frames",
        type=count,
        default=FRAMES,
        metavar="F",
        help=f"of a run; the last is looked at, the last half timed (default {FRAMES})",
    )
    parser.add_argument(
        "--spp",
        type=whole(2, MOST_SAMPLES),
        default=SAMPLES,
        metavar="N",
        help=f"samples a pixel of the truth (default {SAMPLES})",
    )
    options.add_bounces(parser, 1)
    parser.add_argument(
        "--seed",
        type=whole(0, MOST_SEED - 4096),
        default=0,
        metavar="S",
        help="of the first run, and of what is turned at once (default 0)",
    )
    parser.add_argument(
        "--for-error",
        type=amount,
        metavar="PERCENT",
        help="error that is allowed, of the mean light (default: that of the base)",
    )
    parser.add_argument(
        "--for-time",
        type=amount,
        metavar="MS",
        help="time that a frame may take on one thread (default: that of the base)",
    )
    options.add_workers(parser)
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Measure, and write the page.

    Raises UsageError: bad input, all of it found before the first ray but a full disk.
    """
    method = method_named(arguments.method)
    preset = preset_values(method, arguments.preset)
    base = Design(arguments.method, (*preset, *arguments.set))
    if method.frames is None:
        raise UsageError(
            f"method {base.method!r} does not make frames one by one; name another"
        )
    settings_of(base)
    named, animation = open_named(arguments, lambda scene: (SIDE, SIDE))
    sweep = _sweep(arguments, base, named, animation)
    make_folder(arguments.out)
    identity = _identity(sweep, animation(0))
    store = open_store(arguments.out / "runs", identity)
    processes = arguments.processes or processors()
    with workers(processes, arguments.scheduler) as executor:
        truths = {
            pixel: _truth(arguments, sweep, animation, pixel)
            for pixel in pixels_of(sweep.points)
        }
        with progress(f"{named.name}, settings") as tick:
            run_sweep(sweep, store, executor, tick)
    results = Results(
        sweep,
        truths[pixel_of(base)],
        scores_of(sweep, store, truths),
        recoveries(sweep, store, truths),
        arguments.for_error,
        arguments.for_time,
    )
    write_results(arguments.out, results, store)
    if arguments.json:
        emit(as_plain(results))
        return
    show(table(results))
    show(results.advice)
    show(f"Look at {arguments.out / 'index.html'}.")


def _sweep(
    arguments: argparse.Namespace, base: Design, named: Named, animation: Animation
) -> Sweep:
    method = method_named(base.method)
    if arguments.sweep:
        knobs: tuple[Knob, ...] = knobs_of(arguments.sweep)
        others: list[Design] = []
    else:
        built_in = built_in_knobs(animation.changes, arguments.bounces)
        knobs, others = usable(built_in, method), methods_beside(base)
    points = [
        base,
        *one_at_a_time(base, knobs),
        *others,
        *at_random(base, knobs, arguments.design, arguments.seed),
    ]
    for point in points:
        settings_of(point)
    still = animation.changes == "nothing"
    changed = points_after_change(base, method) if still else ()
    return Sweep(
        named,
        arguments.bounces,
        arguments.frames,
        arguments.runs,
        arguments.seed,
        tuple(points),
        changed if not arguments.sweep else (),
    )


def _identity(sweep: Sweep, scene: Scene) -> dict[str, str]:
    named = sweep.named
    return {
        "version": project_version(),
        "scene": f"{scene.name} {fingerprint(scene)[:16]}",
        "size": f"{named.width}x{named.height}",
        "frame": str(named.frame),
        "bounces": str(sweep.bounces),
        "frames": str(sweep.frames),
    }


def _truth(
    arguments: argparse.Namespace, sweep: Sweep, animation: Animation, pixel: Pixel
) -> Moments:
    """Of the frame that is looked at, the last of a run."""
    scene = animation(sweep.frames - 1)
    first = build_world(animation(0))
    job = Job(
        world=next_world(first, scene),
        light="indirect",
        bounces=sweep.bounces,
        seed=TRUTH_SEED,
        counts={"spp": arguments.spp},
        settings=PathTracerSettings(pixel=pixel),
        aovs=(),
        schedule=Schedule(threads=processors()),
    )
    checkpoint = arguments.out / f"truth-{pixel}.checkpoint"
    with progress(f"{sweep.named.name}, truth") as tick:
        return accumulate_truth(scene, job, checkpoint, EVERY, tick).moments
