"""The random streams look uniform and independent where the passes use them.

The numbers are fixed by their keys, so each test either passes for ever or fails for
ever; the rate says how unlikely that failure was for ideal numbers.  26 statistics are
tested, each at 1e-6 by Šidák's rule from 2.6e-5 for all together [Sidak67].  A cell of
64 that is hit 10 % more often is found for certain: its share of χ², 0.1² · 2^14, alone
is 164, above the limit of 131.

Keys are words of 32 bits multiplied modulo 2^32, so that their upper bits reach
few others.  Seeds or frames that differ in nothing but bits above the 27th make streams
that depend on each other: the control shows it for the highest.
"""

import numpy as np
import pytest
from scipy.stats import chi2

from restir_gi.reference.numerics.rng import KeyedUniforms, Stream

COUNT = 2**20
CELLS = 64
STATISTICS = 26
RATE = 2.6e-5
LIMIT = chi2.isf(1 - (1 - RATE) ** (1 / STATISTICS), CELLS - 1)


def chi_square(*columns):
    """χ² of points of the unit interval or square, in 64 cells of equal size."""
    side = {1: 64, 2: 8}[len(columns)]
    cell = sum(
        np.floor(side * u).astype(np.int64) * side**i for i, u in enumerate(columns)
    )
    counts = np.bincount(cell, minlength=CELLS)
    expected = len(cell) / CELLS
    return np.sum((counts - expected) ** 2) / expected


def pixels(frame=0, seed=0, stream=Stream.INITIAL, dimension=0):
    """Numbers of all pixels of a frame of 1024 x 1024."""
    rows = np.arange(COUNT, dtype=np.uint32)
    return KeyedUniforms(rows, frame, seed, stream).draw(dimension)


def frames(pixel):
    """Numbers of one pixel over many frames."""
    return np.array(
        [
            KeyedUniforms(np.array([pixel], np.uint32), t, 0, Stream.INITIAL).draw(0)
            for t in range(2**14)
        ]
    )[..., 0].T


@pytest.fixture(scope="module")
def picture():
    return pixels()


@pytest.mark.parametrize("lane", range(4))
def test_each_lane_is_uniform_over_the_picture(picture, lane):
    assert chi_square(picture[lane]) < LIMIT


@pytest.mark.parametrize(("a", "b"), [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
def test_lanes_are_independent(picture, a, b):
    assert chi_square(picture[a], picture[b]) < LIMIT


@pytest.mark.parametrize("step", [1, 1024])
def test_neighbours_in_the_picture_are_independent(picture, step):
    u = picture[0]
    assert chi_square(u[:-step], u[step:]) < LIMIT


@pytest.mark.parametrize(
    "other",
    [
        {"frame": 1},
        {"seed": 1},
        {"dimension": 1},
        {"stream": Stream.PATH},
        {"seed": 2**26},
    ],
)
def test_other_keys_are_independent(picture, other):
    for lane in range(0, 4, 3):
        assert chi_square(picture[lane], pixels(**other)[lane]) < LIMIT


@pytest.mark.parametrize("pixel", [0, 12345])
def test_a_pixel_is_uniform_over_time(pixel):
    u = frames(pixel)
    assert chi_square(u[1]) < LIMIT
    assert chi_square(u[1][:-1], u[1][1:]) < LIMIT


def test_control_a_loaded_die_is_found(picture):
    """A cell that comes 10 % more often."""
    u = picture[0].copy()
    u[np.flatnonzero(u < 0.9)[: COUNT // CELLS // 10]] = 0.999
    assert chi_square(u) > LIMIT


def test_control_seeds_that_differ_in_the_highest_bit_depend_on_each_other(picture):
    assert chi_square(picture[0], pixels(seed=2**31)[0]) > LIMIT
