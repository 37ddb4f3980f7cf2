"""Where the numbers of a buffer come from: files, and arrays of Python."""

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.exr_parts import decode
from restir_gi.reference.oracle.capture.description import Buffer
from restir_gi.reference.oracle.capture.elements import wanted_bytes
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import MOST_BYTES, read_file
from restir_gi.reference.system.suggestions import unknown

MOST_TIMES, MOST_MORE = 4, 2**16
"""Bytes that a file may have: so many times what is wanted, and more for what stands
around the numbers."""

Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Picture:
    """A part of an OpenEXR file, by channel.

    Attributes
    ----------
    channels : mapping of str to (H, W) array
    """

    channels: Mapping[str, Array]


def read_buffer(
    folder: Path, buffer: Buffer, frame: int, width: int, height: int
) -> bytes | Array | Picture:
    """What the file of a buffer holds in one frame: bytes, an array, or a picture.

    Raises UsageError: there is no such file, or it is too large or damaged.
    """
    path = folder / buffer.path(frame)
    wanted = most_wanted(buffer, width, height)
    most = min(MOST_TIMES * wanted + MOST_MORE, MOST_BYTES)
    suffix = path.suffix.lower()
    contents = read_file(path, most)
    if suffix == ".exr":
        return _picture(path, contents, buffer, width * height)
    if suffix == ".npz":
        return _member(path, contents, buffer, most)
    if suffix == ".npy":
        return _array(path, contents)
    return contents


def most_wanted(buffer: Buffer, width: int, height: int) -> int:
    """Bytes that a buffer may need, at 8 for each number of an array."""
    if buffer.is_bytes:
        return wanted_bytes(buffer, width, height)
    columns = max(field.column + field.count for field in buffer.fields)
    return 8 * columns * width * height * buffer.slots


def _picture(path: Path, contents: bytes, buffer: Buffer, pixels: int) -> Picture:
    parts = {str(part.name()): part for part in decode(path, contents, pixels)}
    name = buffer.part or next(iter(parts))
    if name not in parts:
        raise UsageError(f"{path}: {unknown('part', name, parts)}")
    if not buffer.part and len(parts) > 1:
        raise UsageError(f"{path} has several parts: {', '.join(parts)}; name one")
    channels = parts[name].channels
    return Picture({str(key): np.array(channels[key].pixels) for key in channels})


def _member(path: Path, contents: bytes, buffer: Buffer, most: int) -> Array:
    # Damage shows as whatever the reader trips over first.
    try:
        with ZipFile(BytesIO(contents)) as file:
            names = [n.removesuffix(".npy") for n in file.namelist()]
            name = buffer.member or (names[0] if len(names) == 1 else "")
            if name in names:
                size = file.getinfo(f"{name}.npy").file_size
                if size > most:
                    raise ValueError(f"{name} has {size:,} bytes; {most:,} are allowed")
                return _loaded(file.read(f"{name}.npy"))
    except Exception as error:
        words = str(error) or type(error).__name__
        raise UsageError(f"{path} cannot be read: {words}; write it again") from error
    if not buffer.member:
        raise UsageError(f"{path} has {len(names)} arrays; name one as `member`")
    raise UsageError(f"{path}: {unknown('member', buffer.member, names)}")


def _array(path: Path, contents: bytes) -> Array:
    try:
        return _loaded(contents)
    except Exception as error:
        words = str(error) or type(error).__name__
        raise UsageError(f"{path} cannot be read: {words}; write it again") from error


def _loaded(contents: bytes) -> Array:
    array: Array = np.load(BytesIO(contents), allow_pickle=False)
    if array.dtype.hasobject or array.dtype.kind not in "biufV":
        raise ValueError(f"it holds {array.dtype}, and no numbers")
    return array
