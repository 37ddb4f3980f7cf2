"""Variants by turns, frame after frame, as many copies of each as take one time."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from reference.accumulate import path_samples
from reference.arrays import Scalars
from reference.figures.contest import PATH_SEED
from reference.figures.record import Work
from reference.moments import Moments, add_samples, no_samples
from reference.scene.animation import Animation
from reference.schedule import Schedule
from reference.world import World, next_world

FRAMES, COUNTED = 16, 4
"""Frames of a run, of which the last is looked at; and those whose time counts."""

TRIAL = 6
"""Frames by which the time of one is measured, before copies are made."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What is rendered.

    Attributes
    ----------
    world : World; in frame 0
    bounces : int; of indirect light
    animation : Animation or None; of a camera that moves
    """

    name: str
    world: World
    bounces: int
    animation: Animation | None = None

    @property
    def shown(self) -> World:
        """The world in the last frame."""
        if self.animation is None:
            return self.world
        return next_world(self.world, self.animation(FRAMES - 1))


class Estimated(Protocol):
    """A frame with ``estimates``."""

    @property
    def estimates(self) -> Scalars:
        """(N, 9): pixels, and differences to the right and down."""


Render = Callable[..., Iterator[Estimated]]


@dataclass(frozen=True, slots=True, eq=False)
class Variant:
    """A method with its settings.

    Attributes
    ----------
    render : callable; as `render_gradient_frames`
    """

    render: Render
    settings: object

    def frames(
        self, scene: Scene, seed: int, schedule: Schedule
    ) -> Iterator[Estimated]:
        """Frames of a run, without end."""
        about = scene.world, self.settings, scene.bounces, seed, schedule
        return self.render(*about, scene.animation)


@dataclass(frozen=True, slots=True, eq=False)
class Rounds:
    """What runs by turns leave behind.

    Attributes
    ----------
    scene : Scene; what was rendered
    estimates : dict of str to list of (N, 9) float64
        Last frame of each run, a mean over the copies.
    seconds : dict of str to float; a frame of one copy takes: the median
    truth : Moments; path-traced, over the areas of pixels
    """

    scene: Scene
    estimates: dict[str, list[Scalars]]
    copies: dict[str, int]
    seconds: dict[str, float]
    truth: Moments

    def spent(self, name: str) -> float:
        """Seconds that a frame of all copies takes."""
        return self.copies[name] * self.seconds[name]


def by_rounds(
    scene: Scene, variants: Mapping[str, Variant], work: Work, paths: int, like: str
) -> Rounds:
    """Run all variants by turns; copy c of run i has seed i · copies + c.

    Parameters
    ----------
    paths : int; path-traced samples a run
    like : str
        The variant of which one copy runs; of each other one as many as take about its
        time.  Empty for one copy each.
    """
    copies = dict.fromkeys(variants, 1)
    if like:
        trial = _trial(scene, variants, work)
        copies = {k: max(1, round(trial[like] / t)) for k, t in trial.items()}
    truth, samples = no_samples(scene.world.camera.width * scene.world.camera.height), 0
    drawn = path_samples(
        scene.shown,
        work.schedule,
        light="indirect",
        bounces=scene.bounces,
        seed=PATH_SEED,
        pixel="box",
    )
    estimates: dict[str, list[Scalars]] = {name: [] for name in variants}
    times: dict[str, list[float]] = {name: [] for name in variants}
    for run in range(work.runs):
        work.tick(run, work.runs, "runs")
        running = {
            name: [
                v.frames(scene, run * copies[name] + c, work.schedule)
                for c in range(copies[name])
            ]
            for name, v in variants.items()
        }
        for frame in range(FRAMES):
            for name, some in running.items():
                found = []
                for one in some:
                    start = time.perf_counter()
                    found.append(next(one))
                    if frame >= FRAMES - COUNTED:
                        times[name].append(time.perf_counter() - start)
                if frame == FRAMES - 1:
                    mean = np.mean([f.estimates for f in found], axis=0)
                    estimates[name].append(mean)
        samples += paths
        truth = add_samples(truth, drawn.radiance, samples, work.schedule)
    work.tick(work.runs, work.runs, "runs")
    seconds = {name: float(np.median(spent)) for name, spent in times.items()}
    return Rounds(scene, estimates, copies, seconds, truth)


def _trial(
    scene: Scene, variants: Mapping[str, Variant], work: Work
) -> dict[str, float]:
    times: dict[str, list[float]] = {name: [] for name in variants}
    running = {
        name: v.frames(scene, PATH_SEED, work.schedule) for name, v in variants.items()
    }
    for _ in range(TRIAL):
        for name, frames in running.items():
            start = time.perf_counter()
            next(frames)
            times[name].append(time.perf_counter() - start)
    return {name: float(np.median(spent)) for name, spent in times.items()}
