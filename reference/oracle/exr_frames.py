"""Buffers of a case as the parts of one OpenEXR file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from restir_gi.reference.images.exr_parts import decode
from restir_gi.reference.oracle.cases import Case, Failure, output_shapes, pass_of
from restir_gi.reference.oracle.contract.fields import Passes, dtype_of
from restir_gi.reference.oracle.raw import MOST_MORE, MOST_TIMES, outputs_size
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

VECTOR = ("R", "G", "B")


def write_frames(path: Path, width: int, buffers: Mapping[str, NDArray[Any]]) -> None:
    """Write buffers of an image, each a part of its own.

    Parameters
    ----------
    buffers : mapping of str to array
        float32, uint32 or int32, which becomes the word of the same bits.  Three
        columns are R, G, B; one is Y; others are numbered.
    """
    parts = [_part(name, width, array) for name, array in buffers.items()]
    OpenEXR.File(parts).write(str(path))


def read_frames(
    path: Path, passes: Passes, case: Case
) -> dict[str, NDArray[Any]] | Failure:
    """Read the outputs that a backend has written as parts of one file.

    They are of the types of single precision.
    """
    try:
        promised = outputs_size(passes, "float32", case)
        contents = read_file(path, MOST_TIMES * promised + MOST_MORE)
        decoded = decode(path, contents, case.rows)
    except UsageError as error:
        return Failure(f"{case.name}: {error}")
    parts = {part.name(): part.channels for part in decoded}
    found: dict[str, NDArray[Any]] = {}
    asked, shapes = pass_of(passes, case), output_shapes(passes, case)
    for field in (*asked.outputs, *asked.terms):
        if field.name not in parts:
            continue
        shape, channels = shapes[field.name], parts[field.name]
        names = _channels(shape)
        if sorted(channels) != sorted(names):
            return Failure(
                f"{case.name}: part {field.name} has channels {', '.join(channels)}"
                f" instead of {', '.join(names)}"
            )
        columns = [channels[name].pixels.reshape(-1) for name in names]
        array = np.stack(columns, axis=-1)
        if array.size != np.prod(shape):
            return Failure(f"{case.name}: part {field.name} has another size")
        wanted = dtype_of(field.kind, "float32")
        if field.kind == "index" and array.dtype == np.uint32:
            array = array.view(wanted)
        found[field.name] = array.reshape(shape)
    return found


def _channels(shape: tuple[int, ...]) -> tuple[str, ...]:
    columns = int(np.prod(shape[1:]))
    if columns == 1:
        return ("Y",)
    return VECTOR if columns == 3 else tuple(f"C{k:02d}" for k in range(columns))


def _part(name: str, width: int, array: NDArray[Any]) -> Any:
    pixels = np.ascontiguousarray(array)
    if pixels.dtype == np.int32:
        pixels = pixels.view(np.uint32)
    names = _channels(array.shape)
    columns = pixels.reshape(-1, width, len(names))
    channels = {
        channel: np.ascontiguousarray(columns[:, :, k])
        for k, channel in enumerate(names)
    }
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    return OpenEXR.Part(header, channels, name)
