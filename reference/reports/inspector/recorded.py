"""Frames as the page holds them: arrays, by the names of what they are."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from restir_gi.reference.methods import Job, Layers, Method, drive
from restir_gi.reference.methods.method import Progress
from restir_gi.reference.methods.restir_gi import FRAMED
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.records import nbytes
from restir_gi.reference.reports.inspector.candidates import PassRecord
from restir_gi.reference.reports.inspector.outcomes import WORDS, Outcome
from restir_gi.reference.reports.inspector.recorder import (
    RecordedFrame,
    recorded_frames,
)
from restir_gi.reference.reports.inspector.wireframe import wireframe
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.system.errors import UsageError

SHOWN = {
    Outcome.DARK: "dropped",
    Outcome.REFUSED: "dropped",
    Outcome.EDGE_ON: "dropped",
    Outcome.HIDDEN: "hidden",
    Outcome.COMPETED: "competed",
}
"""How rays to candidates are drawn; no ray to a sample that there is not."""

Plain = dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """A run, as the page holds it.

    Attributes
    ----------
    frames : list of dict; the last ones
    layers : mapping of str to array; the picture that the run ends with
    """

    frames: list[Plain]
    layers: Layers


def recorded(
    method: Method,
    job: Job,
    last: int | None,
    room: int,
    tick: Callable[[Progress], None],
) -> Recorded:
    """Run a job of ReSTIR GI, and record what happens.

    Nothing about the picture differs from a run that is not recorded.

    Raises UsageError: the job has no frames of indirect light.

    Parameters
    ----------
    last : int or None; frames to keep; ``None`` for as many as there is room for
    room : int, bytes; for frames, where ``last`` is ``None``; one is kept in any case
    tick : callable; told of each step of progress
    """
    kept: deque[Plain] = deque(maxlen=last)

    def frames(job: Job) -> Iterator[Any]:
        for made in recorded_frames(job):
            kept.append(plain_frame(made))
            while last is None and len(kept) > 1 and nbytes(list(kept)) > room:
                kept.popleft()
            yield made.frame

    watching = replace(method, render=replace(FRAMED, frames=frames).render)
    layers = drive(watching, job, tick)
    if not kept:
        raise UsageError(
            "the run holds no frames of indirect light; render with --light indirect or"
            " full, and --bounces of at least 1"
        )
    return Recorded(list(kept), layers)


def plain_frame(made: RecordedFrame) -> Plain:
    """A frame in plain structures.

    Arrays of single precision, and of small integers, row = y · width + x.
    """
    frame = made.frame
    kinds = [(frame.temporal, "temporal"), (frame.spatial, "spatial")]
    if frame.spatial is frame.temporal:
        kinds = [(frame.temporal, made.passes[0].name)]
    pixels = len(frame.color)
    return {
        "number": frame.number,
        "color": _reals(frame.color),
        "x": _reals(frame.visible.surface.position),
        "seen": frame.visible.surface.hit.astype(np.uint8),
        "reservoirs": [
            _reservoirs(name, r, made_by, pixels)
            for (r, name), made_by in zip(kinds, made.passes, strict=True)
        ],
        "passes": [_pass(made_by) for made_by in made.passes],
        **wireframe(frame.world, frame.visible.surface),
    }


def _reals(values: Any) -> Any:
    return np.ascontiguousarray(values, np.float32)


def _whole(values: Indices) -> Any:
    return np.ascontiguousarray(values, np.int32)


def _reservoirs(name: str, r: Reservoirs, made_by: PassRecord, pixels: int) -> Plain:
    number, rows = made_by.number, np.arange(pixels)
    some = (number >= 0) & (r.W > 0)
    return {
        "name": name,
        "M": _reals(r.M),
        "W": _reals(r.W),
        "w": _reals(made_by.w_sum),
        "total": _reals(made_by.total),
        "p_hat": _reals(made_by.p_hat[rows, made_by.kept]),
        "position": _reals(r.y.position),
        "normal": _reals(r.y.normal),
        "radiance": _reals(r.y.radiance),
        "pixel": _whole(np.where(some, number % pixels, -1)),
        "frame": _whole(np.where(some, number // pixels, -1)),
    }


def _pass(made_by: PassRecord) -> Plain:
    return {
        "name": made_by.name,
        "roles": list(made_by.roles),
        "frames": list(made_by.frames),
        "fates": [WORDS[outcome] for outcome in Outcome],
        "shown": [SHOWN.get(outcome) for outcome in Outcome],
        "untried": int(Outcome.UNTRIED),
        "absent": int(Outcome.ABSENT),
        "source": _whole(made_by.source),
        **{
            name: _reals(getattr(made_by, name))
            for name in ("M", "W", "p_hat", "jacobian", "w", "position")
        },
        "fate": made_by.outcome.astype(np.uint8),
        "could": made_by.could.astype(np.uint8),
        "kept": made_by.kept.astype(np.uint8),
    }
