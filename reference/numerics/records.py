"""Records: frozen, slotted dataclasses of arrays that share their rows."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks

Record = TypeVar("Record")

NONE = -1
"""In place of a row: there is none."""


def map_rows(function: Callable[..., Any], *records: Record) -> Record:
    """Apply a function of arrays to each field of records of one type.

    Parameters
    ----------
    function : callable; takes as many arrays as there are records and returns an array
    *records : record or array
        All of one type.  Nested records are descended into; ``None`` stays ``None``.
    """
    first: Any = records[0]
    mapped: Any = None
    if isinstance(first, np.ndarray):
        mapped = function(*records)
    elif first is not None:
        columns = zip(*(_values(record) for record in records), strict=True)
        mapped = type(first)(*(map_rows(function, *column) for column in columns))
    result: Record = mapped
    return result


def _values(record: Any) -> list[Any]:
    return [getattr(record, name) for name in record.__slots__]


def take(record: Record, rows: Indices) -> Record:
    """Rows of a record (or array), by index.

    Parameters
    ----------
    record : record or array; N rows
    rows : (K,) int; which rows, in which order
    """
    return map_rows(lambda a: _take(a, rows), record)


def _take(a: Any, rows: Indices) -> Any:
    # Along the columns of Fortran order: NumPy would first copy the array into C order.
    return a.T.take(rows, axis=-1).T


def keep(record: Record, mask: Masks) -> Record:
    """Rows of a record (or array) where a mask is true.

    Parameters
    ----------
    mask : (N,) bool; which rows

    Returns
    -------
    record or array; the record itself, not a copy, where the mask is true throughout
    """
    return record if mask.all() else take(record, np.flatnonzero(mask))


def cut(record: Record, rows: slice) -> Record:
    """Consecutive rows of a record (or array): views, without a copy."""
    return map_rows(lambda a: a[rows], record)


def select(record: Record, rows: slice | Indices) -> Record:
    """Rows of a record (or array): `cut` by a slice, `take` by indices."""
    return cut(record, rows) if isinstance(rows, slice) else take(record, rows)


def indices(rows: slice | Indices) -> Indices:
    """Rows one by one, (K,) int."""
    return np.arange(rows.start, rows.stop) if isinstance(rows, slice) else rows


def where(mask: Masks, yes: Record, no: Record) -> Record:
    """Choose between two records (or arrays) row by row.

    Parameters
    ----------
    mask : (N,) bool; take ``yes`` where true
    yes, no : record or array; N rows each, of one type
    """

    def choose(a: Any, b: Any) -> Any:
        return np.where(mask, a.T, b.T).T

    return map_rows(choose, yes, no)


def pick(slot: Indices, records: Sequence[Record]) -> Record:
    """Row i of the record (or array) number slot[i].

    Parameters
    ----------
    slot : (N,) int; which of the records
    records : sequence of record or array; N rows each, all of one type
    """
    rows = [np.flatnonzero(slot == k) for k in range(1, len(records))]

    def picked(first: Any, *others: Any) -> Any:
        out = first.copy(order="K")
        for at, other in zip(rows, others, strict=True):
            out[at] = other[at]
        return out

    return map_rows(picked, *records)


def concatenate(records: list[Record]) -> Record:
    """Join records (or arrays) end to end: all rows, in the order given.

    Parameters
    ----------
    records : list of record or array; at least one, all of one type
    """
    if len(records) == 1:
        return records[0]
    return map_rows(lambda *arrays: np.concatenate(arrays), *records)


def scatter(rows: Indices, values: Record, size: int) -> Record:
    """Put K rows into a record of ``size`` rows that is 0 elsewhere.

    Parameters
    ----------
    rows : (K,) int; where each row goes; no index twice
    """

    def put(a: Any) -> Any:
        out = np.zeros((size, *a.shape[1:]), a.dtype, order="F")
        out[rows] = a
        return out

    return map_rows(put, values)


def put(record: Record, rows: Indices, values: Record) -> Record:
    """Replace some rows of a record (or array); a copy, of N rows.

    Parameters
    ----------
    record : record or array; N rows
    rows : (K,) int; which; no index twice
    values : record or array; K rows
    """

    def replaced(a: Any, b: Any) -> Any:
        out = a.copy(order="K")
        out[rows] = b
        return out

    return map_rows(replaced, record, values)


def nbytes(record: Any) -> int:
    """Memory that the arrays of a record take.

    Bytes; an array that is met twice counts once.
    """
    seen: dict[int, int] = {}
    _weigh(record, seen)
    return sum(seen.values())


def _weigh(thing: Any, seen: dict[int, int]) -> None:
    if isinstance(thing, np.ndarray):
        seen[id(thing)] = thing.nbytes
    elif isinstance(thing, Mapping):
        _weigh(list(thing.values()), seen)
    elif isinstance(thing, list | tuple):
        for part in thing:
            _weigh(part, seen)
    elif is_dataclass(thing):
        _weigh([getattr(thing, field.name) for field in fields(thing)], seen)


def fields_but(record: Any, *names: str) -> list[Any]:
    """Values of the fields of a record, but for some, in the order of the fields."""
    return [getattr(record, f.name) for f in fields(record) if f.name not in names]
