"""Inputs that may have been read otherwise: another buffer, column, bit, row or number.

A backend that reads the wrong input, and is right in all else, answers what is right
for a case in which that input stands in the place of the right one.  So each input is
exchanged in turn, by its shape and kind alone, and the answers are judged once more.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Case, pass_of, with_numbers
from restir_gi.reference.oracle.contract.fields import Field, Precision
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE
from restir_gi.reference.oracle.diagnosis.subsets import (
    AskedRows,
    judged,
    some_rows,
)
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.replay.blocks import BY_ROW
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

Array = NDArray[Any]

FEW, SAMPLE = 5, 24
"""Wrong rows, of which nothing is told; and those, and as many right ones, that each
misreading is held against first."""

REFUTED = 0.25
"""Share of the wrong rows in which what explains them must exclude the right answers:
one that leaves all open, as an angle of view without limit does, excludes none; and
where a sample could not have been made where it was, both may be left open."""

MOST_COLUMNS = 4
"""Of a list, that are exchanged one by one."""

MOST_TOLD = 3
"""Misreadings that the cases do not tell apart, of which one sentence is made."""

NO_LIMIT = 1e30
FACTORS = {
    "0": 0.0,
    "without limit": NO_LIMIT,
    "180/π times as large": 180 / pi,
    "π/180 times as large": pi / 180,
    "twice as large": 2.0,
    "half as large": 0.5,
}
"""What a number of the settings may have been taken for, the simplest first."""

AS_THEY_ARE = ("width", "height", "frame", "seed", "canonical")
"""Numbers of rows, columns and streams, of which there are no multiples."""


@dataclass(frozen=True, slots=True, eq=False)
class Misreading:
    """What may have been read in place of what.

    Attributes
    ----------
    text : str; goes on from "would be right if"
    read : callable; from a case to what would be read of it; None where nothing differs
    """

    text: str
    read: Callable[[Case], Case | None]


@dataclass(frozen=True, slots=True)
class Misread:
    """What explains a pass.

    Attributes
    ----------
    text : str; goes on from "would be right if"
    rows, of : int; wrong rows that it explains, of how many
    """

    text: str
    rows: int
    of: int


@dataclass(frozen=True, slots=True, eq=False)
class _Answered:
    """An answer, and which of its rows are right by the contract, (N,) bool."""

    asked: AskedRows
    right: Masks

    @property
    def wrong_rows(self) -> Indices:
        return np.flatnonzero(self.asked.rows & ~self.right)

    @property
    def right_rows(self) -> Indices:
        return np.flatnonzero(self.asked.rows & self.right)

    def right_by(self, one: Misreading, precision: Precision) -> Masks:
        """Rows that are right if that was read, (N,) bool."""
        other = one.read(self.asked.case)
        if other is None:
            return self.right
        return judged(replace(self.asked, case=other), CONTRACT_RULES, precision)[1]

    def may_be(self, one: Misreading, precision: Precision) -> bool:
        """Whether a few rows, wrong and right ones, are right if that was read."""
        other = one.read(self.asked.case)
        if other is None:
            return False
        if self.asked.case.pass_name not in BY_ROW:
            return True
        for rows, least in ((self.wrong_rows, SHARE - 0.1), (self.right_rows, 1.0)):
            few = rows[:: max(1, len(rows) // SAMPLE)]
            cut = some_rows(replace(self.asked, case=other), few)
            right = judged(cut, CONTRACT_RULES, precision)[1][cut.rows]
            if right.size and right.mean() < least:
                return False
        return True


def misread(given: Sequence[AskedRows], precision: Precision) -> Misread | None:
    """The misreading that explains nearly all wrong rows, and leaves the others right.

    Several, where the cases do not tell them apart.

    Parameters
    ----------
    given : sequence of AskedRows; all that a backend answered of a pass
    """
    cases = [_Answered(a, judged(a, CONTRACT_RULES, precision)[1]) for a in given]
    of = sum(len(one.wrong_rows) for one in cases)
    if of < FEW:
        return None
    first = max(cases, key=lambda one: len(one.wrong_rows))
    found: list[tuple[int, str]] = []
    for one in _misreadings([a.case for a in given]):
        rows = _explained(cases, one, precision) if first.may_be(one, precision) else 0
        if rows >= SHARE * of and _is_sharp(cases, one, precision):
            found.append((rows, one.text))
    best = max((rows for rows, _ in found), default=0)
    texts = [text for rows, text in found if rows == best]
    return Misread("; or if ".join(texts[:MOST_TOLD]), best, of) if texts else None


def _explained(
    cases: Sequence[_Answered], one: Misreading, precision: Precision
) -> int:
    """Wrong rows that a misreading explains; 0 if it breaks others."""
    explained = 0
    for case in cases:
        right = case.right_by(one, precision)
        if not right[case.right_rows].all():
            return 0
        explained += int(right[case.wrong_rows].sum())
    return explained


def _is_sharp(
    cases: Sequence[_Answered], one: Misreading, precision: Precision
) -> bool:
    """Whether right answers would be wrong by it: else it may leave everything open."""
    refuted, of = 0, 0
    for case in cases:
        asked, wrong = case.asked, case.wrong_rows
        if len(wrong):
            own = getattr(BuiltIn(precision), asked.case.pass_name)
            right = own(**with_numbers(asked.case), **asked.case.settings)
            given = replace(case, asked=replace(asked, outputs=right))
            refuted += int((~given.right_by(one, precision)[wrong]).sum())
            of += len(wrong)
    return refuted >= REFUTED * of


def _misreadings(cases: list[Case]) -> Iterator[Misreading]:
    """All that the inputs and settings of a pass may be taken for."""
    yield from _settings(cases)
    fields = [
        field
        for field in pass_of(whole_contract(), cases[0]).inputs
        if all(field.name in case.inputs for case in cases)
    ]
    lists = [f for f in fields if f.columns and f.columns != (3,) and not _is_table(f)]
    for one in fields:
        if one.kind == "index":
            yield from _none(one.name)
        if one.kind == "bits":
            yield from _bits(one, cases)
    for one in lists:
        yield from _columns(one.name, cases)
    for one, other in permutations(fields, 2):
        if one.kind != other.kind:
            continue
        if one.columns == other.columns:
            yield _taken(f"{one.name} were {other.name}", one.name, other.name)
        elif not one.columns and other in lists and len(other.columns) == 1:
            for k in range(_least(other.name, cases)):
                text = f"{one.name} were column {k} of {other.name}"
                yield _taken(text, one.name, other.name, k)
    for one in fields:
        for text, step in (("before", 1), ("after", -1)):
            yield _moved(f"{one.name} were that of the row {text}", one.name, step)


def _is_table(one: Field) -> bool:
    """Whether a row is a function, of which nobody takes single numbers."""
    return any(isinstance(c, int) and c > MOST_COLUMNS for c in one.columns)


def _least(name: str, cases: list[Case]) -> int:
    """Columns that a buffer has in every case that has it."""
    given = [case.inputs[name] for case in cases if name in case.inputs]
    return min(int(array.shape[1]) for array in given)


# ------------------------------------------------------------------ settings


def _settings(cases: list[Case]) -> Iterator[Misreading]:
    for name, value in cases[0].settings.items():
        # What is declared says which buffers there are.
        if not all(name in case.settings for case in cases):
            continue
        if isinstance(value, str):
            for word in dict.fromkeys(str(case.settings[name]) for case in cases):
                yield _set(f"{name} were always {word}", name, word)
        elif name not in AS_THEY_ARE:
            for text, factor in FACTORS.items():
                yield _set(f"{name} were {text}", name, factor)


def _set(text: str, name: str, to: str | float) -> Misreading:
    """A setting that is a word, or times a factor."""

    def read(case: Case) -> Case | None:
        value = to if isinstance(to, str) else float(case.settings[name]) * to
        if name == "max_angle" and to == NO_LIMIT:
            value = 180.0
        if value == case.settings[name]:
            return None
        return replace(case, settings={**case.settings, name: value})

    return Misreading(text, read)


# ------------------------------------------------------------------- buffers


def _changed(
    text: str, name: str, change: Callable[[Case], Array], *others: str
) -> Misreading:
    def read(case: Case) -> Case | None:
        # Of declared surfaces there are more buffers.
        if not {name, *others} <= set(case.inputs):
            return None
        before = case.inputs[name]
        after = change(case).astype(before.dtype)
        if np.array_equal(before, after):
            return None
        return replace(case, inputs={**case.inputs, name: after})

    return Misreading(text, read)


def _taken(text: str, name: str, other: str, column: int | None = None) -> Misreading:
    """A buffer in place of another of its kind, or a column of one."""

    def change(case: Case) -> Array:
        found = case.inputs[other]
        return found if column is None else found[:, column]

    return _changed(text, name, change, other)


def _moved(text: str, name: str, step: int) -> Misreading:
    return _changed(text, name, lambda case: np.roll(case.inputs[name], step, axis=0))


def _none(name: str) -> Iterator[Misreading]:
    """Rows that there are not."""
    for text, row in (("the last row", -1), ("row 0", 0)):

        def there(case: Case, row: int = row) -> Array:
            found = case.inputs[name]
            return np.where(found < 0, np.arange(case.rows)[row], found)

        yield _changed(f"−1 in {name} were {text}", name, there)


def _columns(name: str, cases: list[Case]) -> Iterator[Misreading]:
    """Columns of a list in place of others."""
    for text, step in (("before", 1), ("after", -1)):

        def rolled(case: Case, step: int = step) -> Array:
            return np.roll(case.inputs[name], step, axis=1)

        yield _changed(f"each column of {name} were the one {text} it", name, rolled)

    def turned(case: Case) -> Array:
        return case.inputs[name][:, ::-1]

    yield _changed(f"the columns of {name} were in the other order", name, turned)
    for k, j in permutations(range(min(_least(name, cases), MOST_COLUMNS)), 2):

        def replaced(case: Case, k: int = k, j: int = j) -> Array:
            found = case.inputs[name].copy()
            found[:, k] = found[:, j]
            return found

        yield _changed(f"column {k} of {name} were column {j}", name, replaced)


def _bits(one: Field, cases: list[Case]) -> Iterator[Misreading]:
    """Words of which other bits are read: in all columns, in one, or in all but one."""
    wheres = {one.name: slice(None)}
    if one.columns:
        wheres[f"the columns of {one.name} after the first"] = slice(1, None)
        for k in range(min(_least(one.name, cases), MOST_COLUMNS)):
            wheres[f"column {k} of {one.name}"] = slice(k, k + 1)
    for (where, columns), (text, change) in product(wheres.items(), BITS.items()):

        def read(
            case: Case,
            columns: slice = columns,
            change: Callable[[Array, int], Array] = change,
        ) -> Array:
            found = case.inputs[one.name].copy()
            at = (slice(None), columns) if found.ndim > 1 else columns
            count = int(found.max(initial=0)).bit_length()
            found[at] = change(found[at], count)
            return found

        yield _changed(text.format(where), one.name, read)


def _in_place(words: Array, places: Sequence[int]) -> Array:
    """Words whose bits, from the lowest on, are those at given places of others."""
    found = np.zeros_like(words)
    for to, place in enumerate(places):
        bit = words >> np.uint32(place) & np.uint32(1) if place >= 0 else 0
        found |= np.asarray(bit, np.uint32) << np.uint32(to)
    return found


BITS: Mapping[str, Callable[[Array, int], Array]] = {
    "each bit of {0} were the one below it": lambda w, n: _in_place(
        w, [n - 1, *range(n - 1)]
    ),
    "each bit of {0} were the one above it": lambda w, n: _in_place(
        w, [*range(1, n), 0]
    ),
    "the bits of {0} were in the other order": lambda w, n: _in_place(
        w, range(n - 1, -1, -1)
    ),
    "all bits of {0} were those of bit 0": lambda w, n: _in_place(w, [0] * n),
    "{0} were turned over, 1 for 0": lambda w, n: w ^ np.uint32(2**n - 1),
    "all bits of {0} were 1": lambda w, n: np.full_like(w, 2**n - 1),
    "all bits of {0} were 0": lambda w, n: np.zeros_like(w),
}
"""Functions of words, and of how many bits of them are used."""
