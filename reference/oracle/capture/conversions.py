"""What buffers say in other words than the contract's, in the contract's words."""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    normalize,
)
from restir_gi.reference.oracle.capture.columns import Column
from restir_gi.reference.scene.camera import pixel_centers


def as_reals(column: Column) -> Scalars:
    """A column as float64; vectors have unit length where that is asked for.

    Returns
    -------
    (N,) or (N, count) float64; 0 where what was stored stands for nothing
    """
    values = column.values.astype(np.float64)
    if column.fields[0].none is not None:
        values = np.where(column.stored == column.fields[0].none, 0.0, values)
    if column.fields[0].normalize:
        with np.errstate(over="ignore", invalid="ignore"):
            values = normalize(values)
    return values[:, 0] if column.fields[0].field.columns == () else values


def as_bits(column: Column) -> NDArray[np.uint32]:
    """A column as words, (N,) or (N, count) uint32.

    Raises ValueError: there are numbers that are no such words.
    """
    values = column.values
    with np.errstate(invalid="ignore"):
        words: NDArray[np.uint32] = values.astype(np.uint32)
    if (words != values).any():
        value = values[words != values][0]
        raise ValueError(f"has {value}, which is no whole number from 0 to 2³² − 1")
    return words[:, 0] if column.fields[0].field.columns == () else words


def as_rows(column: Column, width: int, height: int) -> tuple[NDArray[np.int64], int]:
    """A column as row numbers of an image.

    Raises ValueError: there are numbers that are no rows of the image.

    Returns
    -------
    rows : (N,) or (N, K) int64; -1 for none
    outside : int; pixels that lay outside of the image, and became -1
    """
    field = column.fields[0]
    values, none = column.values.astype(np.float64), _is_none(column)
    if field.given == "rows":
        _refuse_what_is_no_row(column, values, none, width * height)
        x, y = values % width, values // width
    else:
        x, y = values[:, 0::2], values[:, 1::2]
        none = none[:, 0::2] & none[:, 1::2]
    if field.given == "offsets":
        across, down = pixel_centers(width, height)
        # Where rows count from the bottom, so do offsets.
        x = x + across[:, None]
        y = y + (height - down if field.flip else down)[:, None]
    x, y = np.floor(x), np.floor(y)
    y = height - 1 - y if field.flip else y
    outside = ~none & ((x < 0) | (x >= width) | (y < 0) | (y >= height))
    gone = none | outside
    rows = np.where(gone, 0, y) * width + np.where(gone, 0, x)
    rows = np.where(gone, -1, rows).astype(np.int64)
    return (rows[:, 0] if field.field.columns == () else rows), int(outside.sum())


def _refuse_what_is_no_row(
    column: Column, values: Scalars, none: Masks, total: int
) -> None:
    wrong = ~none & ((values != np.floor(values)) | (values < 0) | (values >= total))
    if wrong.any():
        value = column.values[wrong][0]
        raise ValueError(
            f"is {value} in {int(wrong.sum()):,} places; it should be a row from 0 to"
            f" {total - 1:,}, or the number for none: say `none`, or `given`"
        )


def _is_none(column: Column) -> Masks:
    """Which numbers stand for nothing: as said, or -1 and words of ones.

    Of offsets nothing does by itself.
    """
    field, stored = column.fields[0], column.stored
    none = np.zeros(stored.shape, bool)
    if field.none is not None:
        none = stored == field.none
    elif field.given != "offsets":
        if stored.dtype.kind == "u":
            bits = field.bits or (0, 8 * stored.dtype.itemsize - 1)
            none = stored == 2 ** (bits[1] - bits[0] + 1) - 1
        else:
            none = stored == -1
    return none
