"""Bands and threads: how a frame is cut, which never changes a bit of it."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from reference.records import map_rows

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Schedule:
    """How a frame is cut.

    Attributes
    ----------
    band : int
        Rows handled at once; 8192 keep the temporaries of a pass in the cache.
    threads : int
        Bands handled at the same time.  NumPy and Embree release the interpreter
        lock for arrays of this size.
    """

    band: int = 8192
    threads: int = 1


def bands(rows: int, size: int) -> Iterator[slice]:
    """Cut rows into bands.

    Parameters
    ----------
    rows : int
        Rows of the frame.
    size : int
        Rows of a band; the last may have fewer.

    Yields
    ------
    slice
        In order, without gap or overlap.
    """
    for start in range(0, rows, size):
        yield slice(start, min(start + size, rows))


def in_bands(
    schedule: Schedule, rows: int, function: Callable[[slice], Result]
) -> Result:
    """Apply a function of rows to a frame, band by band.

    Parameters
    ----------
    schedule : Schedule
        Bands and threads.
    rows : int
        Rows of the frame.
    function : callable
        Takes a slice of K row numbers and returns a record (or array) of K rows, each
        of which depends on its own row number alone.

    Returns
    -------
    record or array
        All rows; bit-identical for every schedule.
    """
    cuts = list(bands(rows, schedule.band))
    first = function(cuts[0])
    if len(cuts) == 1:
        return first
    # Each band is copied into the whole frame as soon as it is done, so that the frame
    # exists once, not once in pieces and once joined.
    whole = map_rows(lambda a: np.empty((rows, *a.shape[1:]), a.dtype, "F"), first)

    def put(cut: slice, part: Any) -> None:
        def copy(out: Any, values: Any) -> Any:
            out[cut] = values
            return out

        map_rows(copy, whole, part)

    put(cuts[0], first)
    del first
    if schedule.threads == 1:
        for cut in cuts[1:]:
            put(cut, function(cut))
        return whole
    with ThreadPoolExecutor(schedule.threads) as pool:
        jobs = [
            pool.submit(lambda rows: put(rows, function(rows)), cut) for cut in cuts[1:]
        ]
        for job in jobs:
            job.result()
    return whole
