"""A sweep: all runs of all points, those that are not there yet, and their scores."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import zip_longest

from restir_gi.reference.methods import method_named
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.tradeoff.points import Design, settings_of
from restir_gi.reference.reports.tradeoff.scores import DesignScore, score
from restir_gi.reference.reports.tradeoff.store import Store
from restir_gi.reference.reports.tradeoff.trials import Task, run_trial
from restir_gi.reference.scene.named import Named
from restir_gi.reference.system.signals import Interrupted
from restir_gi.reference.system.workers import work
from restir_gi.reference.transport.accumulate import Pixel

CHANGES = 8
"""Runs of a change of light, of those that there are."""

Tick = Callable[[int, int, str], None]


@dataclass(frozen=True, slots=True)
class Sweep:
    """What is measured.

    Attributes
    ----------
    bounces : int; of indirect light
    runs : int; of each point, of seeds ``seed``, ``seed + 1``, ...
    points : tuple of Design; the first is the base
    changed : tuple of Design
        What is seen after a change of light; none for no such runs.
    """

    named: Named
    bounces: int
    frames: int
    runs: int
    seed: int
    points: tuple[Design, ...]
    changed: tuple[Design, ...]

    def runs_of(self, point: Design) -> list[Task]:
        """Runs of a point, in a scene that is left alone."""
        seeds = range(self.seed, self.seed + self.runs)
        scene = self.named, self.bounces, self.frames, point
        return [Task(*scene, seed) for seed in seeds]

    def runs_after_change(self, point: Design) -> list[Task]:
        """Runs of a point, whose lights change when as many frames are still to come.

        At most `CHANGES` of them, each twice as long.
        """
        seeds = range(self.seed, self.seed + min(self.runs, CHANGES))
        scene = self.named, self.bounces, 2 * self.frames, point
        return [Task(*scene, seed, change=self.frames) for seed in seeds]

    def tasks(self) -> list[Task]:
        """All runs: the first of all points, the second of all, and so on; none twice.

        So what slows the machine for a while slows all points.
        """
        rows = [
            *map(self.runs_of, _once(self.points)),
            *map(self.runs_after_change, _once(self.changed)),
        ]
        turns = zip_longest(*rows)
        return [task for turn in turns for task in turn if task is not None]


def run_sweep(sweep: Sweep, store: Store, executor: Executor, tick: Tick) -> None:
    """Do the runs that are not there yet, and keep each as soon as it is done.

    Raises Interrupted by Ctrl-C or SIGTERM; runs that are done are kept.

    Parameters
    ----------
    tick : callable; told how many runs there are, of how many, and their unit
    """
    tasks = sweep.tasks()
    missing = [task for task in tasks if not store.path(task).exists()]
    done = len(tasks) - len(missing)
    tick(done, len(tasks), "runs")
    try:
        for task, trial in work(executor, run_trial, missing):
            store.put(task, trial)
            done += 1
            tick(done, len(tasks), "runs")
    except KeyboardInterrupt as stop:
        raise Interrupted(
            f"interrupted; {done} of {len(tasks)} runs are kept in {store.folder}, and"
            " the same command goes on from there",
            getattr(stop, "terminated", False),
        ) from None


def scores_of(
    sweep: Sweep, store: Store, truths: Mapping[Pixel, Moments]
) -> list[DesignScore]:
    """Scores of all points, in the order of the points.

    Parameters
    ----------
    truths : mapping of 'center' and 'box' to Moments; those that `pixels_of` names
    """
    counted = sweep.runs_of(sweep.points[0])[0].counted
    return [
        score(
            point,
            [store.get(task) for task in sweep.runs_of(point)],
            truths[pixel_of(point)],
            sweep.named.width,
            counted,
        )
        for point in sweep.points
    ]


def pixel_of(point: Design) -> Pixel:
    """What a pixel of a point's pictures shows.

    What its centre sees, or the mean over its area.
    """
    pixel: Pixel = getattr(
        settings_of(point), "pixel", method_named(point.method).pixel
    )
    return pixel


def _once(points: Sequence[Design]) -> list[Design]:
    return list({point.key: point for point in points}.values())


def pixels_of(points: Sequence[Design]) -> list[Pixel]:
    """Which truths are needed."""
    return sorted({pixel_of(point) for point in points})
