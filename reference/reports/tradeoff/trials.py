"""One run of one operating point, measured: what a worker does."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from restir_gi.reference.methods import Job, Shown, method_named
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.tiles import tile_means
from restir_gi.reference.reports.timing import timed
from restir_gi.reference.reports.tradeoff.points import Design, settings_of
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.brightness import brightened
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import World, build_world

BEFORE = 4.0
"""How much brighter the lights were before a change."""


@dataclass(frozen=True, slots=True)
class Task:
    """A run to be measured.

    Attributes
    ----------
    bounces : int; of indirect light
    frames : int; from an empty history to the picture; time is taken of the second half
    change : int
        Frame from which on the lights are those of the scene, after they were
        `BEFORE` times as bright; 0 for a scene that is left alone.
    """

    named: Named
    bounces: int
    frames: int
    point: Design
    seed: int
    change: int = 0

    @property
    def counted(self) -> int:
        """Frames at the end, taken to be in the steady state."""
        return self.frames - self.frames // 2


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """What a run leaves behind.

    Attributes
    ----------
    color : (N, 3) float32, W/(m² sr); its last frame
    mean : (N, 3) float32, W/(m² sr); mean of the frames that are counted
    tiles : (frames, T, 3) float32, W/(m² sr); means of the tiles of all frames
    seconds : float; median time of those
    rays : dict of str to float; a pixel and frame, by kind
    kept : float; bytes a pixel from frame to frame
    """

    color: Vec3s
    mean: Vec3s
    tiles: Scalars
    seconds: float
    rays: dict[str, float]
    kept: float


def run_trial(task: Task) -> Trial:
    """Render, and look at the clock.

    Time on one thread; pixels, rays and bytes are the same on every machine.
    """
    world, animation = opened(task.named)
    if task.change:
        world, animation = _after_brighter_days(world, task.change)
    frames = _frames(task, world, animation)
    skipped = task.frames - task.counted
    seconds, tiles, mean = [], [], np.zeros(())
    for number in range(task.frames):
        if number == skipped:
            before = Counter(world.caster.counts)
        shown, spent = timed(frames.__next__)
        seconds.append(spent)
        tiles.append(tile_means(shown.color, task.named.width))
        if number >= skipped:
            mean = mean + (shown.color - mean) / (number - skipped + 1.0)
    traced = world.caster.counts - before
    shots = len(shown.color) * task.counted
    return Trial(
        shown.color.astype(np.float32),
        mean.astype(np.float32),
        np.array(tiles, np.float32),
        float(np.median(seconds[skipped:])),
        {kind: count / shots for kind, count in sorted(traced.items())},
        shown.kept,
    )


def _after_brighter_days(world: World, change: int) -> tuple[World, Animation]:
    now = world.scene
    then = brightened(now, BEFORE)
    animation = Animation(lambda t: now if t >= change else then, "scene")
    return build_world(then, world), animation


def _frames(task: Task, world: World, animation: Animation) -> Iterator[Shown]:
    method = method_named(task.point.method)
    if method.frames is None:
        raise UsageError(
            f"method {method.name!r} does not make frames one by one; measure another"
        )
    return method.frames(job_of(task, world, animation))


def job_of(task: Task, world: World, animation: Animation) -> Job:
    """What a method is asked to render.

    Parameters
    ----------
    world : World; of frame 0
    """
    return Job(
        world=world,
        light="indirect",
        bounces=task.bounces,
        seed=task.seed,
        counts={"frames": task.frames, "spp": task.frames},
        settings=settings_of(task.point),
        aovs=(),
        schedule=Schedule(),
        animation=animation if animation.changes != "nothing" else None,
        frame=task.named.frame,
    )


@lru_cache(maxsize=2)
def opened(named: Named) -> tuple[World, Animation]:
    """Frame 0 ready for rays, and all frames, kept for the next task of the process."""
    scene = find_scene_or_file(named.name, named.lenient, named.allow_outside)
    animation = frames_of(named, scene)
    return build_world(animation(0)), animation
