"""``restir check`` of a renderer of which nothing is known but its pictures."""

import argparse
import time
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import count
from typing import Any

from restir_gi.reference.cli.check_outputs import baseline_of, conclude
from restir_gi.reference.cli.console import Tick, progress, remark
from restir_gi.reference.cli.opening import size_in_shape
from restir_gi.reference.cli.values import (
    MOST_SAMPLES,
    amount,
    share,
    tiled_size,
    whole,
)
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance
from restir_gi.reference.oracle.blackbox.judge import (
    FIRST_SEED,
    PicturesVerdict,
    judge_pictures,
)
from restir_gi.reference.oracle.blackbox.renderer import AT_ONCE, Renderer
from restir_gi.reference.oracle.blackbox.tiles import TILES
from restir_gi.reference.oracle.cases import UnaskedError
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.reports.pictures.page import write_page
from restir_gi.reference.reports.pictures.plain import as_plain, head
from restir_gi.reference.reports.pictures.table import one_line, table
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.workers import ahead, workers
from restir_gi.reference.transport.accumulate import Pixel
from restir_gi.reference.transport.path_tracer import MAX_BOUNCES
from restir_gi.reference.truth.pictures import PictureTruths

SCENE = "cornell-box"
PIXELS = 64 * 64
AHEAD = 32  # pictures that others render before they are wanted
OF_PASSES = (
    "against",
    "case",
    "only",
    "skip",
    "require",
    "keep",
    "extremes",
    "declare",
    "accept",
    "quick",
)
"""Options that say nothing to a renderer, of which pictures alone are known."""


def add_picture_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments that renderers alone have."""
    group = parser.add_argument_group(
        "of a renderer of which pictures alone are known",
        "Its pictures are held against the path tracer's: radiance, linear, in the"
        " convention that these options name.",
    )
    group.add_argument(
        "--scene",
        default=SCENE,
        metavar="SCENE",
        help=f"what it renders: built-in or a file (default {SCENE})",
    )
    group.add_argument(
        "--light",
        choices=("indirect", "direct", "full"),
        default="indirect",
        help="what its pictures show (default indirect)",
    )
    group.add_argument(
        "--bounces",
        type=whole(1, MAX_BOUNCES),
        default=1,
        metavar="K",
        help="of indirect light (default 1)",
    )
    group.add_argument(
        "--pixel",
        choices=("center", "box"),
        help="camera rays through the centres of pixels, as a G-buffer has them"
        " (default), or anywhere in them, as renderers with anti-aliasing have them",
    )
    group.add_argument(
        "--frames",
        type=whole(1, MOST_SAMPLES),
        default=8,
        metavar="F",
        help="from an empty history to the picture (default 8)",
    )
    group.add_argument(
        "--frame",
        type=whole(0, MOST_SAMPLES),
        default=0,
        metavar="T",
        help="of an animated scene the frame that the pictures show (default 0)",
    )
    group.add_argument(
        "--size",
        type=tiled_size,
        metavar="WxH",
        help="pixels of its pictures, multiples of 4; one number for a square"
        f" (default: the shape of the scene's camera, about {PIXELS} pixels)",
    )
    group.add_argument(
        "--layer",
        metavar="NAME",
        help="which picture of a file of several, such as Combined",
    )
    group.add_argument(
        "--tolerance",
        type=share,
        default=Tolerance().whole,
        metavar="E",
        help="PASS is: the mean is off by less (default 1%%)",
    )
    group.add_argument(
        "--tile-tolerance",
        type=share,
        default=Tolerance().tile,
        metavar="E",
        help="and so is that of each of the 4x4 tiles (default 5%%)",
    )
    group.add_argument(
        "--bound",
        type=amount,
        metavar="B",
        help="your word that no tile's mean in one picture exceeds B times its truth",
    )
    group.add_argument(
        "--jobs",
        type=whole(1, 1024),
        default=1,
        metavar="N",
        help="calls at the same time (default 1)",
    )


def judge_renderer(arguments: argparse.Namespace) -> int:
    """Judge the renderer, and tell the verdict.

    Exit code: 0 pass, 1 fail, 3 undecided.

    Raises UsageError: there is no such program or scene, or the report of a renderer
    that is not known to be wrong cannot be written.
    """
    name = arguments.backend
    for option in OF_PASSES:
        if getattr(arguments, option):
            raise UsageError(
                f"--{option} is for passes, and a renderer has none; leave it out"
            )
    with progress("check") as tick:
        judged = _Judging(arguments, tick)
        baseline = baseline_of(arguments, "pictures", judged.asked)
        try:
            verdict = judged.verdict()
        except UnaskedError:
            late = "there was no time to trace the truth; give a longer --budget"
            plain = head("UNDECIDED", name, late, judged.asked)
            return conclude(arguments, plain, baseline, one_line, None)
    plain = as_plain(verdict, name, judged.seconds, judged.asked)
    plain["left_running"] = judged.left_running
    return conclude(
        arguments, plain, baseline, table, lambda out: write_page(out, verdict, plain)
    )


def _pixel(arguments: argparse.Namespace) -> Pixel:
    """Where in a pixel camera rays begin, as asked for or declared.

    Raises UsageError: both, and they differ.
    """
    if arguments.declaration is None:
        asked: Pixel = arguments.pixel or "center"
        return asked
    said = read_declaration(arguments.declaration)
    if said.hypotheses or said.has:
        remark(f"of pictures {arguments.declaration} says pixel, and nothing else")
    if arguments.pixel not in (None, said.pixel):
        raise UsageError(
            f"--pixel is {arguments.pixel}, and {arguments.declaration} says"
            f" {said.pixel}; leave one out"
        )
    return said.pixel


class _Judging:
    """One renderer, and the clock."""

    def __init__(self, arguments: argparse.Namespace, tick: Tick) -> None:
        self._start, self._tick, self._arguments = time.monotonic(), tick, arguments
        scene = find_scene_or_file(
            arguments.scene, arguments.lenient, arguments.allow_outside
        )
        size = arguments.size or size_in_shape(scene.camera, PIXELS, TILES)
        named = Named(
            name=arguments.scene,
            lenient=arguments.lenient,
            width=size[0],
            height=size[1],
            frame=arguments.frame,
            allow_outside=arguments.allow_outside,
        )
        pixel = _pixel(arguments)
        self._convention = Convention(arguments.light, arguments.bounces, pixel)
        self.asked = {
            "scene": arguments.scene,
            "frame": arguments.frame,
            "frames": arguments.frames,
            "size": list(size),
            "light": arguments.light,
            "bounces": arguments.bounces,
            "pixel": pixel,
            "layer": arguments.layer,
            "bound": arguments.bound,
        }
        self._tolerance = Tolerance(arguments.tolerance, arguments.tile_tolerance)
        self._truths = PictureTruths(
            scene=frames_of(named, scene)(0),
            size=size,
            asked=self._convention,
            tolerance=self._tolerance,
            remaining=self.remaining,
            tell=lambda what: tick(0, 1, what),
        )
        limits = Limits(arguments.limit)
        self._about = arguments.backend, arguments.scene, arguments.frames, size, limits
        self._here = Renderer(*self._about, self.remaining, layer=arguments.layer)

    @property
    def seconds(self) -> float:
        """Since the beginning."""
        return time.monotonic() - self._start

    @property
    def left_running(self) -> int:
        """Processes that the renderer left, and that were ended."""
        return sum(self._here.left_running)

    def remaining(self) -> float:
        """Seconds that are left."""
        return float(self._arguments.budget - self.seconds)

    def verdict(self) -> PicturesVerdict:
        """Render until it is decided or the time is over."""
        with ExitStack() as stack:
            return judge_pictures(
                self._pictures(stack),
                self._truths,
                self._convention,
                self._tolerance,
                self._arguments.bound,
                tell=lambda count: self._tick(0, 1, f"picture {count}"),
            )

    def _pictures(self, stack: ExitStack) -> Iterator[Any]:
        """Pictures of the seeds in their order, made here or by other processes."""
        scheduler, jobs = self._arguments.scheduler, self._arguments.jobs
        if not scheduler and jobs == 1:
            yield from self._here.pictures(count(FIRST_SEED))
            return
        executor = stack.enter_context(workers(jobs, scheduler))
        # Whose machines have clocks of their own.
        remote = Renderer(*self._about, layer=self._arguments.layer)
        length = AT_ONCE if remote.makes_several else 1
        lists = (range(k, k + length) for k in count(FIRST_SEED, length))
        ready = AHEAD if scheduler else jobs
        made = ahead(executor, remote.render_several, lists, ready, self.remaining)
        for some in made:
            yield from some
            if self.remaining() <= 0:
                return
