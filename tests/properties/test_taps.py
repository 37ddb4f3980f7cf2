"""Other places to look for a history: a permutation of the frame, and a square."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.options.history_search import nearby, permuted
from restir_gi.reference.strategies import draws, scalars

sizes = st.tuples(st.integers(1, 13), st.integers(1, 13))
frames = st.integers(0, 2**27 - 1)


def partners(width, height, frame):
    return permuted(np.arange(width * height), width, height, frame)


@given(sizes, frames)
def test_a_partner_of_a_partner_is_the_pixel_itself(size, frame):
    """So that it is a bijection of the frame, whatever its size."""
    found = partners(*size, frame)
    rows = np.arange(len(found))
    assert_array_equal(found[found], rows)
    assert_array_equal(np.sort(found), rows)


@given(sizes, frames)
def test_partners_are_odd_distances_away_and_at_most_3(size, frame):
    """Within a block of 4, x becomes 3 - x, and y 3 - y; or the pixel stays."""
    width, height = size
    found = partners(width, height, frame)
    rows = np.arange(len(found))
    dx = abs(found % width - rows % width)
    dy = abs(found // width - rows // width)
    moved = found != rows
    assert np.isin(dx[moved], [1, 3]).all()
    assert np.isin(dy[moved], [1, 3]).all()


@given(sizes, frames)
def test_pixels_stay_only_at_the_border(size, frame):
    """Whoever is 3 pixels or more from every side has a partner."""
    width, height = size
    found = partners(width, height, frame)
    x, y = np.arange(len(found)) % width, np.arange(len(found)) // width
    inner = (x >= 3) & (x < width - 3) & (y >= 3) & (y < height - 3)
    assert (found != np.arange(len(found)))[inner].all()


def test_blocks_of_frame_0_begin_at_the_corner():
    """Known answer: the first block is turned by half a circle."""
    assert partners(4, 4, 0).tolist() == list(range(15, -1, -1))


@pytest.mark.parametrize("start", [0, 7])
def test_sixteen_frames_have_sixteen_different_permutations(start):
    """And the next sixteen are the same again."""
    found = [tuple(partners(12, 12, frame)) for frame in range(start, start + 17)]
    assert len(set(found[:16])) == 16
    assert found[16] == found[0]


def test_over_sixteen_frames_each_partner_comes_equally_often():
    """An inner pixel's x moves by -3, -1, 1 and 3, each in 4 of 16 frames; y too."""
    width = height = 12
    row = 6 * width + 5
    found = [permuted(np.array([row]), width, height, f)[0] for f in range(16)]
    moves = {(int(p) % width - 5, int(p) // width - 6) for p in found}
    assert moves == {(a, b) for a in (-3, -1, 1, 3) for b in (-3, -1, 1, 3)}


@given(sizes, frames, st.data())
def test_rows_are_permuted_alone_and_none_stays_none(size, frame, data):
    """Any rows of the last frame may be asked for, in any order, and nowhere."""
    width, height = size
    row = st.integers(NONE, width * height - 1)
    rows = np.array(data.draw(st.lists(row, min_size=1, max_size=9)))
    found = permuted(rows, width, height, frame)
    whole = np.append(partners(width, height, frame), NONE)
    assert_array_equal(found, whole[rows])


@pytest.mark.parametrize("frame", range(16))
def test_nowhere_has_no_partner(frame):
    """Nor the partner of row 0, or of the last."""
    assert permuted(np.array([NONE]), 12, 12, frame).tolist() == [NONE]


@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 9), (9, 1)])
def test_an_image_one_pixel_wide_has_no_partners(width, height):
    """Each partner is at least a pixel away in x and in y."""
    for frame in range(16):
        assert_array_equal(partners(width, height, frame), np.arange(width * height))


# ---------------------------------------------------------------- nearby

places = scalars(-2000.0, 4000.0)


@given(places, places, draws(), st.sampled_from([0.0, 0.5, 4.0, 32.0]))
def test_places_lie_in_a_square_around(x, y, u, radius):
    """One rounding of a sum below 8192 may step over a side: 2^-40."""
    for before, after in zip((x, y), nearby(x, y, u, radius), strict=True):
        assert (abs(after - before) <= radius + 2.0**-40).all()


def test_corners_and_middle_of_the_square():
    half, zero, last = np.array([0.5]), np.array([0.0]), np.array([1 - 2.0**-24])
    x, y = np.array([10.0]), np.array([20.0])
    assert nearby(x, y, (half, half, zero, zero), 4.0) == (10.0, 20.0)
    assert nearby(x, y, (zero, zero, half, half), 4.0) == (6.0, 16.0)
    x_to, y_to = nearby(x, y, (last, zero, half, half), 4.0)
    assert 14 - 1e-6 < x_to < 14
    assert y_to == 16


def test_the_square_is_covered_evenly():
    """A lattice of 16 x 16 uniforms falls 4 times into each of 8 x 8 pixels."""
    u, v = (a.ravel() for a in np.meshgrid(*[(np.arange(16) + 0.5) / 16] * 2))
    middle = np.full(u.size, 10.0)
    x, y = nearby(middle, middle, (u, v, u, v), 4.0)
    pixel = np.floor(y).astype(int) * 100 + np.floor(x).astype(int)
    _, count = np.unique(pixel, return_counts=True)
    assert count.tolist() == [4] * 64


def test_no_place_has_no_place_nearby():
    nowhere, u = np.array([np.nan]), np.array([0.3])
    assert np.isnan(nearby(nowhere, nowhere, (u, u, u, u), 4.0)).all()
