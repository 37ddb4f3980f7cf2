"""What a frame costs beside its rays: time ratios, threads, frame sizes, memory.

    python -m tests.benchmarks.bench_cost [rays] [threads] [size] [memory] [motion]
        [paths]

Prints medians of the ratios of turns; seconds belong to a machine.
"""

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from restir_gi.extensions.area_restir import render_area_frames
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.pt_settings import CRITERIA, PathSettings
from restir_gi.extensions.restir_pt import render_path_frames
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.reports.timing import seconds_in_turns, time_ratio
from restir_gi.reference.restir_gi import Frame, next_frame, render_frames
from restir_gi.reference.scene.animation import Animation, Changes
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_animation, find_scene
from restir_gi.reference.scene.catalogue.rooms import cornell_box
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.settings import BIASED, UNBIASED, Settings
from restir_gi.reference.transport.world import World, build_world, next_world
from tests.benchmarks.scenes import bumpy_box, sized

MODULE = "tests.benchmarks.bench_cost"
WARM = 31  # the frame after the 32 of the paper; every pixel then tries few neighbours


class Recorder:
    """Stands in for the accelerator and keeps every batch of rays."""

    def __init__(self, embree: Any) -> None:
        self.embree, self.batches = embree, list[tuple[Any, ...]]()

    def run(self, o: Any, d: Any, **options: Any) -> Any:
        """Trace a batch and keep it."""
        # Without the rows that are passed over: a renderer would not ask for them.
        rows = np.flatnonzero(options["dists"] >= 0)
        dists = options["dists"][rows]
        self.batches.append((o[rows], d[rows], {**options, "dists": dists}))
        return self.embree.run(o, d, **options)

    @property
    def rays(self) -> int:
        """How many were kept."""
        return sum(len(o) for o, _, _ in self.batches)

    def replay(self) -> None:
        """Trace all batches again."""
        for o, d, options in self.batches:
            # The distances are overwritten by a run.
            self.embree.run(o, d, **{**options, "dists": options["dists"].copy()})


def warmed(
    world: World, settings: Settings, schedule: Schedule
) -> tuple[Frame, Callable[[], Frame]]:
    """A frame in the steady state, and how to make the one after it."""
    frames = render_frames(world, settings, 1, 0, schedule)
    frame = next(f for f in frames if f.number == WARM)

    def step() -> Frame:
        return next_frame(following(frame, world, frame.visible, settings), frame)

    return frame, step


def following(
    last: Frame,
    world: World,
    visible: VisiblePoints,
    settings: Settings,
    changes: Changes = "nothing",
) -> FrameContext[Settings]:
    return FrameContext(
        number=last.number + 1,
        world=world,
        visible=visible,
        settings=settings,
        bounces=1,
        seed=0,
        schedule=Schedule(),
        changes=changes,
    )


def in_turns(*calls: Callable[[], object]) -> list[list[float]]:
    """Seconds of each, in each turn."""
    return list(seconds_in_turns(dict(enumerate(calls))).values())


def ratio(above: list[float], below: list[float]) -> str:
    found = time_ratio(above, below)
    return f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]"


def against_the_first(calls: Mapping[str, Callable[[], object]]) -> dict[str, str]:
    """Ratio of the time of each to that of the first."""
    times = seconds_in_turns(calls)
    first = next(iter(times.values()))
    return {label: ratio(seconds, first) for label, seconds in times.items()}


def frame_against_rays() -> Iterator[str]:
    for scene in (cornell_box(), bumpy_box()):
        world = build_world(sized(scene, 512, 512))
        pixels = 512 * 512
        for name, settings in (("unbiased", UNBIASED), ("biased", BIASED)):
            _, step = warmed(world, settings, Schedule())
            triangles = world.caster._triangles
            recorder = Recorder(triangles._embree)
            triangles._embree = recorder  # type: ignore[assignment]
            step()
            triangles._embree = recorder.embree
            rays = recorder.rays / pixels
            whole, alone = in_turns(step, recorder.replay)
            yield (
                f"{scene.name:12} {name:9} {median(whole) / pixels * 1e6:6.2f} us/pixel"
                f" = {ratio(whole, alone)} x its {rays:.1f} rays"
            )


def threads() -> Iterator[str]:
    world = build_world(sized(cornell_box(), 512, 512))
    _, one = warmed(world, UNBIASED, Schedule(threads=1))
    _, two = warmed(world, UNBIASED, Schedule(threads=2))
    yield f"two threads are {ratio(*in_turns(one, two))} x faster than one"


def sizes() -> Iterator[str]:
    steps, pixels = [], []
    for width, height in ((256, 256), (1920, 1080)):
        world = build_world(sized(cornell_box(), width, height))
        steps.append(warmed(world, UNBIASED, Schedule())[1])
        pixels.append(width * height)
    small, large = in_turns(*steps)
    each = [seconds * pixels[0] / pixels[1] for seconds in large]
    yield f"a pixel at 1920x1080 takes {ratio(each, small)} x one at 256x256"


def motion() -> Iterator[str]:
    """What a frame pays for what may move, and for what does move."""
    still = sized(cornell_box(), 256, 256)
    names = ("moving-camera", "moving-block", "moving-light")
    steps: dict[str, Callable[[], Frame]] = {
        "nothing can move": warmed(build_world(still), UNBIASED, Schedule())[1]
    }
    for name in names:
        animation = find_animation(name, sized(find_scene(name), 256, 256))
        for moves in (False, True):
            label = f"{name}, in motion" if moves else f"{name}, at rest"
            steps[label] = one_more(animation, moves)
    for label, times in against_the_first(steps).items():
        yield f"{label:25} {times} x the time of a frame"


def one_more(animation: Animation, moves: bool) -> Callable[[], Frame]:
    """The frame after the steady state of an animation, or of its first frame."""
    first = animation(0)
    run = animation if moves else Animation(lambda _: first, animation.changes)
    world = build_world(run(0))
    frames = render_frames(world, UNBIASED, 1, 0, Schedule(), run)
    last = next(f for f in frames if f.number == WARM)
    now = next_world(last.world, run(WARM + 1))
    x, y = pixel_centers(now.camera.width, now.camera.height)
    visible = visible_points(now, x, y) if moves else last.visible

    def step() -> Frame:
        return next_frame(following(last, now, visible, UNBIASED, run.changes), last)

    return step


def paths() -> Iterator[str]:
    """What whole paths cost more than points, where points would do."""
    world = build_world(sized(cornell_box(), 256, 256))
    few = replace(UNBIASED, iterations_few=3, iterations_many=3)
    runs: dict[str, Iterator[Any]] = {
        "restir-gi-unbiased": render_frames(world, few, 1, 0, Schedule())
    }
    for kind in CRITERIA:
        settings = PathSettings(shift=kind, neighbors=3)
        frames = render_path_frames(world, settings, 1, 0, Schedule())
        runs[f"restir-pt, {kind}"] = frames
    area = render_area_frames(world, AreaSettings(neighbors=3), 1, 0, Schedule())
    runs["area-restir"] = area
    for frames in runs.values():
        for _ in range(3):
            next(frames)
    calls = {label: frames.__next__ for label, frames in runs.items()}
    for label, times in against_the_first(calls).items():
        yield f"{label:25} {times} x the time of ReSTIR GI"


def memory() -> Iterator[str]:
    # In processes of their own: the peak of a process never falls.
    peak = {}
    for width, height in ((64, 36), (1920, 1080), (3840, 2160)):
        command = [sys.executable, "-m", MODULE, "--peak", str(width), str(height)]
        answer = subprocess.run(command, check=True, capture_output=True, text=True)
        peak[width * height] = int(answer.stdout)
    (few, low), *others = peak.items()
    for many, high in others:
        each = (high - low) / (many - few)
        yield (
            f"peak memory {high / 2**30:.2f} GiB, {each:.0f} bytes of each of {many}"
            " pixels"
        )


def print_peak(width: int, height: int) -> None:
    world = build_world(sized(cornell_box(), width, height))
    x, y = pixel_centers(8, 8)
    visible_points(world, x, y)
    for frame in render_frames(world, UNBIASED, 1, 0, Schedule()):
        if frame.number == 3:
            break
    # Not ru_maxrss: a child inherits its parent's.
    status = Path("/proc/self/status").read_text()
    print(int(status.split("VmHWM:")[1].split()[0]) * 1024)


PARTS = {
    "rays": frame_against_rays,
    "threads": threads,
    "size": sizes,
    "memory": memory,
    "motion": motion,
    "paths": paths,
}

if __name__ == "__main__":
    if sys.argv[1:2] == ["--peak"]:
        print_peak(int(sys.argv[2]), int(sys.argv[3]))
    else:
        for part in sys.argv[1:] or PARTS:
            for line in PARTS[part]():
                print(line, flush=True)
