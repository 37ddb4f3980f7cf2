"""A run of ReSTIR GI again, with all that its passes consider."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reference.inspector.considered import Considered, considered
from reference.inspector.origins import Origins, Paths
from reference.methods import Job
from reference.passes.competitions import first_competition, second_competitions
from reference.passes.halves import reuses_neighbors
from reference.passes.moment import Frame, Moment
from reference.passes.past import past_of
from reference.restir_gi import render_frames


@dataclass(frozen=True, slots=True, eq=False)
class Watched:
    """A frame, and what its passes considered.

    Attributes
    ----------
    frame : Frame
        As it is without anybody watching.
    passes : tuple of Considered
        In their order.
    """

    frame: Frame
    passes: tuple[Considered, ...]


def watched_frames(job: Job) -> Iterator[Watched]:
    """Frames of a job, without end.

    Parameters
    ----------
    job : Job
        Of one of the methods of ReSTIR GI.

    Yields
    ------
    Watched
        The frames of :func:`reference.restir_gi.render_frames`.  Each pass is done
        again beside it: no pass keeps a log, and none need be trusted to keep one.
    """
    last: Frame | None = None
    before: Paths | None = None
    changes = job.animation.changes if job.animation else "nothing"
    frames = render_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )
    for frame in frames:
        moment = Moment(
            frame.number,
            frame.world,
            frame.visible,
            job.settings,
            job.bounces,
            job.seed,
            job.schedule,
            changes,
        )
        passes = _passes(moment, frame, last, before)
        yield Watched(frame, passes)
        last, before = frame, Paths(passes[0].number, passes[-1].number)


def _passes(
    moment: Moment, frame: Frame, last: Frame | None, before: Paths | None
) -> tuple[Considered, ...]:
    past, everyone = past_of(moment, last), slice(0, moment.pixels)
    origins = Origins(moment.number, moment.numbers(everyone), past, before)
    competition, _ = first_competition(moment, past, everyone)
    rows = np.arange(moment.pixels)
    name = "fused" if moment.settings.reuse == "fused" else "temporal"
    first = considered(name, [(rows, competition)], origins)
    if not reuses_neighbors(moment):
        return (first,)
    then = Origins(moment.number, origins.drawn, past, before, first.number)
    competitions = second_competitions(moment, past, frame.temporal, everyone)
    return (first, considered("spatial", competitions, then))
