"""What is wrong with a manifest that has the right form, a line each."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from restir_gi.reference.oracle.capture.description import (
    FRAME,
    GIVEN,
    PAIRS,
    Manifest,
    StoredField,
    count_of,
    length_of,
    pinhole,
)
from restir_gi.reference.oracle.capture.faults import shown
from restir_gi.reference.oracle.capture.kinds import KINDS, NumberKind
from restir_gi.reference.oracle.capture.roles import ROLES, Role, role_of
from restir_gi.reference.oracle.contract.fields import Field
from restir_gi.reference.system.suggestions import unknown

Table = Mapping[str, Any]

OF_MATRIX = ("inverse_view_projection", "row_vectors", "clip_y", "clip_depth")
OF_BYTES = (
    "stride",
    "offset",
    "byte_order",
    "order",
    "tile",
    "row_pitch",
    "slots",
    "slot",
)
SUFFIXES = (".npy", ".npz", ".exr")


def faults_of_tables(data: Table, of_files: bool) -> Iterator[str]:
    """What is wrong with each table by itself.

    Parameters
    ----------
    data : mapping; of the schema's form
    of_files : bool; buffers have files; else they are given as arrays
    """
    frames = data["frames"]
    if any(a >= b for a, b in pairwise(frames)):
        yield f"frames is {shown(frames)}; each number should be above the one before"
    yield from _faults_of_cameras(data.get("cameras", []), len(frames))
    for name, table in data["buffers"].items():
        for fault in _faults_of_buffer(name, table, frames, of_files):
            yield f"buffers.{name}{fault}"


def faults_of_roles(manifest: Manifest) -> Iterator[str]:
    """What is wrong with tables beside each other."""
    for buffer in manifest.buffers:
        end = max(field.end for field in buffer.fields)
        if buffer.is_bytes and buffer.stride < end:
            yield (
                f"buffers.{buffer.name}.stride is {buffer.stride}, and its fields end"
                f" at byte {end}; give at least that"
            )
        if buffer.row_pitch and buffer.row_pitch < manifest.width * buffer.stride:
            yield (
                f"buffers.{buffer.name}.row_pitch is {buffer.row_pitch}, and a row has"
                f" {manifest.width * buffer.stride} bytes; give at least that"
            )
    found: dict[str, None] = {}
    for frame in manifest.frames:
        # What is wrong in each frame is told once.
        found |= dict.fromkeys(_faults_of_frame(manifest, frame))
    yield from found


# ---------------------------------------------------------------- cameras


def _faults_of_cameras(cameras: Sequence[Table], frames: int) -> Iterator[str]:
    if len(cameras) not in (0, 1, frames):
        yield (
            f"cameras has {len(cameras)} entries for {frames} frames; give one for all,"
            " or one for each"
        )
    for k, camera in enumerate(cameras):
        is_matrix = "inverse_view_projection" in camera
        kind = "a matrix" if is_matrix else "a pinhole"
        foreign = [key for key in camera if (key in OF_MATRIX) != is_matrix]
        if foreign:
            yield f"cameras[{k}].{foreign[0]} is not for {kind}; leave it out"
        elif is_matrix and not _has_inverse(camera["inverse_view_projection"]):
            yield (
                f"cameras[{k}].inverse_view_projection has no inverse itself; give the"
                " inverse of projection times view"
            )
        elif not is_matrix and not {"position", "target"} <= set(camera):
            yield f"cameras[{k}] lacks inverse_view_projection, or position and target"
        elif not is_matrix and not _has_view(camera):
            yield (
                f"cameras[{k}] has no view; position should not be target, nor up along"
                " the view"
            )


def _has_inverse(rows: Sequence[Sequence[float]]) -> bool:
    matrix = np.array(rows, float)
    largest = float(abs(matrix).max())
    return largest > 0 and bool(abs(np.linalg.det(matrix / largest)) > 0)


def _has_view(table: Table) -> bool:
    with np.errstate(all="ignore"):
        axes = pinhole(table, 1, 1).axes
        return all(bool(abs(np.linalg.norm(axis) - 1) < 1e-6) for axis in axes)


# ---------------------------------------------------------------- buffers


def _faults_of_buffer(
    name: str, table: Table, frames: Sequence[int], of_files: bool
) -> Iterator[str]:
    """What is wrong with one buffer, to be put behind its name."""
    word = table.get("role", name)
    role = role_of(word)
    if role is None:
        known = unknown("role", word, [*ROLES, "targets_NAME"])
        yield f".role: {known}" if "role" in table else f" has no `role`; {known}"
        return
    form = _form(table) if of_files else "array"
    if of_files:
        yield from _faults_of_file(table, form)
    stray = [number for number in table.get("frames", []) if number not in frames]
    if stray:
        yield f".frames has {stray[0]}, which `frames` of the manifest has not"
    if ("layout" in table) == ("fields" in table):
        which = "both" if "layout" in table else "neither"
        yield f" has {which} of `layout` and `fields`; give one"
        return
    yield from _faults_of_order(table, form)
    if "layout" in table and role.field("W") is None:
        yield f".layout is of reservoirs, and {word} has none; give `fields`"
    elif "layout" in table and form == ".exr":
        yield ".layout is of bytes, which a picture has not; give `fields`"
    fields = table.get("fields", [])
    if len({"kind" in field for field in fields}) > 1:
        yield ".fields have `kind` in part; give it to all, or to none"
        return
    for k, field in enumerate(fields):
        for fault in _faults_of_field(field, role, form):
            yield f".fields[{k}]{fault}"


def _form(table: Table) -> str:
    """What a file is: ``.npy``, ``.npz``, ``.exr``, or "" for bytes."""
    suffix = Path(table.get("file", "")).suffix.lower()
    return suffix if suffix in SUFFIXES else ""


def _faults_of_file(table: Table, form: str) -> Iterator[str]:
    if "file" not in table:
        yield " lacks `file`"
        return
    file = table["file"]
    if set("{}") & set(FRAME.sub("", file)):
        yield f".file is {shown(file)}; in braces it should have {{frame}} alone"
    if Path(file).is_absolute() or ".." in Path(file).parts or "\0" in file:
        yield f".file is {shown(file)}; it should be a name below the manifest's folder"
    for key, suffix in (("member", ".npz"), ("part", ".exr")):
        if key in table and form != suffix:
            yield f".{key} is for {suffix} files; leave it out"


def _faults_of_order(table: Table, form: str) -> Iterator[str]:
    if table.get("slot", 0) >= table.get("slots", 1):
        yield (
            f".slot is {table['slot']}; it should be below `slots`, which is"
            f" {table.get('slots', 1)}"
        )
    default = "tiles" if table.get("layout") == "rtxdi" else "rows"
    is_tiled = table.get("order", default) == "tiles"
    if "tile" in table and "order" not in table:
        yield '.tile is for order = "tiles"; give that, too'
    elif "tile" in table and not is_tiled:
        yield '.tile is for order = "tiles"; leave it out'
    if "row_pitch" in table and is_tiled:
        yield '.row_pitch is for order = "rows"; leave it out'
    of_numbers = "fields" in table and not any("kind" in f for f in table["fields"])
    refused: tuple[str, ...]
    if form == ".exr":
        refused = OF_BYTES
    elif of_numbers and form:
        refused = ("stride", "offset", "byte_order", "row_pitch")
    else:
        return
    for key in refused:
        if key in table:
            yield f".{key} is for bytes; leave it out"


# ---------------------------------------------------------------- fields


def _faults_of_field(table: Table, role: Role, form: str) -> Iterator[str]:
    """What is wrong with one field, to be put behind its number."""
    field = role.field(table["name"])
    if field is None:
        names = [field.name for field in role.fields]
        yield f".name: {unknown('field', table['name'], names)}"
        return
    kind = KINDS.get(table.get("kind", ""))
    is_picture = form == ".exr"
    if kind is None and form == "":
        yield f" lacks `kind`, which bytes need; known are {', '.join(KINDS)}"
        return
    if is_picture and "channels" not in table:
        yield ' lacks `channels`, such as ["R", "G", "B"]'
        return
    allowed = {
        "kind": not is_picture,
        "channels": is_picture,
        "column": kind is None and not is_picture,
        "offset": kind is not None,
        "bits": kind is not None,
        "unit": kind is not None,
    }
    words = "pictures" if is_picture else "bytes" if kind else "arrays of numbers"
    for key, is_allowed in allowed.items():
        if key in table and not is_allowed:
            yield f".{key} is not for {words}; leave it out"
    if kind is not None:
        yield from _faults_of_kind(table, kind)
    yield from _faults_of_meaning(table, field, kind)


def _faults_of_kind(table: Table, kind: NumberKind) -> Iterator[str]:
    name = table["kind"]
    if "unit" in table and not kind.has_unit:
        yield f".unit is for octahedral whole numbers, and not for {name}; leave it out"
    if "bits" in table:
        first, last = table["bits"]
        most = 8 * kind.size - 1
        if not kind.is_word:
            yield f".bits is for uint8 to uint64, and not for {name}; leave it out"
        elif not first <= last <= most:
            yield (
                f".bits is {shown(table['bits'])}; it should be a first and a last of"
                f" the bits 0 to {most}"
            )
    elif name == "uint64":
        yield " lacks `bits`, such as [0, 31], which uint64 needs"


def _faults_of_meaning(
    table: Table, field: Field, kind: NumberKind | None
) -> Iterator[str]:
    """Whether what is stored can be what its name says."""
    name, given = field.name, table.get("given")
    if given is not None and given not in GIVEN.get(name, ()):
        right = "one of " + ", ".join(GIVEN[name]) if name in GIVEN else "left out"
        yield f".given is {shown(given)}; of {name} it should be {right}"
        return
    if field.kind == "bits":
        for key in ("scale", "bias"):
            if key in table:
                yield f".{key} is not for bits such as {name}; leave it out"
    if "normalize" in table and field.columns != (3,):
        yield f".normalize is for vectors, and not for {name}; leave it out"
    if "none" in table and name not in GIVEN:
        yield f".none is for {', '.join(GIVEN)}, and not for {name}; leave it out"
    yield from _faults_of_count(table, field, kind)


def _faults_of_count(
    table: Table, field: Field, kind: NumberKind | None
) -> Iterator[str]:
    name, given = field.name, table.get("given")
    length, count = length_of(field, given), count_of(table, field, kind)
    if kind is not None and kind.columns > 1:
        if length != kind.columns:
            yield f".kind is of vectors, and {name} is none; give another"
            return
        for key in ("count", "component"):
            if key in table:
                yield f".{key} is not for whole vectors of one kind; leave it out"
        return
    first = table.get("component", 0)
    if given in PAIRS and (count % 2 or first % 2):
        yield f".count is {count}; {given} are pairs of x and y: give an even number"
    elif length and first + count > length:
        yield (
            f".count is {count} from component {first} on; {name} has {length} numbers"
        )
    channels = table.get("channels")
    if channels is not None and len(channels) != count:
        yield f".channels has {len(channels)} entries; it should have {count}"
    for key in ("scale", "bias"):
        factors = table.get(key)
        if isinstance(factors, list) and len(factors) != count:
            yield f".{key} has {len(factors)} entries; it should have one, or {count}"


# ---------------------------------------------------------------- roles


def _faults_of_frame(manifest: Manifest, frame: int) -> Iterator[str]:
    """Fields that two buffers have, and vectors of which a part is missing."""
    seen: dict[tuple[str, str], list[StoredField]] = {}
    for buffer in manifest.buffers:
        if frame in buffer.frames:
            for stored in buffer.fields:
                seen.setdefault((buffer.role, stored.field.name), []).append(stored)
    for (role, name), parts in seen.items():
        yield from _faults_of_parts(f"{name} of {role}", parts)
        if name == "depth" and parts[0].given != "view":
            yield from _faults_of_depth(f"{name} of {role}", parts[0], manifest)


def _faults_of_parts(what: str, parts: list[StoredField]) -> Iterator[str]:
    parts = sorted(parts, key=lambda part: part.component)
    starts = [part.component for part in parts]
    ends = [part.component + part.count for part in parts]
    length = length_of(parts[0].field, parts[0].given) or ends[-1]
    if starts != [0, *ends[:-1]] or ends[-1] != length:
        spans = ", ".join(
            f"{start} to {end - 1}" if end - start > 1 else f"{start}"
            for start, end in zip(starts, ends, strict=True)
        )
        wanted = f"0 to {length - 1} once" if length > 1 else "one alone"
        yield f"{what} has the components {spans}; give {wanted}"
    elif len({(p.given, p.normalize, p.none, p.flip) for p in parts}) > 1:
        yield (
            f"{what} has parts that differ in given, normalize, none or flip; give them"
            " alike"
        )


def _faults_of_depth(
    what: str, stored: StoredField, manifest: Manifest
) -> Iterator[str]:
    if not manifest.cameras:
        yield f"{what} is given as {stored.given}, which needs `cameras`; give them"
    elif stored.given == "device" and any(
        camera.inverse is None for camera in manifest.cameras
    ):
        yield (
            f"{what} is that of a depth buffer, which needs a camera's"
            " inverse_view_projection; give it"
        )
