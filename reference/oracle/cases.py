"""Cases: what a backend is given, and what it gives back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.contract.fields import (
    Field,
    Pass,
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
    beyond : (N,) bool or None
        Rows beyond the working range, with numbers that no scene has; ``None``: no row.
    decoded : mapping of str to (N,) float64, or None
        Inputs are what came out of the backend's own storage, so that nothing is lost
        once more as they are read.  For some it says by how much the backend's numbers
        may differ where its decoder rounds.  ``None``: they are the numbers themselves.
    around : Case or None
        The case whose rows the neighbours are, of one that has some of its rows alone;
        ``None``: this one.
    """

    name: str
    pass_name: str
    settings: Mapping[str, Value]
    inputs: Buffers
    random: bool = False
    width: int | None = None
    beyond: Masks | None = None
    decoded: Mapping[str, Scalars] | None = None
    around: "Case | None" = None

    @property
    def rows(self) -> int:
        """N."""
        return len(next(iter(self.inputs.values())))

    @property
    def tells_numbers(self) -> bool:
        """Whether the random numbers of a pass that decides are among its inputs."""
        return not set(_missing_numbers(self))

    @property
    def within(self) -> Masks:
        """(N,) bool: rows within the working range."""
        return np.ones(self.rows, bool) if self.beyond is None else ~self.beyond


NUMBERS = {
    "temporal": ("u",),
    "moved": ("u",),
    "spatial": ("u_own", "u_neighbors"),
    "fused": ("u",),
}
"""Random numbers by which passes decide, where they are given."""


@dataclass(frozen=True, slots=True)
class SourceRows:
    """Where a pass finds the reservoirs of other points that it reuses.

    Attributes
    ----------
    rows : str; buffer that has the row of each, or −1
    prefix : str; of the buffers that these are rows of
    u : str; numbers that decide on them
    """

    rows: str
    prefix: str
    u: str


SOURCES = {
    "spatial": SourceRows("neighbors", "", "u_neighbors"),
    "fused": SourceRows("sources", "past_", "u"),
}
"""Of the passes that reuse several."""


def source_rows(inputs: Buffers) -> SourceRows | None:
    """Where inputs have the reservoirs of other points; ``None`` if they have none."""
    return next((s for s in SOURCES.values() if s.rows in inputs), None)


def _missing_numbers(case: Case) -> tuple[str, ...]:
    names = NUMBERS.get(case.pass_name, ())
    return tuple(name for name in names if name not in case.inputs)


def with_numbers(case: Case) -> Buffers:
    """Inputs of a case, with random numbers where a backend has its own."""
    missing = _missing_numbers(case)
    if not missing:
        return case.inputs
    rng, inputs = np.random.default_rng(0), dict(case.inputs)
    around = source_rows(inputs)
    for name in missing:
        each = around is not None and name == around.u
        columns = inputs[around.rows].shape[1:] if around and each else ()
        numbers = rng.random((case.rows, *columns), np.float32)
        inputs[name] = numbers.astype(inputs["visible_position"].dtype)
    return inputs


@dataclass(frozen=True, slots=True)
class Failure:
    """A backend gave nothing that can be judged.

    Attributes
    ----------
    timed_out : bool; it took longer than one call may
    output : str; the end of what it wrote to stdout and stderr, and its traceback
    """

    reason: str
    timed_out: bool = False
    output: str = ""


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


def pass_of(passes: Passes, case: Case) -> Pass:
    """The pass that a case asks, with the buffers that are given with its settings."""
    return passes[case.pass_name].given_with(case.settings)


def output_shapes(passes: Passes, case: Case) -> dict[str, tuple[int, ...]]:
    """Shapes of the buffers that a case asks for, by name.

    They are in the order of the contract; terms come last.
    """
    found = pass_of(passes, case)
    counts = _counts(found.inputs, case)
    return {
        f.name: (case.rows, *(_columns(c, counts) for c in f.columns))
        for f in (*found.outputs, *found.terms)
    }


def refused(
    passes: Passes, case: Case, precision: Precision, outputs: Buffers
) -> Failure | None:
    """Why outputs cannot be judged, if they cannot.

    Names, type, shape, and that all reals within the working range are finite, in this
    order.  Of terms only type and shape, where they are given.
    """
    asked, shapes = pass_of(passes, case), output_shapes(passes, case)
    wanted_fields = asked.outputs
    terms = [f for f in asked.terms if f.name in outputs]
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
        bad = not_finite(found) & case.within
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            count = int(bad.sum())
            text = f"{what} holds {not_a_number(found[row])} in {count} rows"
            return Failure(f"{text}, the first is {row}")
    return None


def not_finite(found: NDArray[Any]) -> Masks:
    """Rows with a number that is none, (N,) bool.

    Parameters
    ----------
    found : (N, ...) array; of any type
    """
    bad: Masks = ~np.isfinite(found).reshape(len(found), -1).all(axis=1)
    return bad


def not_a_number(found: NDArray[Any]) -> str:
    """Whether a row holds NaN or infinity.

    Parameters
    ----------
    found : array; of one row, not all finite
    """
    return "NaN" if np.isnan(found).any() else "infinity"


def _counts(inputs: tuple[Field, ...], case: Case) -> dict[str, int]:
    """How many neighbours: K, from the buffers that have a column for each."""
    return {
        column: case.inputs[f.name].shape[1 + place]
        for f in inputs
        for place, column in enumerate(f.columns)
        if column == "K" and f.name in case.inputs
    }


def _columns(column: int | str, counts: Mapping[str, int]) -> int:
    if isinstance(column, int):
        return column
    letter, _, more = column.partition("+")
    return counts[letter] + int(more or 0)
