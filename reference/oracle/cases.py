"""Cases: what a backend is given, and what it gives back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Passes,
    Precision,
    Value,
    dtype_of,
)

Buffers = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One call of one pass.

    Attributes
    ----------
    name : str; of a folder: letters, digits, hyphens
    pass_name : str; which pass of the contract
    settings : mapping of str to str, int or float; all that the pass has
    inputs : mapping of str to array; in the backend's precision
    random : bool
        The numbers u of its rows were drawn, independently: so that decisions which
        rounding leaves open are rare, and are counted against a budget.
    width : int or None
        Rows are the pixels of an image of that width; ``None`` where they are not.
    """

    name: str
    pass_name: str
    settings: Mapping[str, Value]
    inputs: Buffers
    random: bool = False
    width: int | None = None

    @property
    def rows(self) -> int:
        """N."""
        return len(next(iter(self.inputs.values())))


@dataclass(frozen=True, slots=True)
class Failure:
    """A backend gave nothing that can be judged.

    Attributes
    ----------
    timed_out : bool; it took longer than one call may
    """

    reason: str
    timed_out: bool = False


@dataclass(frozen=True, slots=True)
class Unasked:
    """Nothing is known: a call was not made, or was cut short from outside."""

    reason: str


class UnaskedError(Exception):
    """A call in the middle of something else was not made, or was cut short."""


NO_TIME = Unasked("no time was left")
NOT_AGAIN = Unasked("not asked again after a call that took too long")

Outcome = Buffers | Failure | Unasked | None
"""Outputs of a case; ``None`` where the backend does not have the pass."""

Remaining = Callable[[], float]
"""Seconds that are left."""


def for_ever() -> float:
    """Seconds that are left where nobody counts them."""
    return inf


def output_shapes(passes: Passes, case: Case) -> dict[str, tuple[int, ...]]:
    """Shapes of the buffers that a case asks for, by name.

    They are in the order of the contract; terms come last.
    """
    found = passes[case.pass_name]
    counts = _counts(found.inputs, case)
    return {
        f.name: (case.rows, *(_columns(c, counts) for c in f.columns))
        for f in (*found.outputs, *found.terms)
    }


def refused(
    passes: Passes, case: Case, precision: Precision, outputs: Buffers
) -> Failure | None:
    """Why outputs cannot be judged, if they cannot.

    Names, type, shape, and that all reals are finite, in this order.  Of terms only
    type and shape, where they are given.
    """
    shapes = output_shapes(passes, case)
    wanted_fields = passes[case.pass_name].outputs
    terms = [f for f in passes[case.pass_name].terms if f.name in outputs]
    for field in (*wanted_fields, *terms):
        what = f"{case.name}: {field.name}"
        if field.name not in outputs:
            names = ", ".join(f.name for f in wanted_fields)
            return Failure(f"{what} is missing; the pass returns {names}")
        found = np.asarray(outputs[field.name])
        wanted = dtype_of(field.kind, precision)
        if found.dtype.kind == wanted.kind and found.dtype != wanted:
            swapped = found.dtype.newbyteorder() == wanted
            order = " in the other byte order" if swapped else ""
            return Failure(f"{what} is {found.dtype}{order} instead of {wanted}")
        if found.dtype != wanted:
            return Failure(f"{what} is {found.dtype} instead of {wanted}")
        if found.shape != shapes[field.name]:
            return Failure(
                f"{what} has shape {found.shape} instead of {shapes[field.name]}"
            )
        if field in terms or field.kind != "real":
            continue
        if not np.isfinite(found).all():
            return Failure(_not_finite(what, found))
    return None


def _not_finite(what: str, found: NDArray[Any]) -> str:
    bad = ~np.isfinite(found).reshape(len(found), -1).all(axis=1)
    row = int(np.flatnonzero(bad)[0])
    word = "NaN" if np.isnan(found[row]).any() else "infinity"
    return f"{what} holds {word} in {int(bad.sum())} rows, the first is {row}"


def _counts(inputs: tuple[Field, ...], case: Case) -> dict[str, int]:
    """How many neighbours: K, from the buffers that have a column for each."""
    return {
        column: case.inputs[f.name].shape[1 + place]
        for f in inputs
        for place, column in enumerate(f.columns)
        if column == "K"
    }


def _columns(column: int | str, counts: Mapping[str, int]) -> int:
    if isinstance(column, int):
        return column
    letter, _, more = column.partition("+")
    return counts[letter] + int(more or 0)
