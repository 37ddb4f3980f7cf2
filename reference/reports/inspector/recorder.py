"""A run of ReSTIR GI again, with all that its passes consider."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.methods import Job
from restir_gi.reference.reports.inspector.candidates import PassRecord, recorded
from restir_gi.reference.reports.inspector.provenance import PathNumbers, Provenance
from restir_gi.reference.restir_gi import (
    Frame,
    history_of,
    render_frames,
    reuses_neighbors,
    spatial_inputs,
    temporal_input,
)
from restir_gi.reference.settings import Settings


@dataclass(frozen=True, slots=True, eq=False)
class RecordedFrame:
    """A frame, and what its passes considered.

    Attributes
    ----------
    frame : Frame; as it is without anybody watching
    """

    frame: Frame
    passes: tuple[PassRecord, ...]


def recorded_frames(job: Job) -> Iterator[RecordedFrame]:
    """Frames of a job, without end.

    Parameters
    ----------
    job : Job; of one of the methods of ReSTIR GI

    Yields
    ------
    RecordedFrame
        The frames of :func:`restir_gi.reference.restir_gi.render_frames`.  Each pass is
        done again beside it: no pass keeps a log, and none need be trusted to keep one.
    """
    last: Frame | None = None
    before: PathNumbers | None = None
    frames = render_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )
    for made in frames:
        frame = FrameContext(
            number=made.number,
            world=made.world,
            visible=made.visible,
            settings=job.settings,
            bounces=job.bounces,
            seed=job.seed,
            schedule=job.schedule,
            changes=job.animation.changes if job.animation else "nothing",
        )
        passes = _passes(frame, made, last, before)
        yield RecordedFrame(made, passes)
        last, before = made, PathNumbers(passes[0].number, passes[-1].number)


def _passes(
    frame: FrameContext[Settings],
    made: Frame,
    last: Frame | None,
    before: PathNumbers | None,
) -> tuple[PassRecord, ...]:
    s, history, everyone = (
        frame.settings,
        history_of(frame, last),
        slice(0, frame.pixels),
    )
    known = Provenance(frame.number, frame.numbers(everyone), history, before)
    name = "fused" if s.reuse == "fused" else "temporal"
    given = temporal_input(frame, history, everyone)
    first = recorded(name, [(everyone, given)], s, known)
    if not reuses_neighbors(s):
        return (first,)
    known = replace(known, temporal=first.number)
    parts = spatial_inputs(frame, history, made.temporal, everyone)
    return (first, recorded("spatial", parts, s, known))
