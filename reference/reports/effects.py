"""What leaving out parts of the model changes, and what it saves: measured."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.intervals import Interval, median_interval
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.timing import in_turns
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.plan import EVERYTHING, Plan, everything, parts, plan_of
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import Planner, build_world

WHOLE = "everything"
"""Name of leaving out nothing."""

ALL = "all of these"
"""Name of leaving out everything that the scene does not require."""


@dataclass(frozen=True, slots=True)
class Effect:
    """What leaving out a part does.

    Attributes
    ----------
    part : str; of `Plan`, or `ALL`
    identical : bool; every bit of every frame is as with everything
    largest : float
        Largest deviation of a pixel, relative to the mean light of its frame.
    deviation : float; of the mean of a frame, relative; the largest of all frames
    ratios : tuple of float
        Time of each frame, over that of the same frame with everything.
    """

    part: str
    identical: bool
    largest: float
    deviation: float
    ratios: tuple[float, ...]

    @property
    def saved(self) -> Interval:
        """Share of the time that is saved: median of the frames, and its 95 % interval.

        See :func:`restir_gi.reference.numerics.intervals.median_interval`.
        """
        left = median_interval(self.ratios)
        return Interval(1 - left.value, 1 - left.high, 1 - left.low)


def prepared_for_all(animation: Animation) -> Animation:
    """The same scenes, as if anything might change in them.

    Samples then keep what finds their radiance again.
    """
    return Animation(animation, "scene")


def left_out(animation: Animation) -> list[str]:
    """Parts that a scene does not require, in its first frame.

    Names of fields of `Plan`; motion where something moves is required.

    Parameters
    ----------
    animation : Animation; validated
    """
    plan = plan_of(animation(0))
    names = [name for name in parts() if not getattr(plan, name)]
    if animation.changes != "nothing":
        names.remove("motion")
    return names


def effects(
    animation: Animation, bounces: int, frames: int, tick: Callable[[int, int], None]
) -> list[Effect]:
    """Leave out each part by itself, and all of them, and compare with everything.

    One a part that is left out, and one for all of them if they are several.

    Parameters
    ----------
    animation : Animation; validated
    frames : int; of unbiased ReSTIR GI, rendered by turns
    tick : callable; told how many frames are done, of how many
    """
    names = left_out(animation)
    if not names:
        return []
    plans = {name: replace(EVERYTHING, **{name: False}) for name in names}
    if len(names) > 1:
        plans[ALL] = replace(EVERYTHING, **dict.fromkeys(names, False))
    calls = {
        name: _run(animation, bounces, plan).__next__
        for name, plan in {WHOLE: EVERYTHING, **plans}.items()
    }
    ratios: dict[str, list[float]] = {name: [] for name in plans}
    off: dict[str, list[tuple[bool, float, float]]] = {name: [] for name in plans}
    for frame, turn in enumerate(in_turns(calls, frames)):
        whole = turn.pop(WHOLE)
        for name, lap in turn.items():
            ratios[name].append(lap.seconds / whole.seconds)
            off[name].append(_compare(lap.result, whole.result))
        tick(frame + 1, frames)
    return [
        Effect(
            name,
            all(same for same, _, _ in off[name]),
            max(largest for _, largest, _ in off[name]),
            max(mean for _, _, mean in off[name]),
            tuple(ratios[name]),
        )
        for name in plans
    ]


def _run(animation: Animation, bounces: int, plan: Plan) -> Iterator[Vec3s]:
    def planner(scene: Scene) -> Plan:
        return plan

    shown = prepared_for_all(animation) if plan.motion else animation
    world = build_world(shown(0), planner=planner)
    frames = render_frames(world, UNBIASED, bounces, 0, Schedule(), shown)
    return (frame.color for frame in frames)


def _compare(found: Vec3s, true: Vec3s) -> tuple[bool, float, float]:
    light = float(true.mean()) or 1.0
    largest = float(np.abs(found - true).max()) / light
    deviation = abs(float((found - true).mean())) / light
    return np.array_equal(found, true), largest, deviation


def planner_of(everywhere: bool) -> Planner:
    """Who says what is run.

    Parameters
    ----------
    everywhere : bool; run everything, whatever the scene is
    """
    return everything if everywhere else plan_of
