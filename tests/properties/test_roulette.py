"""Roulette by tiles: who lives together, and that the choice can be made again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.rng import DIMENSIONS, Stream, pcg4d
from restir_gi.reference.options.roulette import TILE_HEIGHT, TILE_WIDTH, tail_weight
from restir_gi.reference.strategies import cuts

WIDTH, HEIGHT = 3 * TILE_WIDTH + 7, 2 * TILE_HEIGHT + 5
N = WIDTH * HEIGHT
ACROSS, DOWN = 4, 3

frames = st.integers(0, 2**20)
seeds = st.integers(0, 2**20)
probabilities = st.sampled_from([2.0**-10, 0.25, 0.5, 1.0])


def image(probability, frame, seed, width=WIDTH):
    pixel = np.arange(N // width * width)
    return tail_weight(pixel, width, probability, frame, seed).reshape(-1, width)


def test_tiles_have_the_size_of_the_paper():
    """Pixels 63 and 64 of a line, and lines 31 and 32, are apart in some of 64 frames.

    Wrongly none: 2^-64.
    """
    assert (TILE_WIDTH, TILE_HEIGHT) == (64, 32)
    fates = np.stack([image(0.5, frame, 0) for frame in range(64)])
    assert (fates[:, 0, 63] == fates[:, 0, 0]).all()
    assert (fates[:, 0, 63] != fates[:, 0, 64]).any()
    assert (fates[:, 31, 0] == fates[:, 0, 0]).all()
    assert (fates[:, 31, 0] != fates[:, 32, 0]).any()


@given(probabilities, frames, seeds)
def test_pixels_of_a_tile_share_their_fate(probability, frame, seed):
    found = image(probability, frame, seed)
    for top in range(0, HEIGHT, TILE_HEIGHT):
        for left in range(0, WIDTH, TILE_WIDTH):
            tile = found[top : top + TILE_HEIGHT, left : left + TILE_WIDTH]
            assert len(np.unique(tile)) == 1
    assert set(np.unique(found)) <= {0.0, 1.0 / probability}


@given(probabilities, frames, seeds)
def test_a_tile_lives_where_its_keyed_number_is_small(probability, frame, seed):
    """Number of the tile, frame, seed, and the first dimension of the stream."""
    found = image(probability, frame, seed)[::TILE_HEIGHT, ::TILE_WIDTH]
    key = np.uint32(Stream.ROULETTE * DIMENSIONS)
    tile = np.arange(ACROSS * DOWN, dtype=np.uint32)
    bits, *_ = pcg4d(tile, np.uint32(frame), np.uint32(seed), key)
    lives = (bits >> np.uint32(8)) < round(probability * 2**24)
    assert_array_equal(found.ravel() > 0, lives)


@given(frames, seeds)
def test_at_probability_1_nothing_changes(frame, seed):
    assert_array_equal(image(1.0, frame, seed), np.ones((HEIGHT, WIDTH)))


@given(frames, seeds, st.sampled_from([(0.1, 0.25), (0.25, 0.8)]))
def test_who_lives_at_a_small_probability_lives_at_a_larger(frame, seed, pair):
    few, many = (image(p, frame, seed) > 0 for p in pair)
    assert (few <= many).all()


@given(st.lists(frames, min_size=8, max_size=8), seeds, cuts(8))
def test_each_row_may_be_of_a_frame_of_its_own(numbers, seed, pieces):
    """As a path that is replayed needs it: row by row the same as frame by frame."""
    numbers = np.array(numbers)
    pixel = np.linspace(0, N - 1, 8).astype(np.int64)
    whole = tail_weight(pixel, WIDTH, 0.5, numbers, seed)
    for p, t, weight in zip(pixel, numbers, whole, strict=True):
        assert tail_weight(np.array([p]), WIDTH, 0.5, int(t), seed) == weight
    for rows in pieces:
        part = tail_weight(pixel[rows], WIDTH, 0.5, numbers[rows], seed)
        assert_array_equal(part, whole[rows])


@pytest.mark.parametrize("p", [0.25, 0.75])
def test_the_share_of_tiles_that_live(p):
    """65536 fixed keys, judged as if they were draws: 5 sigma, 6e-7 by luck.

    A probability that is off by 2 % of 1 is 10 sigma away, and must be found.
    """
    frames_of_one_tile = np.arange(65536)
    pixel = np.zeros(65536, np.int64)
    share = np.mean(tail_weight(pixel, WIDTH, p, frames_of_one_tile, 3) > 0)
    sigma = np.sqrt(p * (1 - p) / 65536)
    assert abs(share - p) < 5 * sigma
    assert abs(share - (p + 0.02)) > 5 * sigma


def test_tiles_frames_and_seeds_have_different_fates():
    """Twelve tiles at probability 1/2: that any two patterns here agree is 2^-12."""
    patterns = [image(0.5, *key)[::TILE_HEIGHT, ::TILE_WIDTH] > 0
                for key in [(0, 0), (1, 0), (0, 1), (1, 1)]]  # fmt: skip
    assert len({pattern.tobytes() for pattern in patterns}) == 4
    assert all(0 < pattern.sum() < pattern.size for pattern in patterns)


@pytest.mark.parametrize("width", [1, 63, 64, 65])
def test_any_width(width):
    """A column of tiles more as soon as a pixel is left over."""
    found = image(0.5, 2, 5, width)
    for left in range(0, width, TILE_WIDTH):
        assert len(np.unique(found[:TILE_HEIGHT, left : left + TILE_WIDTH])) == 1
    tile = np.arange(len(found[::TILE_HEIGHT]) * -(-width // TILE_WIDTH))
    pixel = tile % (-(-width // TILE_WIDTH)) * TILE_WIDTH
    pixel = pixel + tile // (-(-width // TILE_WIDTH)) * TILE_HEIGHT * width
    assert_array_equal(
        tail_weight(pixel, width, 0.5, 2, 5),
        found[::TILE_HEIGHT, ::TILE_WIDTH].ravel(),
    )


def test_a_single_pixel():
    assert tail_weight(np.array([0]), 1, 1.0, 0, 0).tolist() == [1.0]
