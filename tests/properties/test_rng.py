"""Random numbers as data: the same key gives the same number, in [0, 1)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.rng import (
    KeyedUniforms,
    Stream,
    TabledUniforms,
    pcg4d,
    to_unit_interval,
)
from restir_gi.reference.strategies import ROWS, cuts, tabled_uniforms

words = arrays(np.uint32, ROWS, elements=st.integers(0, 2**32 - 1))
word = st.integers(0, 2**32 - 1)


@st.composite
def keyed(draw):
    stream = draw(st.sampled_from(Stream))
    return KeyedUniforms(draw(words), draw(word), draw(word), stream)


@given(words)
def test_numbers_are_multiples_of_a_step_below_1(bits):
    u = to_unit_interval(bits)
    assert ((u >= 0) & (u <= 1 - 2.0**-24)).all()
    assert_array_equal(u * 2**24, bits // 256)
    assert (u.astype(np.float32) < 1).all()


def test_the_largest_word_is_not_1():
    """Not in float32 either, where x · 2⁻³² rounds to 1."""
    bits = np.array([2**32 - 1], np.uint32)
    assert to_unit_interval(bits)[0] == 1 - 2.0**-24
    assert np.float32(bits[0] * 2.0**-32) == 1  # the reason


@given(keyed(), st.integers(0, 63))
def test_a_number_can_be_made_again(uniforms, dimension):
    once, again = uniforms.draw(dimension), uniforms.draw(dimension)
    assert_array_equal(once, again)


@given(keyed(), st.integers(0, 63), cuts())
def test_keyed_numbers_belong_to_their_rows(uniforms, dimension, pieces):
    whole = uniforms.draw(dimension)
    for piece in pieces:
        part = uniforms.rows(piece).draw(dimension)
        assert_array_equal(part, np.stack(whole)[:, piece])


@given(tabled_uniforms(3), st.integers(0, 2), cuts())
def test_tabled_numbers_belong_to_their_rows(uniforms, dimension, pieces):
    whole = uniforms.draw(dimension)
    assert_array_equal(whole, uniforms.table[dimension])
    for piece in pieces:
        part = uniforms.rows(piece).draw(dimension)
        assert_array_equal(part, np.stack(whole)[:, piece])


@given(keyed(), cuts(), st.integers(0, 63))
def test_rows_of_rows(uniforms, pieces, dimension):
    order = np.concatenate(pieces)
    back = np.argsort(order)
    twice = uniforms.rows(order).rows(back)
    assert_array_equal(twice.draw(dimension), uniforms.draw(dimension))


def test_a_table_may_be_of_any_type():
    table = np.arange(8, dtype=np.float16).reshape(1, 4, 2) / 8
    assert all(lane.dtype == np.float16 for lane in TabledUniforms(table).draw(0))


@pytest.mark.parametrize("dimension", [-1, 64, 1000])
def test_no_stream_draws_the_numbers_of_another(dimension):
    uniforms = KeyedUniforms(np.zeros(1, np.uint32), 0, 0, Stream.INITIAL)
    with pytest.raises(IndexError, match=r"outside 0\.\.63"):
        uniforms.draw(dimension)


def invert(x, y, z, w):
    """Key of four words, by undoing the steps in Python's integers."""
    mask, v = 2**32 - 1, [int(word) for word in (x, y, z, w)]

    def unmix():
        for target, a, b in ((3, 1, 2), (2, 0, 1), (1, 2, 0), (0, 1, 3)):
            v[target] = (v[target] - v[a] * v[b]) & mask

    unmix()
    v = [word ^ (word >> 16) for word in v]
    unmix()
    inverse = pow(1664525, -1, 2**32)
    return [(word - 1013904223) * inverse & mask for word in v]


@given(st.tuples(words, words, words, words))
def test_the_hash_can_be_undone(key):
    """A permutation: no two keys share their four words."""
    mixed = pcg4d(*key)
    for row in range(ROWS):
        assert invert(*(lane[row] for lane in mixed)) == [k[row] for k in key]
