"""Words of the contract: buffers, settings and passes."""

from collections.abc import Mapping
from dataclasses import dataclass
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
    """

    name: str
    columns: tuple[int | str, ...]
    kind: Kind
    meaning: str


@dataclass(frozen=True, slots=True)
class Setting:
    """One number or word that holds for all rows.

    Attributes
    ----------
    values : str; what it may be, for the reader
    """

    name: str
    values: str
    meaning: str


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
    """

    name: str
    summary: str
    formula: str
    inputs: tuple[Field, ...]
    outputs: tuple[Field, ...]
    settings: tuple[Setting, ...] = ()
    source: str = ""
    terms: tuple[Field, ...] = ()


Passes = Mapping[str, Pass]


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
