"""Words of the contract: buffers, settings and passes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import DTypeLike

Kind = Literal["real", "index", "bits"]
"""Numbers of the backend's precision; signed row numbers; words, flags and masks."""

Precision = Literal["float32", "float64"]
"""In which a backend calculates, and in which all its reals are given to it."""

Value = str | int | float
"""Of a setting."""


def dtype_of(kind: Kind, precision: Precision) -> np.dtype[np.generic]:
    """Number type of a buffer, little-endian: ``<f4`` or ``<f8``, ``<i4``, ``<u4``."""
    types: dict[Kind, DTypeLike] = {
        "real": "<f4" if precision == "float32" else "<f8",
        "index": "<i4",
        "bits": "<u4",
    }
    return np.dtype(types[kind])


@dataclass(frozen=True, slots=True)
class Field:
    """One buffer, N rows.

    Attributes
    ----------
    name : str; of the argument, of the key, and of the file
    columns : tuple of int or str
        Shape of a row: ``()`` one number, ``(3,)`` a vector, ``("K",)`` as many as
        there are neighbours, ``("K+2",)`` two more.
    kind : 'real', 'index' or 'bits'; what it holds
    only : tuple of str and tuple of str, or None
        A setting, and its values with which the buffer is given; ``None``: always.
    """

    name: str
    columns: tuple[int | str, ...]
    kind: Kind
    meaning: str
    only: tuple[str, tuple[str, ...]] | None = None


@dataclass(frozen=True, slots=True)
class Setting:
    """One number or word that holds for all rows.

    Attributes
    ----------
    values : str; what it may be, for the reader
    more : tuple of str
        Words that it may be as well, asked only of backends that declare them.
    default : str
        What it is where a case does not have it; empty for one that every case has.
    """

    name: str
    values: str
    meaning: str
    more: tuple[str, ...] = ()
    default: str = ""


@dataclass(frozen=True, slots=True)
class Pass:
    """One step of the algorithm: buffers and settings in, buffers out.

    Attributes
    ----------
    name : str; of the method, and in the case's file
    summary : str; one line, without a full stop
    formula : str; what is asked for, line by line
    inputs, outputs : tuple of Field; in the order of the documentation
    source : str; where the formula comes from
    terms : tuple of Field
        What a backend may give besides: not judged, but shown beside ours.
    clauses : tuple of str
        What the formula says, one thing at a time: each is hit by rows of the cases.
    joins : tuple of (str, str)
        Positions of points and of the sample points that they are joined to.
    """

    name: str
    summary: str
    formula: str
    inputs: tuple[Field, ...]
    outputs: tuple[Field, ...]
    settings: tuple[Setting, ...] = ()
    source: str = ""
    terms: tuple[Field, ...] = ()
    clauses: tuple[str, ...] = ()
    joins: tuple[tuple[str, str], ...] = ()

    def __hash__(self) -> int:
        """By its name: no two passes of a contract share one."""
        return hash(self.name)

    def given_with(self, settings: Mapping[str, Value]) -> "Pass":
        """The pass with those of its buffers that are given with some settings.

        So of several buffers of one name, of other shapes, one is left.
        """
        values = ((name, settings.get(name, default)) for name, default in _asked(self))
        return _given(self, tuple(values))


Passes = Mapping[str, Pass]


# Both are asked of the same few passes for every case.
@cache
def _asked(one: Pass) -> tuple[tuple[str, str], ...]:
    """Settings that say which buffers are given, and what they are if left out."""
    fields = (*one.inputs, *one.outputs, *one.terms)
    names = {field.only[0] for field in fields if field.only is not None}
    return tuple((s.name, s.default) for s in one.settings if s.name in names)


@cache
def _given(one: Pass, values: tuple[tuple[str, Value], ...]) -> Pass:
    if not values:
        return one
    of = dict(values)

    def given(fields: tuple[Field, ...]) -> tuple[Field, ...]:
        return tuple(
            field
            for field in fields
            if field.only is None or of[field.only[0]] in field.only[1]
        )

    return replace(
        one,
        inputs=given(one.inputs),
        outputs=given(one.outputs),
        terms=given(one.terms),
    )


def given_with(
    setting: str, values: tuple[str, ...], fields: tuple[Field, ...]
) -> tuple[Field, ...]:
    """The same buffers, given where a setting has one of some values alone."""
    return tuple(replace(field, only=(setting, values)) for field in fields)


def real(name: str, meaning: str, *columns: int | str) -> Field:
    """Buffer of reals.

    Parameters
    ----------
    *columns : int or str; shape of a row
    """
    return Field(name, columns, "real", meaning)


def vector(name: str, meaning: str) -> Field:
    """Buffer of three reals a row."""
    return real(name, meaning, 3)


def index(name: str, meaning: str, *columns: int | str) -> Field:
    """Buffer of row numbers.

    Parameters
    ----------
    *columns : int or str; shape of a row
    """
    return Field(name, columns, "index", meaning)


def bits(name: str, meaning: str, *columns: int | str) -> Field:
    """Buffer of 32-bit words.

    Parameters
    ----------
    *columns : int or str; shape of a row
    """
    return Field(name, columns, "bits", meaning)
