"""Records are handled as one array: whatever holds for a column holds for all."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.records import (
    concatenate,
    keep,
    map_rows,
    scatter,
    take,
    where,
)
from restir_gi.reference.strategies import ROWS, cuts


@dataclass(frozen=True, slots=True)
class Inner:
    """Columns of two shapes and types."""

    vector: Any
    mask: Any


@dataclass(frozen=True, slots=True)
class Outer:
    """A record in a record, a column that may be absent, and one of integers."""

    inner: Inner
    absent: Any
    number: Any


@st.composite
def records(draw, rows=ROWS):
    vector = draw(arrays(np.float64, (rows, 3), elements=st.floats(-9, 9)))
    mask = draw(arrays(bool, rows))
    number = draw(arrays(np.int32, rows, elements=st.integers(-9, 9)))
    return Outer(Inner(vector, mask), None, number)


def columns(record):
    return record.inner.vector, record.inner.mask, record.number


def assert_same(a, b):
    assert a.absent is None
    assert b.absent is None
    for x, y in zip(columns(a), columns(b), strict=True):
        assert_array_equal(x, y)
        assert x.dtype == y.dtype


indices = arrays(np.int64, st.integers(0, 9), elements=st.integers(0, ROWS - 1))


@given(records(), indices)
def test_take_takes_rows_of_every_column(record, rows):
    taken = take(record, rows)
    for whole, some in zip(columns(record), columns(taken), strict=True):
        assert_array_equal(some, whole[rows])


@given(records(), indices, st.data())
def test_taking_twice_is_taking_once(record, rows, data):
    again = data.draw(
        arrays(np.int64, 3, elements=st.integers(0, max(len(rows) - 1, 0)))
    )
    again = again[: len(rows)]
    assert_same(take(take(record, rows), again), take(record, rows[again]))


@given(records(), records(), arrays(bool, ROWS))
def test_where_chooses_whole_rows(yes, no, mask):
    chosen = where(mask, yes, no)
    for row in range(ROWS):
        source = yes if mask[row] else no
        for column, origin in zip(columns(chosen), columns(source), strict=True):
            assert_array_equal(column[row], origin[row])


@given(records(), records(), arrays(bool, ROWS))
def test_where_of_the_opposite_is_the_other(yes, no, mask):
    assert_same(where(mask, yes, no), where(~mask, no, yes))


@given(records(), cuts())
def test_cut_and_joined_again_is_a_permutation(record, pieces):
    joined = concatenate([take(record, piece) for piece in pieces])
    assert_same(joined, take(record, np.concatenate(pieces)))


@given(records(), cuts())
def test_scatter_undoes_take(record, pieces):
    order = np.concatenate(pieces)
    assert_same(scatter(order, take(record, order), ROWS), record)


@given(records(), st.permutations(range(2 * ROWS)))
def test_scatter_leaves_0_elsewhere(record, order):
    rows = np.array(order[:ROWS])
    spread = scatter(rows, record, 2 * ROWS)
    assert_same(take(spread, rows), record)
    for column in columns(take(spread, np.array(order[ROWS:]))):
        assert not column.any()


@given(records(), arrays(bool, ROWS))
def test_keep_is_take_where_true(record, mask):
    assert_same(keep(record, mask), take(record, np.flatnonzero(mask)))


@given(records(), records())
def test_nothing_is_written_in_place(a, b):
    before = [column.copy() for column in (*columns(a), *columns(b))]
    rows = np.arange(ROWS)
    take(a, rows), where(a.inner.mask, a, b), concatenate([a, b]), scatter(rows, a, 9)
    for old, new in zip(before, (*columns(a), *columns(b)), strict=True):
        assert_array_equal(old, new)


@given(records())
def test_map_rows_reaches_every_column_once(record):
    seen = []

    def look(column):
        seen.append(column)
        return column

    assert_same(map_rows(look, record), record)
    for column, origin in zip(seen, columns(record), strict=True):
        assert column is origin


def test_an_array_is_a_record_too():
    a = np.arange(6).reshape(3, 2)
    assert_array_equal(take(a, np.array([2, 0])), a[[2, 0]])
    assert_array_equal(concatenate([a, a]), np.concatenate([a, a]))
    mask = np.array([True, False, True])
    assert_array_equal(where(mask, a, -a), np.where(mask[:, None], a, -a))


def test_columns_of_objects_are_taken_whole():
    names, others = np.array(["a", "b"], object), np.array(["c", "d"], object)
    assert list(where(np.array([True, False]), names, others)) == ["a", "d"]


def test_records_of_different_shape_are_refused():
    a = Outer(Inner(np.zeros((2, 3)), np.zeros(2, bool)), None, np.zeros(2))
    b = Outer(Inner(np.zeros((2, 3)), np.zeros(2, bool)), np.zeros(2), np.zeros(2))
    with pytest.raises((TypeError, AttributeError, ValueError)):
        map_rows(np.add, b, a)
