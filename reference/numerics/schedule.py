"""Bands and threads: how a frame is cut, which never changes a bit of it."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from restir_gi.reference.numerics.records import map_rows

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Schedule:
    """How a frame is cut.

    Attributes
    ----------
    band : int
        Rows handled at once.  More rows share the cost of each call, fewer stay in the
        cache; between 8192 and 32768 it makes no difference to one thread, while two
        want long calls, in which they do not wait for the interpreter lock.
    threads : int; bands handled at the same time
    """

    band: int = 32768
    threads: int = 1


def bands(rows: int, size: int) -> Iterator[slice]:
    """Cut rows into bands, in order, without gap or overlap.

    Parameters
    ----------
    size : int; rows of a band; the last may have fewer
    """
    for start in range(0, rows, size):
        yield slice(start, min(start + size, rows))


def in_bands(
    schedule: Schedule, rows: int, function: Callable[[slice], Result]
) -> Result:
    """Apply a function of rows to a frame, band by band.

    The rows are bit-identical for every schedule.

    Parameters
    ----------
    function : callable
        Takes a slice of K row numbers and returns a record (or array) of K rows, each
        of which depends on its own row number alone.
    """
    cuts = list(bands(rows, schedule.band)) or [slice(0, 0)]
    if len(cuts) == 1:
        return function(cuts[0])
    whole = _Whole[Result](rows)
    if schedule.threads == 1:
        for cut in cuts:
            whole.put(cut, function(cut))
        return whole.record
    with ThreadPoolExecutor(schedule.threads) as pool:
        jobs = [
            pool.submit(lambda cut: whole.put(cut, function(cut)), cut) for cut in cuts
        ]
        try:
            for job in jobs:
                job.result()
        finally:
            # After Ctrl-C, or a fault in one band, the others need not begin.
            pool.shutdown(wait=False, cancel_futures=True)
    return whole.record


class _Whole(Generic[Result]):
    """A frame into which each band is copied as soon as it is done.

    So the frame exists once, not once in pieces and once joined.
    """

    def __init__(self, rows: int) -> None:
        self._record: Result | None = None
        self._rows, self._lock = rows, threading.Lock()

    def put(self, cut: slice, part: Result) -> None:
        """Copy a band to its place."""

        def reserve(a: Any) -> Any:
            return np.empty((self._rows, *a.shape[1:]), a.dtype, "F")

        def copy(out: Any, values: Any) -> Any:
            out[cut] = values
            return out

        with self._lock:
            if self._record is None:
                self._record = map_rows(reserve, part)
        map_rows(copy, self._record, part)

    @property
    def record(self) -> Result:
        """The frame, after the last band."""
        assert self._record is not None
        return self._record
