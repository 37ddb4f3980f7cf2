"""Variants by turns, frame after frame, as many copies of each as take one time."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from restir_gi.figures.contest import PATH_SEED
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.timing import in_turns, seconds_in_turns
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.transport.accumulate import ever_more, path_samples
from restir_gi.reference.transport.world import World, next_world

FRAMES, COUNTED = 16, 4
"""Frames of a run, of which the last is looked at; and those whose time counts."""

TRIAL = 6
"""Frames by which the time of one is measured, before copies are made."""


@dataclass(frozen=True, slots=True, eq=False)
class RoundScene:
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
        self, scene: RoundScene, seed: int, schedule: Schedule
    ) -> Iterator[Estimated]:
        """Frames of a run, without end."""
        about = scene.world, self.settings, scene.bounces, seed, schedule
        return self.render(*about, scene.animation)


@dataclass(frozen=True, slots=True, eq=False)
class Rounds:
    """What runs by turns leave behind.

    Attributes
    ----------
    scene : RoundScene; what was rendered
    estimates : dict of str to list of (N, 9) float64
        Last frame of each run, a mean over the copies.
    seconds : dict of str to float; a frame of one copy takes: the median
    truth : Moments; path-traced, over the areas of pixels
    """

    scene: RoundScene
    estimates: dict[str, list[Scalars]]
    copies: dict[str, int]
    seconds: dict[str, float]
    truth: Moments

    def spent(self, name: str) -> float:
        """Seconds that a frame of all copies takes."""
        return self.copies[name] * self.seconds[name]


def by_rounds(
    scene: RoundScene,
    variants: Mapping[str, Variant],
    work: Work,
    paths: int,
    like: str,
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
    drawn = path_samples(
        scene.shown,
        work.schedule,
        light="indirect",
        bounces=scene.bounces,
        seed=PATH_SEED,
        pixel="box",
    )
    truths = ever_more(drawn, paths, work.schedule)
    estimates: dict[str, list[Scalars]] = {name: [] for name in variants}
    times: dict[str, list[float]] = {name: [] for name in variants}
    for run in range(work.runs):
        work.tick(run, work.runs, "runs")
        running = {
            (name, c): v.frames(scene, run * copies[name] + c, work.schedule).__next__
            for name, v in variants.items()
            for c in range(copies[name])
        }
        for frame, turn in enumerate(in_turns(running, FRAMES)):
            if frame >= FRAMES - COUNTED:
                for (name, _), lap in turn.items():
                    times[name].append(lap.seconds)
        for name in variants:
            found = [turn[name, c].result.estimates for c in range(copies[name])]
            estimates[name].append(np.mean(found, axis=0))
        truth = next(truths)
    work.tick(work.runs, work.runs, "runs")
    seconds = {name: float(np.median(spent)) for name, spent in times.items()}
    return Rounds(scene, estimates, copies, seconds, truth)


def _trial(
    scene: RoundScene, variants: Mapping[str, Variant], work: Work
) -> dict[str, float]:
    running = {
        name: v.frames(scene, PATH_SEED, work.schedule).__next__
        for name, v in variants.items()
    }
    times = seconds_in_turns(running, TRIAL)
    return {name: float(np.median(spent)) for name, spent in times.items()}
