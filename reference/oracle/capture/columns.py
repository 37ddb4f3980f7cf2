"""Bytes, arrays and pictures as columns of numbers, by the fields of a buffer."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.capture.contents import Picture
from restir_gi.reference.oracle.capture.description import Buffer, StoredField
from restir_gi.reference.oracle.capture.elements import (
    Bytes,
    element_index,
    elements,
    elements_of,
)
from restir_gi.reference.oracle.capture.kinds import KINDS
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown

Numbers = NDArray[Any]
Contents = bytes | Numbers | Picture


@dataclass(frozen=True, slots=True)
class DecodedField:
    """A field of a buffer, decoded.

    Attributes
    ----------
    stored : (N, count) array
        What was stored, to be held against the number that stands for nothing; of
        vectors of one kind what they were decoded to.
    values : (N, count) array; decoded and scaled
    """

    field: StoredField
    stored: Numbers
    values: Numbers


@dataclass(frozen=True, slots=True)
class Column:
    """All numbers of a name, of one or several fields.

    Attributes
    ----------
    fields : tuple of StoredField; in the order of their components
    stored, values : (N, count) array; as of `DecodedField`
    """

    fields: tuple[StoredField, ...]
    stored: Numbers
    values: Numbers

    @property
    def kind(self) -> str:
        """Kind of number that it was stored in."""
        return self.fields[0].kind or self.stored.dtype.name


def parts_of(
    buffer: Buffer, contents: Contents, width: int, height: int
) -> tuple[list[DecodedField], Bytes | None]:
    """Fields of a buffer, in the order of a frame's rows, and the bytes of the rows.

    Raises UsageError: the buffer has another size, or lacks columns or channels.

    Returns
    -------
    parts, words : list of DecodedField, (N, stride) uint8 or None
    """
    if isinstance(contents, Picture):
        return _of_picture(contents, buffer, width, height), None
    if not buffer.is_bytes:
        return _of_array(np.asarray(contents), buffer, width, height), None
    whole = contents if isinstance(contents, bytes) else contents.tobytes()
    rows = elements(whole, buffer, width, height)
    return [_decoded(field, rows, buffer) for field in buffer.fields], rows


def _decoded(field: StoredField, rows: Bytes, buffer: Buffer) -> DecodedField:
    kind = KINDS[field.kind]
    dtype = np.dtype(kind.dtype).newbyteorder(buffer.byte_order)
    bytes_ = np.ascontiguousarray(rows[:, field.offset : field.end])
    codes = bytes_.view(dtype).astype(kind.dtype)
    if field.bits is not None:
        first, last = field.bits
        mask = np.uint64(2 ** (last - first + 1) - 1)
        codes = codes.astype(np.uint64) >> np.uint64(first) & mask
    values = kind.decode(codes, field.unit or kind.unit)
    if kind.columns > 1 and codes.dtype.kind == "f":
        # Clamped and folded, what is not finite would be hidden.
        values = np.where(np.isfinite(codes).all(axis=1)[:, None], values, np.nan)
    stored = values if kind.columns > 1 else codes
    return DecodedField(field, stored, _scaled(field, values))


def _of_array(
    array: Numbers, buffer: Buffer, width: int, height: int
) -> list[DecodedField]:
    """Fields of an array that has their numbers as they are."""
    if array.dtype.kind not in "biuf" or array.dtype.itemsize > 8:
        raise UsageError(f"has {array.dtype}; give its fields a `kind`")
    count = buffer.slots * elements_of(width, height, buffer.tile)
    is_image = array.shape[:2] == (height, width) and count == width * height
    if array.shape[:1] != (count,) and not is_image:
        raise UsageError(
            f"has the shape {array.shape}; it should begin with {count}, or with"
            f" {height}, {width}"
        )
    flat = array.reshape(count, -1)
    most = max(field.column + field.count for field in buffer.fields)
    if flat.shape[1] < most:
        raise UsageError(f"has {flat.shape[1]} columns, and its fields take {most}")
    index = element_index(width, height, buffer.tile, buffer.flip)
    rows = flat.reshape(buffer.slots, -1, flat.shape[1])[buffer.slot][index]
    return [
        _as_they_are(field, rows[:, field.column : field.column + field.count])
        for field in buffer.fields
    ]


def _of_picture(
    picture: Picture, buffer: Buffer, width: int, height: int
) -> list[DecodedField]:
    """Fields of channels of a picture."""
    parts = []
    for field in buffer.fields:
        for name in field.channels:
            if name not in picture.channels:
                raise UsageError(unknown("channel", name, picture.channels))
        pixels = [picture.channels[name] for name in field.channels]
        if pixels[0].shape != (height, width):
            found = "x".join(map(str, reversed(pixels[0].shape)))
            raise UsageError(f"has {found} pixels; it should have {width}x{height}")
        index = element_index(width, height, None, buffer.flip)
        rows = np.stack([channel.reshape(-1) for channel in pixels], axis=-1)
        parts.append(_as_they_are(field, rows[index]))
    return parts


def _as_they_are(field: StoredField, numbers: Numbers) -> DecodedField:
    return DecodedField(field, numbers, _scaled(field, numbers))


def _scaled(field: StoredField, values: Numbers) -> Numbers:
    if (field.scale == 1).all() and not field.bias.any():
        return values
    with np.errstate(over="ignore", invalid="ignore"):
        scaled: Numbers = values * field.scale + field.bias
    return scaled


def joined(parts: Sequence[DecodedField]) -> Column:
    """One column of the fields that give its numbers."""
    parts = sorted(parts, key=lambda part: part.field.component)
    fields = tuple(part.field for part in parts)
    if len(parts) == 1:
        return Column(fields, parts[0].stored, parts[0].values)
    stored = np.hstack([part.stored for part in parts])
    return Column(fields, stored, np.hstack([part.values for part in parts]))


def refuse_what_is_not_finite(column: Column, width: int) -> None:
    """Raise where a column has NaN or infinity.

    Raises ValueError: it has; with the number, the count, and the first pixel.
    """
    wrong: Masks = ~(np.isfinite(column.values) & np.isfinite(column.stored))
    if not wrong.any():
        return
    pixels = np.asarray(wrong.any(axis=1))
    first = int(pixels.argmax())
    value = column.values[first][wrong[first]][0]
    y, x = divmod(first, width)
    raise ValueError(
        f"is {value} in {int(pixels.sum()):,} of {pixels.size:,} pixels, the first of"
        f" them ({x}, {y}); numbers should be finite"
    )
