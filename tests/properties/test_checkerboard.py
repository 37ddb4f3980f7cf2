"""Checkerboard: whose turn it is to draw."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.options.checkerboard import draws_new_sample

sizes = st.tuples(st.integers(1, 9), st.integers(1, 9))
frames = st.integers(0, 2**27 - 1)


def board(width, height, frame, has_history=True):
    rows = np.arange(width * height)
    old = np.full(len(rows), has_history)
    return draws_new_sample(rows, width, frame, old).reshape(height, width)


def test_frame_0_begins_at_the_corner():
    expected = [[True, False, True], [False, True, False]]
    assert board(3, 2, 0).tolist() == expected


@given(sizes, frames)
def test_each_pixel_draws_in_exactly_one_of_two_frames(size, frame):
    assert_array_equal(board(*size, frame), ~board(*size, frame + 1))
    assert_array_equal(board(*size, frame), board(*size, frame + 2))


@given(sizes, frames)
def test_neighbours_of_a_pixel_draw_when_it_does_not(size, frame):
    """Also where the width is even, so that row + 1 begins with the same parity."""
    found = board(*size, frame)
    assert (found[:, 1:] != found[:, :-1]).all()
    assert (found[1:] != found[:-1]).all()


@given(sizes, frames)
def test_half_of_the_pixels_draw(size, frame):
    found = board(*size, frame)
    assert abs(2 * found.sum() - found.size) <= 1


@given(sizes, frames, st.data())
def test_pixels_without_history_always_draw(size, frame, data):
    rows = np.arange(size[0] * size[1])
    old = data.draw(arrays(bool, len(rows)))
    found = draws_new_sample(rows, size[0], frame, old)
    assert found.dtype == bool
    assert found[~old].all()
    assert_array_equal(found[old], board(*size, frame).ravel()[old])


@given(sizes, frames, st.data())
def test_rows_do_not_know_each_other(size, frame, data):
    rows = data.draw(st.permutations(range(size[0] * size[1])).map(np.array))
    some = rows[: data.draw(st.integers(0, len(rows)))].astype(np.int64)
    found = draws_new_sample(some, size[0], frame, np.ones(len(some), bool))
    assert_array_equal(found, board(*size, frame).ravel()[some])


@given(frames)
def test_a_single_pixel_and_a_column(frame):
    assert board(1, 1, frame).tolist() == [[frame % 2 == 0]]
    assert board(1, 4, frame).ravel().tolist() == [
        (y + frame) % 2 == 0 for y in range(4)
    ]
