"""Bytes of a buffer as elements, one for each pixel, in the order of a frame's rows."""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.capture.description import TILE, Buffer
from restir_gi.reference.system.errors import UsageError

MOST_HEADER = 4096
"""Bytes before the first element that a message takes for a header."""

Bytes = NDArray[np.uint8]


def element_index(
    width: int, height: int, tile: tuple[int, int] | None, flip: bool
) -> Indices:
    """Where the element of each pixel stands in a buffer, (N,) int64.

    Parameters
    ----------
    tile : (int, int) or None
        Pixels of a tile: tiles follow each other in rows of tiles, and within a tile
        the pixels in rows; tiles at the right and lower edge are whole.
    flip : bool; the bottom row comes first
    """
    y, x = np.divmod(np.arange(width * height), width)
    y = height - 1 - y if flip else y
    index: Indices = y * width + x
    if tile is not None:
        across = -(-width // tile[0])
        number = (y // tile[1]) * across + x // tile[0]
        index = (number * tile[1] + y % tile[1]) * tile[0] + x % tile[0]
    return index


def elements_of(width: int, height: int, tile: tuple[int, int] | None) -> int:
    """Elements of a slot: pixels, and those that fill the tiles at the edges."""
    if tile is None:
        return width * height
    return -(-width // tile[0]) * -(-height // tile[1]) * tile[0] * tile[1]


def wanted_bytes(buffer: Buffer, width: int, height: int) -> int:
    """Bytes that a buffer should have."""
    if buffer.row_pitch:
        return buffer.offset + buffer.slots * height * buffer.row_pitch
    elements = elements_of(width, height, buffer.tile)
    return buffer.offset + buffer.slots * elements * buffer.stride


def elements(contents: bytes, buffer: Buffer, width: int, height: int) -> Bytes:
    """Elements of the pixels, row by row.

    Raises UsageError: the size is another one; the message says what would fit.

    Returns
    -------
    (N, stride) uint8
    """
    _refuse_other_sizes(len(contents), buffer, width, height)
    index = element_index(width, height, buffer.tile, buffer.flip)
    stride, pitch = buffer.stride, buffer.row_pitch or width * buffer.stride
    data = np.frombuffer(contents, np.uint8)
    if buffer.tile is not None:
        data = data[buffer.offset :].reshape(buffer.slots, -1, stride)[buffer.slot]
    else:
        whole = np.zeros(buffer.slots * height * pitch, np.uint8)
        whole[: len(contents) - buffer.offset] = data[buffer.offset :]
        slot = whole.reshape(buffer.slots, height, pitch)[buffer.slot]
        data = slot[:, : width * stride].reshape(-1, stride)
    found: Bytes = data[index]
    return found


def _refuse_other_sizes(size: int, buffer: Buffer, width: int, height: int) -> None:
    wanted = wanted_bytes(buffer, width, height)
    # The last row of a texture may end where its pixels do.
    cut = buffer.row_pitch - width * buffer.stride if buffer.row_pitch else 0
    if size not in (wanted, wanted - cut):
        raise UsageError(
            f"has {size:,} bytes where {_product(buffer, width, height)} make"
            f" {wanted:,}; {_fitting(size, buffer, width, height)}"
        )


def _product(buffer: Buffer, width: int, height: int) -> str:
    """What the size of a buffer is made of, in words."""
    start = f"{buffer.offset:,} bytes and " if buffer.offset else ""
    slots = f"{buffer.slots} slots of " if buffer.slots > 1 else ""
    if buffer.row_pitch:
        return f"{start}{slots}{height:,} rows of {buffer.row_pitch:,} bytes"
    count = elements_of(width, height, buffer.tile)
    tiles = ""
    if buffer.tile is not None:
        tiles = f" in tiles of {buffer.tile[0]}x{buffer.tile[1]}"
    return f"{start}{slots}{count:,} pixels{tiles} of {buffer.stride:,} bytes"


def _fitting(size: int, buffer: Buffer, width: int, height: int) -> str:
    """What of the description would have to be another one."""
    body, stride = size - buffer.offset, buffer.stride
    count = elements_of(width, height, buffer.tile)
    tile = TILE if buffer.tile is None else None
    word = "rows" if tile is None else "tiles"
    fits = {
        f"stride = {body // (buffer.slots * count)}": (
            not buffer.row_pitch and body % (buffer.slots * count) == 0
        ),
        f"slots = {body // (stride * count)}": (
            not buffer.row_pitch and body % (stride * count) == 0
        ),
        f'order = "{word}"': (
            not buffer.row_pitch
            and body == buffer.slots * stride * elements_of(width, height, tile)
        ),
        f"row_pitch = {body // (buffer.slots * height)}": (
            buffer.tile is None
            and body % (buffer.slots * height) == 0
            and body > buffer.slots * count * stride
        ),
    }
    found = [key for key, is_right in fits.items() if is_right and body > 0]
    before = size - wanted_bytes(buffer, width, height) + buffer.offset
    if 0 <= before <= MOST_HEADER:
        found.append(f"offset = {before}")
    if not found:
        return "is it whole, and of this size of image?"
    return f"what would fit is {', or '.join(found)}"
