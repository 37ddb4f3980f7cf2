"""Boiling filter: what it empties, and that tiles do not know each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from restir_gi.reference.options.boiling import TILE, boiling_filter
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples

WIDTH, HEIGHT = 2 * TILE + 3, TILE + 5
N = WIDTH * HEIGHT


def lit(light, W=2.0):
    """Reservoirs with luminance(L_o) W = light, grey; W = 0 where it is dark."""
    light = np.asarray(light, float)
    normal, position = np.zeros((2, len(light), 3))
    radiance = np.broadcast_to((light / W)[:, None], (len(light), 3))
    weight = np.where(light > 0, W, 0.0)
    return Reservoirs(Samples(position, normal, radiance), weight, 1.0 + weight)


def lights(rows=N):
    """Whole numbers, half of them 0 or 1, so that many tiles have outliers."""
    numbers = st.sampled_from([0, 0, 1, 1, 2, 3, 50, 1000])
    return st.lists(numbers, min_size=rows, max_size=rows).map(np.array)


def emptied(light, width, strength):
    """Rows that lose their sample, with the rest unharmed."""
    r = lit(light)
    found = boiling_filter(r, width, strength)
    gone = (found.M == 0) & (r.M > 0)
    assert_array_equal(found.W, np.where(gone, 0.0, r.W))
    assert_array_equal(found.M, np.where(gone, 0.0, r.M))
    assert found.y is r.y
    return gone


def tile_by_tile(light, width, strength):
    """The rule, written down again with slices of an image."""
    image = np.asarray(light, float).reshape(-1, width)
    gone = np.zeros(image.shape, bool)
    for top in range(0, len(image), TILE):
        for left in range(0, width, TILE):
            at = np.s_[top : top + TILE, left : left + TILE]
            alive = image[at][image[at] > 0]
            mean = alive.mean() if alive.size else 0.0
            gone[at] = image[at] > (10 / strength - 9) * mean * (1 + 1e-12)
    return gone.ravel()


@given(lights(), st.sampled_from([0.05, 0.2, 0.5, 0.9, 1.0]))
def test_reservoirs_far_above_their_tile_are_emptied(light, strength):
    """Light of whole numbers is n/m of a mean: ties, apart by 1e-12, are no accident.

    A mean of at most 256 numbers up to 1000 times 10 / strength - 9, which has two
    decimals at most: whole numbers over 256 · 100, so that what is not equal to the
    light differs from it by more than 1e-12 of it.
    """
    expected = tile_by_tile(light, WIDTH, strength)
    assert_array_equal(emptied(light, WIDTH, strength), expected)


def test_an_outlier_goes_and_its_neighbours_stay():
    """All 1 but one of v, in a tile of 256: v > 41 (255 + v) / 256 from 48.6 on."""
    light = np.ones(N)
    light[WIDTH + 1] = 49.0
    assert np.flatnonzero(emptied(light, WIDTH, 0.2)).tolist() == [WIDTH + 1]
    light[WIDTH + 1] = 48.0
    assert not emptied(light, WIDTH, 0.2).any()


def test_the_last_tile_of_a_row_is_not_the_first_of_the_next():
    """3 by 16 pixels of 1 with one of 49, out from 6.3 on; below, a bright row."""
    image = np.ones((HEIGHT, WIDTH))
    image[TILE:] = 1000.0
    image[0, -1] = 49.0
    gone = emptied(image.ravel(), WIDTH, 0.8)
    assert np.flatnonzero(gone).tolist() == [WIDTH - 1]


def test_dark_reservoirs_do_not_lower_the_mean():
    """Two of 1 and one of 30 among zeros: 41 times 32 / 3 is far above 30."""
    light = np.zeros(N)
    light[:3] = 1.0, 1.0, 30.0
    assert not emptied(light, WIDTH, 0.2).any()


@pytest.mark.parametrize("value", [0.0, 0.1, 0.3, 0.7, 1.0, 1e-300, 1e300])
@pytest.mark.parametrize("strength", [1e-9, 0.2, 1.0])
def test_equal_reservoirs_all_stay(value, strength):
    """A mean of equal numbers may round to below them: none may go for that."""
    for rows in (1, 3, 7, 13, 16, 250):
        assert not emptied(np.full(rows, value), min(rows, 16), strength).any()


@given(lights(), st.sampled_from([0.2, 1.0]))
def test_a_stronger_filter_takes_more(light, strength):
    weak, strong = (emptied(light, WIDTH, s) for s in (strength / 2, strength))
    assert (weak <= strong).all()


@given(lights(TILE * TILE), lights(TILE * TILE), st.sampled_from([0.2, 0.9]))
def test_tiles_do_not_know_each_other(a, b, strength):
    """Side by side, one above the other, or alone."""
    a, b = a.reshape(TILE, TILE), b.reshape(TILE, TILE)
    alone = [emptied(v.ravel(), TILE, strength).reshape(TILE, TILE) for v in (a, b)]
    for join, width in [(np.hstack, 2 * TILE), (np.vstack, TILE)]:
        together = emptied(join([a, b]).ravel(), width, strength)
        assert_array_equal(together, join(alone).ravel())


@given(lights(), st.integers(-300, 300))
def test_the_unit_of_light_does_not_matter(light, exponent):
    """A power of two changes no bit."""
    here, there = (emptied(light * s, WIDTH, 0.2) for s in (1.0, 2.0**exponent))
    assert_array_equal(here, there)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 40), (40, 1)])
def test_narrow_images(width, height):
    light = np.ones(width * height)
    light[-1] = 1e6
    last_tile = (width * height - 1) % TILE + 1
    # Alone in a tile it is the mean itself; among n - 1 of 1 it is n times the mean.
    assert emptied(light, width, 0.9).any() == (last_tile > 1)


def test_light_beyond_the_largest_number_does_not_overflow():
    r = lit(np.full(4, 1e300), W=1.0)
    bright = Reservoirs(r.y, r.W * np.array([1e-300, 1.0, 1e300, 1e300]), r.M)
    found = boiling_filter(bright, 2, 0.9)
    assert np.isfinite(found.W).all()
    assert found.M[0] > 0
    dark = Reservoirs(r.y, r.W * 0.0, r.M)
    assert_array_equal(boiling_filter(dark, 2, 5e-324).M, r.M)
