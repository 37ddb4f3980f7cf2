"""What a manifest describes, as records."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.capture.kinds import KINDS, NumberKind
from restir_gi.reference.oracle.capture.layouts import LAYOUTS
from restir_gi.reference.oracle.capture.roles import Role, role_of
from restir_gi.reference.oracle.contract.fields import Field
from restir_gi.reference.scene.camera import Camera

FRAME = re.compile(r"\{frame(?::0([1-9]))?\}")
PAIRS = ("pixels", "offsets")
GIVEN: Mapping[str, tuple[str, ...]] = {
    "row": ("rows", *PAIRS),
    "neighbors": ("rows", *PAIRS),
    "sources": ("rows", *PAIRS),
    "depth": ("view", "distance", "device"),
}
"""How a field may be given, by its name; the first is the default."""

TILE = (16, 16)
"""Pixels of a tile where nothing is said."""


@dataclass(frozen=True, slots=True)
class StoredField:
    """A field of a buffer.

    Attributes
    ----------
    field : Field; of the role, by its name
    kind : str; "" for numbers of an array or a picture as they are
    offset : int; bytes from the beginning of an element
    count : int; numbers, of which ``component`` is the first one's place
    bits : (int, int) or None; first and last bit of a word
    unit : int; code of 1, or 0 for that of the kind
    scale, bias : (count,) or () float
    none : float or None; what stands for nothing there
    given : str; a word of `GIVEN`, or ""
    flip : bool; rows and pixels count from the bottom, as the buffer's own rows do
    column : int; of an array, at which the numbers begin
    channels : tuple of str; of a picture, one for each number
    """

    field: Field
    kind: str
    offset: int
    count: int
    component: int
    bits: tuple[int, int] | None
    unit: int
    scale: Scalars
    bias: Scalars
    normalize: bool
    none: float | None
    given: str
    flip: bool
    column: int
    channels: tuple[str, ...]

    @property
    def values(self) -> int:
        """Values of its kind that follow one another."""
        return self.count // KINDS[self.kind].columns

    @property
    def end(self) -> int:
        """Byte of an element at which it ends."""
        return self.offset + self.values * KINDS[self.kind].size if self.kind else 0


@dataclass(frozen=True, slots=True)
class Buffer:
    """A table of ``buffers``; its attributes are the keys of the schema.

    Attributes
    ----------
    layout : str; "fields" where there is none
    tile : (int, int) or None; None: rows
    stride, row_pitch : int; 0 where they are not given
    """

    name: str
    role: str
    file: str
    frames: tuple[int, ...]
    member: str
    part: str
    layout: str
    fields: tuple[StoredField, ...]
    stride: int
    offset: int
    byte_order: Literal["<", ">"]
    tile: tuple[int, int] | None
    flip: bool
    row_pitch: int
    slots: int
    slot: int

    @property
    def is_bytes(self) -> bool:
        """Whether its fields are bits of elements, not numbers of an array."""
        return bool(self.fields[0].kind)

    def path(self, frame: int) -> str:
        """Name of its file in a frame."""
        return FRAME.sub(lambda m: f"{frame:0{m[1] or 1}}", self.file)


@dataclass(frozen=True, slots=True)
class CapturedCamera:
    """What leads from a depth to a position: a matrix, or a pinhole.

    Attributes
    ----------
    inverse : (4, 4) float64 or None; from clip space to the world, for columns
    clip_y_down, clip_depth_signed : bool; of clip space
    """

    inverse: Scalars | None
    clip_y_down: bool
    clip_depth_signed: bool
    pinhole: Camera | None


@dataclass(frozen=True, slots=True)
class Manifest:
    """``capture.toml``, judged.

    Attributes
    ----------
    frames : tuple of int; numbers in order
    cameras : tuple of CapturedCamera; one for each frame, or none
    buffers : tuple of Buffer; as they stand
    passes : mapping of str to mapping; settings of each pass, and what it reads
    """

    width: int
    height: int
    frames: tuple[int, ...]
    declaration: str | None
    scene: str | None
    cameras: tuple[CapturedCamera, ...]
    buffers: tuple[Buffer, ...]
    passes: Mapping[str, Mapping[str, Any]]


def length_of(field: Field, given: str | None) -> int:
    """Numbers that the whole of a field has; 0 where the manifest decides."""
    pair = 2 if given in PAIRS else 1
    if field.columns == ():
        return pair
    return int(field.columns[0]) * pair if isinstance(field.columns[0], int) else 0


def count_of(table: Mapping[str, Any], field: Field, kind: NumberKind | None) -> int:
    """Numbers that one table gives."""
    if "count" in table:
        return int(table["count"])
    if kind is not None and kind.columns > 1:
        return kind.columns
    if "channels" in table:
        return len(table["channels"])
    given = table.get("given")
    if "component" in table:
        return 2 if given in PAIRS else 1
    return length_of(field, given) or (2 if given in PAIRS else 1)


# ---------------------------------------------------------------- from tables


def described(data: Mapping[str, Any]) -> Manifest:
    """What a manifest describes that has nothing wrong in its tables."""
    frames = tuple(data["frames"])
    width, height = int(data["width"]), int(data["height"])
    cameras = tuple(_camera(table, width, height) for table in data.get("cameras", []))
    return Manifest(
        width=width,
        height=height,
        frames=tuple(int(number) for number in frames),
        declaration=data.get("declaration"),
        scene=data.get("scene"),
        cameras=cameras * len(frames) if len(cameras) == 1 else cameras,
        buffers=tuple(
            _buffer(name, table, frames) for name, table in data["buffers"].items()
        ),
        passes=data.get("passes", {}),
    )


def _camera(table: Mapping[str, Any], width: int, height: int) -> CapturedCamera:
    matrix = table.get("inverse_view_projection")
    inverse = None if matrix is None else np.array(matrix, float)
    if inverse is not None and table.get("row_vectors"):
        inverse = inverse.T
    return CapturedCamera(
        inverse=inverse,
        clip_y_down=table.get("clip_y") == "down",
        clip_depth_signed=table.get("clip_depth") == "-1 to 1",
        pinhole=None if matrix is not None else pinhole(table, width, height),
    )


def pinhole(table: Mapping[str, Any], width: int, height: int) -> Camera:
    """The camera of a table without a matrix."""
    return Camera(
        position=_vector(table["position"]),
        target=_vector(table["target"]),
        up=_vector(table.get("up", (0.0, 1.0, 0.0))),
        fov=float(table.get("fov", 60.0)),
        fov_axis=table.get("fov_axis", "x"),
        width=width,
        height=height,
        mirrored=bool(table.get("mirrored")),
    )


def _vector(numbers: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = map(float, numbers)
    return x, y, z


def _buffer(name: str, table: Mapping[str, Any], frames: Sequence[int]) -> Buffer:
    word = table.get("role", name)
    role = role_of(word)
    assert role is not None
    layout = LAYOUTS.get(table.get("layout", ""))
    tables = layout.fields if layout else table["fields"]
    fields = tuple(_stored(one, role, bool(table.get("flip"))) for one in tables)
    tile: tuple[int, int] | None = None
    if "order" in table:
        width, height = table.get("tile", TILE)
        tile = (int(width), int(height)) if table["order"] == "tiles" else None
    elif layout:
        tile = layout.tile
    stride = layout.stride if layout else max(field.end for field in fields)
    return Buffer(
        name=name,
        role=word,
        file=table.get("file", ""),
        frames=tuple(table.get("frames", frames)),
        member=table.get("member", ""),
        part=table.get("part", ""),
        layout=table.get("layout", "fields"),
        fields=fields,
        stride=int(table.get("stride", stride)),
        offset=int(table.get("offset", 0)),
        byte_order="<" if table.get("byte_order", "little") == "little" else ">",
        tile=tile,
        flip=bool(table.get("flip")),
        row_pitch=int(table.get("row_pitch", 0)),
        slots=int(table.get("slots", 1)),
        slot=int(table.get("slot", 0)),
    )


def _stored(table: Mapping[str, Any], role: Role, flip: bool) -> StoredField:
    field = role.field(table["name"])
    assert field is not None
    name, kind = table.get("kind", ""), KINDS.get(table.get("kind", ""))
    bits = table.get("bits")
    given = table.get("given") or GIVEN.get(field.name, ("",))[0]
    none = table.get("none")
    if none is None and given in ("view", "distance"):
        none = 0.0
    return StoredField(
        field=field,
        kind=name,
        offset=int(table.get("offset", 0)),
        count=count_of(table, field, kind),
        component=int(table.get("component", 0)),
        bits=None if bits is None else (int(bits[0]), int(bits[1])),
        unit=int(table.get("unit", 0)),
        scale=np.array(table.get("scale", 1.0), float),
        bias=np.array(table.get("bias", 0.0), float),
        normalize=bool(table.get("normalize")),
        none=none,
        given=given,
        flip=flip,
        column=int(table.get("column", 0)),
        channels=tuple(table.get("channels", ())),
    )
