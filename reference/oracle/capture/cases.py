"""Passes of a captured frame as cases of the contract, without their random numbers.

What a pass reads is what the passes before it have written: the new samples of the
frame, the reservoirs that the last frame left, and those of other pixels.  What it
wrote is held against the contract for these very numbers.
"""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.capture.frames import CapturedBuffers, CapturedFrame
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.oracle.capture.visibility import PlacedPoints, traced
from restir_gi.reference.oracle.cases import Buffers, Case, source_rows
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.passes import ASKED, VISIBILITY
from restir_gi.reference.oracle.contract.surfaces import (
    LAMBERTIAN,
    MATERIAL,
    SURFACE,
)
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import World

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

RESERVOIR = ("position", "normal", "radiance", "W", "M")
SAMPLE = RESERVOIR[:3]
VIEWER = ("visible_position", "visible_normal", "albedo")

Buffer = dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Reads:
    """Which buffers the passes read, and how many frames old they are.

    Attributes
    ----------
    past : str and int; the reservoirs of Algorithm 3, and their age in frames
    past_viewer : int; age of the G-buffer that these belong to
    own, around : str and int; what Algorithm 4 takes as its own, and of others
    alone : int, or None; the neighbour that is read from ``around``; ``None``: all
    history : str and int, or None; the spatial past; ``None``: there is none
    sources : str and int; the reservoirs that a fused pass reads
    """

    past: tuple[str, int] = ("spatial", 1)
    past_viewer: int = 1
    own: tuple[str, int] = ("temporal", 0)
    around: tuple[str, int] = ("temporal", 0)
    alone: int | None = None
    history: tuple[str, int] | None = None
    sources: tuple[str, int] = ("fused", 1)


@dataclass(frozen=True, slots=True, eq=False)
class RecordedFrames:
    """Frames of a renderer, and what it has said of them.

    Attributes
    ----------
    width : int; of the image; row = y · width + x
    frames : tuple of CapturedFrame; one after the other
    settings : mapping of str to mapping; of each pass, by the names of the contract
    world : World or None; in which visibility is traced where it was not dumped
    storage : str; how reservoirs are stored, by its name in `STORAGES`, or "exact"
    shading_sees : bool
        The shading asks what the pixel sees, also where no bits of it were dumped.
    boiling : bool
        A filter empties reservoirs after temporal or fused reuse.  Which sample an
        emptied one had is not known: such rows are not looked at.
    blind : frozenset of int
        Viewers, 0 for the pixel, who see nothing but their own sample where neither
        bits nor a scene tell what they see.
    """

    width: int
    frames: tuple[CapturedFrame, ...]
    settings: Mapping[str, Mapping[str, Value]]
    reads: Reads = field(default_factory=Reads)
    world: World | None = None
    storage: str = "exact"
    shading_sees: bool = False
    boiling: bool = False
    blind: frozenset[int] = frozenset()

    @property
    def rows(self) -> int:
        """Pixels of a frame."""
        return len(self.frames[0]["gbuffer"]["visible_position"])


NO_CAP = 1e9
"""Beyond all confidences."""


def recorded_of(
    capture: Capture, world: World | None = None, shading_sees: bool = False
) -> RecordedFrames:
    """Frames of a capture, with the settings and the buffers that its passes had.

    Parameters
    ----------
    world : World, optional; the scene that the frames show
    shading_sees : bool; what the declaration says of the shading
    """
    has = {role for frame in capture.frames for role in frame.roles}
    temporal, spatial, fused = (
        capture.passes.get(name, {}) for name in ("temporal", "spatial", "fused")
    )
    last = "spatial" if "spatial" in has else "temporal"
    reads = Reads(
        past=(temporal.get("past", last), 1),
        own=(own := (spatial.get("reads", _first(has)), 0)),
        around=own,
        history=("spatial", 1) if spatial.get("history") else None,
    )
    settings = {"moved": _settings(temporal), "spatial": _settings(spatial)}
    settings |= {"fused": _settings(fused)}
    settings["shade"] = _surface(fused or spatial or temporal)
    layouts = {
        frame[role].storage
        for frame in capture.frames
        for role in ("temporal", "spatial", "fused")
        if role in frame
    }
    stored = [STORED_AS[name] for name in layouts if name in STORED_AS]
    storage = stored[0] if stored else "exact"
    return RecordedFrames(
        capture.width, capture.frames, settings, reads, world, storage, shading_sees
    )


STORED_AS = {"rtxdi": "rtxdi", "restir_pt": "packed", "paper": "packed"}
"""How reservoirs of known layouts are rounded, by the names of `STORAGES`."""


def _first(has: Set[str]) -> str:
    return "temporal" if "temporal" in has else "initial"


def _settings(table: Mapping[str, Any]) -> dict[str, Value]:
    return {
        "target": table.get("target", "scattered"),
        "cap": float(table.get("cap", NO_CAP)),
        "mis": table.get("mis", "1/Z"),
    } | _surface(table)


def _surface(table: Mapping[str, Any]) -> dict[str, Value]:
    """The setting of a material, which no case of Lambertian points has."""
    name = table.get("surface", LAMBERTIAN)
    return {} if name == LAMBERTIAN else {SURFACE.name: name}


@dataclass(frozen=True, slots=True, eq=False)
class Answered:
    """A case that a renderer has met by itself.

    Attributes
    ----------
    frame : int; its number, as the engine counts
    case, outputs : Case, Buffers; what it was given, and what it wrote
    """

    frame: int
    case: Case
    outputs: Buffers


@dataclass(frozen=True, slots=True, eq=False)
class Read:
    """Columns that a pass reads, N rows.

    Attributes
    ----------
    columns : dict of str to (N, ...) array
    errors : dict of str to (N,) float64; by how much the engine's decoder may differ
    """

    columns: Buffer
    errors: dict[str, Scalars]

    def at(self, row: Indices, there: Masks, otherwise: "Read") -> "Read":
        """Those of other rows, and others where there is none.

        Parameters
        ----------
        row : (N,) int; which rows
        there : (N,) bool; where ``otherwise`` is not taken
        """
        columns = {
            name: np.where(_beside(there, a), a[row], otherwise.columns[name])
            for name, a in self.columns.items()
        }
        errors = {
            name: np.where(there, e[row], otherwise.errors.get(name, e[row]))
            for name, e in self.errors.items()
        }
        return Read(columns, errors)

    def of(self, rows: Sequence[Indices]) -> list["Read"]:
        """These, and then those of other rows.

        Parameters
        ----------
        rows : sequence of (N,) int; one for each that follows
        """
        return [
            self,
            *(Read({n: a[row] for n, a in self.columns.items()}, {}) for row in rows),
        ]

    def emptied(self) -> "Read":
        """Empty reservoirs whose samples stand where these do."""
        none = np.zeros(len(self.columns["position"]))
        radiance = np.zeros((len(none), 3))
        columns = {"position": self.columns["position"], "radiance": radiance}
        columns |= {"normal": self.columns["normal"], "W": none, "M": none}
        return Read(columns, self.errors)

    def prefixed(self, prefix: str) -> "Read":
        """The same under longer names."""
        return Read(
            {prefix + name: a for name, a in self.columns.items()},
            {prefix + name: e for name, e in self.errors.items()},
        )


def _beside(there: Masks, array: NDArray[Any]) -> Masks:
    """A mask with the columns of an array."""
    found: Masks = there.reshape(-1, *[1] * (array.ndim - 1))
    return found


def _together(parts: Sequence[Read]) -> tuple[Buffer, dict[str, Scalars]]:
    columns: Buffer = {}
    errors: dict[str, Scalars] = {}
    for part in parts:
        columns |= part.columns
        errors |= part.errors
    return columns, errors


NORMAL_READ = 16 * 2.0**-24
"""Of a component of a unit vector that was decoded in single precision: some eight
operations on numbers of size 1, each of which rounds by 2⁻²⁴ at most, here and there.
"""

LIGHT_READ = 256 * 2.0**-24
"""Of a channel, as a share of the luminance.  The logarithm of 20 at most rounds by
20 · 2⁻²⁴, which the power of 2 multiplies by ln 2; X and Z are at most 8 Y where v' is
1/16 or more, and the matrix adds them with coefficients whose sizes sum to 5.3.
"""


def _errors(columns: Buffer, formats: Mapping[str, str]) -> dict[str, Scalars]:
    """By how much an engine's decoder may differ from ours, by column."""
    found = {}
    for name, array in columns.items():
        form = formats.get(name, "")
        if form.startswith("octahedral"):
            found[name] = np.full(len(array), NORMAL_READ)
        if form.startswith("logluv"):
            found[name] = LIGHT_READ * np.asarray(array) @ LUMINANCE
    return found


def captured_cases(recorded: RecordedFrames) -> Iterator[Answered]:
    """Passes of all frames, in the order in which they ran.

    Those of which a buffer is missing that only an earlier frame could give are left
    out.

    Raises UsageError: a pass has written a buffer, and what it has read is not there.
    """
    for place in range(len(recorded.frames)):
        for build in (_temporal, _spatial, _fused, _shade):
            found = build(recorded, place)
            if found is not None:
                yield found


def _temporal(recorded: RecordedFrames, place: int) -> Answered | None:
    """Algorithm 3, as pass ``moved``, which is `temporal` where nothing has moved."""
    frame, reads = recorded.frames[place], recorded.reads
    before = [place - age for age in (reads.past[1], reads.past_viewer)]
    if "temporal" not in frame or min(before) < 0:
        return None
    row = _needed(recorded, place, "history", ("row",)).columns["row"]
    there, row = row >= 0, np.maximum(row, 0)
    x, new = _viewer(recorded, place), _needed(recorded, place, "initial", SAMPLE)
    past = _needed(recorded, before[0], reads.past[0], RESERVOIR)
    x_past = _viewer(recorded, before[1]).at(row, there, x)
    past = past.at(row, there, new.emptied())
    read = x, x_past.prefixed("past_"), past.prefixed("past_"), new.prefixed("new_")
    inputs, errors = _together(read)
    if (age := _ages(recorded, before[0], reads.past[0])) is not None:
        inputs["past_age"] = np.where(there, age[row], 0)
        # A limit drawn at random shows in M alone: 1 for the new sample, or more.
        kept = _needed(recorded, place, "temporal", ("M",)).columns["M"]
        inputs["past_counted"] = (kept > 1).astype(np.uint32)
    inputs["new_pdf"] = _density(recorded, place)
    who = (x, x_past), (new, past)
    inputs["visible"], sure = _visible(recorded, place, "visible_temporal", *who)
    inputs |= _targets(recorded, place, "moved", (2, 2))
    return _answered(recorded, place, "moved", "temporal", inputs, errors, sure)


def _ages(recorded: RecordedFrames, place: int, role: str) -> Indices | None:
    """Frames that samples have survived, (N,), if reservoirs tell."""
    buffers = recorded.frames[place][role]
    return np.asarray(buffers["age"]).astype(np.int64) if "age" in buffers else None


def _spatial(recorded: RecordedFrames, place: int) -> Answered | None:
    frame, reads = recorded.frames[place], recorded.reads
    if "spatial" not in frame:
        return None
    around = _needed(recorded, place, "neighbors", ("neighbors",)).columns["neighbors"]
    own = _at(recorded, place, reads.own)
    if own is None:
        return None
    history = own.emptied()
    if reads.history is not None:
        known = _at(recorded, place, reads.history)
        if known is None:
            return None
        history = known
    x, count = _viewer(recorded, place), around.shape[1]
    inputs, errors = _together((x, own, history.prefixed("past_")))
    inputs["neighbors"] = around
    rows = [np.maximum(around[:, k], 0) for k in range(count)]
    viewers, samples = (one.of(rows) for one in (x, own))
    who = viewers, (*samples, history)
    inputs["visible"], sure = _visible(recorded, place, "visible_spatial", *who)
    inputs |= _targets(recorded, place, "spatial", (count + 1, count + 2))
    found = _answered(recorded, place, "spatial", "spatial", inputs, errors, sure)
    if reads.around == reads.own:
        return found
    others = _at(recorded, place, reads.around)
    if others is None:
        return None
    return _apart(recorded.rows, found, others, reads.alone)


def _apart(rows: int, found: Answered, others: Read, alone: int | None) -> Answered:
    """Algorithm 4 where what others hold is not what pixels take as their own.

    The rows come twice: as pixels, and once more, without neighbours, as those whose
    reservoirs are read.

    Parameters
    ----------
    alone : int, or None; the neighbour that is read so; ``None``: all are
    """
    twice = {n: np.concatenate([a, a]) for n, a in found.case.inputs.items()}
    for name in RESERVOIR:
        twice[name][rows:] = others.columns[name]
    around = found.case.inputs["neighbors"]
    chosen = np.full(around.shape[1], alone is None)
    if alone is not None:
        chosen[alone] = True
    moved = np.where((around >= 0) & chosen, around + rows, around)
    twice["neighbors"] = np.concatenate([moved, np.full_like(around, -1)])
    known = found.case.decoded or {}
    errors = {n: np.concatenate([a, others.errors.get(n, a)]) for n, a in known.items()}
    beyond = np.arange(2 * rows) >= rows
    if found.case.beyond is not None:
        beyond[:rows] |= found.case.beyond
    case = replace(found.case, inputs=twice, beyond=beyond, decoded=errors)
    outputs = {n: np.concatenate([a, a]) for n, a in found.outputs.items()}
    return replace(found, case=case, outputs=outputs)


def _fused(recorded: RecordedFrames, place: int) -> Answered | None:
    """Spatiotemporal resampling: the pixel's own, and some of the frame before."""
    frame, reads = recorded.frames[place], recorded.reads
    role, age = reads.sources
    before = [place - age, place - reads.past_viewer]
    if "fused" not in frame or min(before) < 0:
        return None
    of = _needed(recorded, place, "sources", ("sources",)).columns["sources"]
    x, x_past = _viewer(recorded, place), _viewer(recorded, before[1])
    own = _needed(recorded, place, "initial", RESERVOIR)
    past = _needed(recorded, before[0], role, RESERVOIR)
    read = x, own, x_past.prefixed("past_"), past.prefixed("past_")
    inputs, errors = _together(read)
    inputs["sources"], count = of, of.shape[1]
    rows = [np.maximum(of[:, k], 0) for k in range(count)]
    who = (x, *x_past.of(rows)[1:]), (own, *past.of(rows)[1:])
    inputs["visible"], sure = _visible(recorded, place, "visible_fused", *who)
    inputs |= _targets(recorded, place, "fused", (count + 1, count + 1))
    return _answered(recorded, place, "fused", "fused", inputs, errors, sure)


SHADED = ("fused", "spatial", "temporal", "initial")
"""Whose reservoirs are shaded: the last of a frame."""


def _shade(recorded: RecordedFrames, place: int) -> Answered | None:
    frame = recorded.frames[place]
    last = next((name for name in SHADED if name in frame), None)
    if "shade" not in frame or last is None:
        return None
    kept, x = _needed(recorded, place, last, (*SAMPLE, "W")), _viewer(recorded, place)
    inputs, errors = _together((x, kept))
    sure, more = np.ones(recorded.rows, bool), dict[str, Value]()
    # Whoever declares that the shading asks, and gives neither bits nor a scene, is
    # taken to see all.
    traces = recorded.shading_sees and recorded.world is not None
    if "visible_shade" in frame or traces:
        seen, sure = _visible(recorded, place, "visible_shade", (x,), (kept,))
        inputs["visible"] = seen.reshape(-1) & np.uint32(1)
        more[VISIBILITY.name] = ASKED
    return _answered(recorded, place, "shade", "shade", inputs, errors, sure, more)


def _answered(
    recorded: RecordedFrames,
    place: int,
    pass_name: str,
    role: str,
    inputs: Buffer,
    errors: Mapping[str, Scalars],
    sure: Masks,
    more: Mapping[str, Value] | None = None,
) -> Answered:
    """A pass with what it wrote.

    Parameters
    ----------
    sure : (N,) bool; rows that are looked at
    more : mapping, optional; settings of this frame
    """
    frame = recorded.frames[place]
    settings = {**recorded.settings.get(pass_name, {}), **(more or {})}
    inputs, numbers = _numbers(inputs)
    sure = sure & numbers
    case = graded(
        Case(
            f"{pass_name}-frame-{frame.number}",
            pass_name,
            settings,
            given(inputs, "float32"),
            width=recorded.width,
            decoded=dict(errors),
        )
    )
    asked = whole_contract()[pass_name].outputs
    columns = _needed(recorded, place, role, [f.name for f in asked]).columns
    if recorded.boiling and role in FILTERED:
        sure = sure & ~_is_empty(columns)
    if not sure.all():
        beyond = ~sure if case.beyond is None else case.beyond | ~sure
        case = replace(case, beyond=beyond)
    return Answered(frame.number, case, given(columns, "float32"))


FILTERED = ("temporal", "fused")
"""Roles whose reservoirs a boiling filter empties."""


def _is_empty(reservoirs: Buffer | CapturedBuffers) -> Masks:
    """Which reservoirs hold nothing at all, not even the pixel's own null."""
    empty: Masks = (reservoirs["W"] == 0) & (reservoirs["M"] == 0)
    return empty


def emptied(recorded: RecordedFrames) -> tuple[int, int]:
    """Reservoirs of surfaces that a filter has emptied, and how many there are."""
    count = rows = 0
    for frame in recorded.frames:
        seen = np.any(frame["gbuffer"]["visible_normal"], axis=1)
        for role in (role for role in FILTERED if role in frame):
            count += int((_is_empty(frame[role]) & seen).sum())
            rows += int(seen.sum())
    return count, rows


def _numbers(inputs: Buffer) -> tuple[Buffer, Masks]:
    """Inputs with 0 for what is no number, and rows that have not read any such.

    The pass that made it is wrong, and not those that come after.
    """
    found, sure = dict(inputs), np.ones(len(next(iter(inputs.values()))), bool)
    for name, array in inputs.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            known = np.isfinite(array)
            found[name] = np.where(known, array, 0.0)
            sure &= known.reshape(len(array), -1).all(axis=1)
    if (sources := source_rows(inputs)) and not sure.all():
        around = inputs[sources.rows]
        sure = sure & (sure[np.maximum(around, 0)] | (around < 0)).all(axis=1)
    return found, sure


def _at(recorded: RecordedFrames, place: int, read: tuple[str, int]) -> Read | None:
    """Reservoirs that a pass reads; ``None`` where they are older than the capture."""
    role, age = read
    return None if place < age else _needed(recorded, place - age, role, RESERVOIR)


def _needed(
    recorded: RecordedFrames, place: int, role: str, names: Sequence[str]
) -> Read:
    """Columns of a frame.

    Raises UsageError: one is missing.
    """
    frame = recorded.frames[place]
    missing = [n for n in names if role not in frame or n not in frame[role]]
    if missing:
        raise UsageError(
            f"frame {frame.number} has no {role}.{missing[0]}, which a later pass has"
            " read; dump it too, or leave out what was made from it"
        )
    buffers = frame[role]
    columns = {name: np.asarray(buffers[name]) for name in names}
    return Read(columns, _errors(columns, buffers.formats))


def _viewer(recorded: RecordedFrames, place: int) -> Read:
    """Visible points of a frame, with the material that a setting asks for."""
    surface = recorded.settings.get("shade", {}).get(SURFACE.name)
    more = [f.name for f in MATERIAL if f.only and surface in f.only[1]]
    return _needed(recorded, place, "gbuffer", (*VIEWER, *more))


def _visible(
    recorded: RecordedFrames,
    place: int,
    role: str,
    viewers: Sequence[Read],
    samples: Sequence[Read],
) -> tuple[NDArray[np.uint32], Masks]:
    """Who sees which sample, as the contract has it, and where that is sure.

    As it was dumped; else traced in the scene; else all see all.
    """
    frame, everywhere = recorded.frames[place], np.ones(recorded.rows, bool)
    if role in frame:
        words = np.asarray(frame[role]["visible"]).astype(np.uint32)
        return words.reshape(-1, len(viewers)), everywhere
    if recorded.world is not None:
        x = [_points(one, "visible_") for one in viewers]
        return traced(recorded.world, x, [_points(one) for one in samples])
    own = 1 << np.arange(len(viewers), dtype=np.uint32)
    blind = np.isin(np.arange(len(viewers)), list(recorded.blind))
    words = np.where(blind, own, np.uint32(0xFFFFFFFF))
    return np.tile(words, (recorded.rows, 1)), everywhere


def _points(read: Read, prefix: str = "") -> PlacedPoints:
    position, normal = (
        np.asarray(read.columns[prefix + name], np.float64)
        for name in ("position", "normal")
    )
    return PlacedPoints(position, normal)


def _density(recorded: RecordedFrames, place: int) -> Scalars:
    """Density of the new samples, 0 where one has no weight."""
    found = recorded.frames[place]["initial"]
    if "pdf" in found:
        return np.asarray(found["pdf"])
    W = _needed(recorded, place, "initial", ("W",)).columns["W"]
    density: Scalars = np.divide(1.0, W, out=np.zeros(len(W)), where=W > 0)
    return density


def _targets(
    recorded: RecordedFrames, place: int, pass_name: str, shape: tuple[int, ...]
) -> Buffer:
    """Targets as data, where the pass has them so."""
    if recorded.settings.get(pass_name, {}).get("target") != "data":
        return {}
    found = _needed(recorded, place, f"targets_{pass_name}", ("p_hat",))
    return {"p_hat_given": found.columns["p_hat"].reshape(recorded.rows, *shape)}
