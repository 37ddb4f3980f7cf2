"""Frames of a capture from its manifest and its buffers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.capture.columns import (
    Column,
    Contents,
    DecodedField,
    joined,
    parts_of,
    refuse_what_is_not_finite,
)
from restir_gi.reference.oracle.capture.conversions import as_bits, as_reals, as_rows
from restir_gi.reference.oracle.capture.derived import Derived, derive, nothing_seen
from restir_gi.reference.oracle.capture.description import Buffer, Manifest
from restir_gi.reference.oracle.capture.faults import CaptureError
from restir_gi.reference.oracle.capture.frames import CapturedBuffers, CapturedFrame
from restir_gi.reference.system.errors import UsageError

WRITTEN = ("temporal", "spatial", "fused", "shade")
"""Roles that a renderer's passes write: what is no number there, is its own mistake."""

ContentsOf = Callable[[Buffer, int], Contents]
"""What a buffer holds in the frame of an index."""


def read_frames(
    manifest: Manifest, where: Path | str, contents_of: ContentsOf
) -> tuple[tuple[CapturedFrame, ...], tuple[str, ...]]:
    """Decode all buffers of all frames.

    Raises CaptureError: buffers are missing, have other sizes or numbers that are not
    finite; all is told that is wrong.

    Parameters
    ----------
    where : Path or str; how messages begin

    Returns
    -------
    frames, notes : tuple of CapturedFrame, tuple of str; notes are for readers
    """
    frames, faults, notes = [], [], []
    for index, number in enumerate(manifest.frames):
        one = _FrameReader(manifest, index)
        roles = one.read(contents_of)
        faults += [f"frame {number}: {fault}" for fault in one.faults]
        notes += [f"frame {number}: {note}" for note in one.notes]
        frames.append(CapturedFrame(number, roles))
    if faults:
        raise CaptureError(where, faults)
    return tuple(frames), tuple(notes)


@dataclass(slots=True)
class _RoleParts:
    """What the buffers of one role have, before it is put together."""

    layout: str = "fields"
    parts: dict[str, list[DecodedField]] = field(default_factory=dict)
    words: dict[str, NDArray[np.uint8]] = field(default_factory=dict)


class _FrameReader:
    """One frame, and what is wrong with it."""

    def __init__(self, manifest: Manifest, index: int) -> None:
        self._manifest, self._index = manifest, index
        self._size = manifest.width, manifest.height
        self.faults: list[str] = []
        self.notes: list[str] = []

    def read(self, contents_of: ContentsOf) -> Mapping[str, CapturedBuffers]:
        """All roles that the frame has buffers of."""
        roles: dict[str, _RoleParts] = {}
        for buffer in self._manifest.buffers:
            if self._manifest.frames[self._index] in buffer.frames:
                self._add(
                    roles.setdefault(buffer.role, _RoleParts()), buffer, contents_of
                )
        return {name: self._role(name, found) for name, found in roles.items()}

    def _add(self, to: _RoleParts, buffer: Buffer, contents_of: ContentsOf) -> None:
        if buffer.layout != "fields":
            to.layout = buffer.layout
        try:
            contents = contents_of(buffer, self._index)
            parts, words = parts_of(buffer, contents, *self._size)
        except UsageError as error:
            number = self._manifest.frames[self._index]
            file = f", {buffer.path(number)}" if buffer.file else ""
            self.faults.append(f"{buffer.name}{file}: {error}")
            return
        for part in parts:
            to.parts.setdefault(part.field.field.name, []).append(part)
        if words is not None:
            to.words[buffer.name] = words

    def _role(self, role: str, found: _RoleParts) -> CapturedBuffers:
        columns = {name: joined(parts) for name, parts in found.parts.items()}
        arrays: dict[str, NDArray[Any]] = {}
        for name, column in columns.items():
            try:
                self._look_for_what_is_not_finite(f"{name} of {role}", role, column)
                arrays[name] = self._converted(f"{name} of {role}", column)
            except ValueError as error:
                self.faults.append(f"{name} of {role} {error}")
        if {"depth", "visible_normal"} <= arrays.keys():
            # Whatever bits stand there, they are no normal.
            seen = ~nothing_seen(columns)
            arrays["visible_normal"] = arrays["visible_normal"] * seen[:, None]
        formats = {name: column.kind for name, column in columns.items()}
        derived: dict[str, str] = {}
        # What follows from wrong numbers need not be told.
        if not self.faults:
            for one in self._derived(role, columns, arrays):
                arrays[one.name], derived[one.name] = one.array, one.how
                formats[one.name] = formats[one.source]
        return CapturedBuffers(arrays, found.layout, formats, derived, found.words)

    def _look_for_what_is_not_finite(
        self, what: str, role: str, column: Column
    ) -> None:
        """A fault of the capture, or a note where a pass may have written it.

        Raises ValueError: it is a fault.
        """
        try:
            refuse_what_is_not_finite(column, self._size[0])
        except ValueError as error:
            if role not in WRITTEN:
                raise
            self.notes.append(f"{what} {error}")

    def _derived(
        self,
        role: str,
        columns: Mapping[str, Column],
        arrays: Mapping[str, NDArray[Any]],
    ) -> list[Derived]:
        cameras = self._manifest.cameras
        camera = cameras[self._index] if cameras else None
        found = derive(role, columns, arrays, camera, self._size)
        self.faults += [
            f"{one.name} of {role}, {one.how}, is not finite; {one.right}"
            for one in found
            if role not in WRITTEN and not np.isfinite(one.array).all()
        ]
        return found

    def _converted(self, what: str, column: Column) -> NDArray[Any]:
        kind = column.fields[0].field.kind
        if kind == "bits":
            return as_bits(column)
        if kind == "real":
            return as_reals(column)
        rows, outside = as_rows(column, *self._size)
        if outside:
            self.notes.append(
                f"{what}: {outside:,} lie outside of the image, and count as none"
            )
        return rows
