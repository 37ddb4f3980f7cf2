"""The record of a capture, and how it is read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from restir_gi.reference.oracle.capture.contents import read_buffer
from restir_gi.reference.oracle.capture.description import Buffer
from restir_gi.reference.oracle.capture.faults import CaptureError
from restir_gi.reference.oracle.capture.frames import CapturedBuffers, CapturedFrame
from restir_gi.reference.oracle.capture.manifest import (
    NAME,
    manifest_of,
    read_manifest,
)
from restir_gi.reference.oracle.capture.reading import read_frames
from restir_gi.reference.oracle.capture.schema import FORM
from restir_gi.reference.oracle.host_arrays import host_array
from restir_gi.reference.system.errors import UsageError


@dataclass(frozen=True, slots=True)
class Capture:
    """Some frames of an engine.

    Attributes
    ----------
    width, height : int, pixels; N = width · height rows
    frames : tuple of CapturedFrame; in the order of their numbers
    declaration : Path, optional; what the engine declares of itself; not read here
    scene : str, optional
        Built-in scene or file, as the manifest has it; not read here.
    passes : mapping of str to mapping
        Settings of ``temporal`` and ``spatial``, and what they read, by their keys.
    folder : Path, optional; of the manifest, to which names of files are relative
    notes : tuple of str
        What a reader ought to know and need not change, such as how many neighbours lay
        outside of the image.
    """

    width: int
    height: int
    frames: tuple[CapturedFrame, ...]
    declaration: Path | None = None
    scene: str | None = None
    passes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    folder: Path | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def read(cls, folder: Path | str) -> Self:
        """Read a folder with ``capture.toml``, or such a file of another name.

        Raises UsageError: manifest or buffers cannot be read, or are wrong; of what is
        wrong all is told, each part in `CaptureError.faults`.
        """
        path = Path(folder)
        path = path / NAME if path.is_dir() else path
        manifest, above = read_manifest(path), path.parent
        size = manifest.width, manifest.height
        frames, notes = read_frames(
            manifest,
            path,
            lambda buffer, k: read_buffer(above, buffer, manifest.frames[k], *size),
        )
        declared = manifest.declaration
        return cls(
            width=manifest.width,
            height=manifest.height,
            frames=frames,
            declaration=None if declared is None else above / declared,
            scene=manifest.scene,
            passes=manifest.passes,
            folder=above,
            notes=notes,
        )

    @classmethod
    def from_arrays(
        cls,
        *,
        width: int,
        height: int,
        frames: Sequence[Mapping[str, Any]],
        manifest: Mapping[str, Any],
    ) -> Self:
        """Decode arrays of Python in place of files.

        Raises CaptureError: the manifest is wrong, or an array is; all is told.

        Parameters
        ----------
        frames : sequence of mapping of str to array
            By the names of the buffers: arrays with DLPack or
            ``__cuda_array_interface__``, of NumPy, or buffers.  Those on a device are
            copied by their own ``get`` or ``cpu``.
        manifest : mapping
            As of ``capture.toml``; ``buffers`` is enough, without files.
        """
        given = {
            "schema": FORM,
            "width": width,
            "height": height,
            "frames": list(range(len(frames))),
            **manifest,
        }
        judged = manifest_of(given, "manifest", of_files=False)
        size = judged.width, judged.height
        if size != (width, height) or len(judged.frames) != len(frames):
            raise CaptureError(
                "manifest",
                [
                    f"it is of {size[0]}x{size[1]} pixels and {len(judged.frames)}"
                    f" frames; given are {width}x{height} and {len(frames)}"
                ],
            )

        def array_of(buffer: Buffer, index: int) -> Any:
            if buffer.name not in frames[index]:
                raise UsageError(
                    "is not given; give an array, or leave the frame out of `frames` of"
                    " this buffer"
                )
            return host_array(frames[index][buffer.name])

        found, notes = read_frames(judged, "arrays", array_of)
        declared = judged.declaration
        return cls(
            width=width,
            height=height,
            frames=found,
            declaration=None if declared is None else Path(declared),
            scene=judged.scene,
            passes=judged.passes,
            notes=notes,
        )

    @property
    def rows(self) -> int:
        """Pixels of a frame."""
        return self.width * self.height

    def before(self, index: int) -> CapturedFrame | None:
        """The frame before that of an index; None where it was not captured."""
        if index == 0 or self.frames[index - 1].number != self.frames[index].number - 1:
            return None
        return self.frames[index - 1]

    def previous_gbuffer(self, index: int) -> CapturedBuffers | None:
        """Visible points of the frame before, for the frame of an index.

        They are the role ``previous_gbuffer`` where it was dumped, or else the
        ``gbuffer`` of the frame before; None where neither was.
        """
        frame, before = self.frames[index], self.before(index)
        if "previous_gbuffer" in frame:
            return frame["previous_gbuffer"]
        return before.roles.get("gbuffer") if before else None
