"""Look-ups of textures: how they go on beyond their edges, and that they are total."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from restir_gi.reference.scene.textures import Bitmap, read

PIXELS = np.random.default_rng(3).random((3, 4, 3))
TILED = {
    "repeat": np.tile(PIXELS, (3, 3, 1)),
    "mirror": np.pad(PIXELS, ((3, 3), (4, 4), (0, 0)), "symmetric"),
    "clamp": np.pad(PIXELS, ((3, 3), (4, 4), (0, 0)), "edge"),
}
"""The picture with its eight neighbours, of three times its sides."""
FILTERS = ("bilinear", "nearest")


@pytest.mark.parametrize("wrap", TILED)
@given(uv=st.tuples(*2 * [st.floats(-0.8, 1.8)]))
def test_beyond_its_edges_a_picture_is_that_with_its_neighbours(wrap, uv):
    """Up to 0.8 pictures away, a look-up stays within the neighbours."""
    place = np.array([uv])
    seen = read(Bitmap(PIXELS, wrap=(wrap, wrap)), place)
    expected = read(Bitmap(TILED[wrap]), (place + 1) / 3)
    # (uv + 1) / 3 is off by 2 half ulps of 1, so places by 2 · 12 half ulps; colours
    # change by at most 1 a texel.  The look-up rounds some 8 times more.
    assert_allclose(seen, expected, rtol=0, atol=32 * np.finfo(float).eps)


@pytest.mark.parametrize("wrap", TILED)
@given(column=st.integers(-4, 7), row=st.integers(-3, 5))
def test_texels_beyond_the_edges_are_those_of_the_neighbours(wrap, column, row):
    texture = Bitmap(PIXELS, "nearest", wrap=(wrap, wrap))
    middle = np.array([[(column + 0.5) / 4, 1 - (row + 0.5) / 3]])
    assert np.array_equal(read(texture, middle), [TILED[wrap][row + 3, column + 4]])


@pytest.mark.parametrize("filtering", FILTERS)
@pytest.mark.parametrize("wrap", TILED)
@given(uv=st.tuples(*2 * [st.floats(-1e50, 1e50)]))
def test_no_coordinate_leads_out_of_the_range_of_the_texture(filtering, wrap, uv):
    seen = read(Bitmap(PIXELS, filtering, wrap=(wrap, wrap)), np.array([uv]))
    rounding = 4 * np.finfo(float).eps  # of a mean of means
    assert (seen >= PIXELS.min(axis=(0, 1)) - rounding).all()
    assert (seen <= PIXELS.max(axis=(0, 1)) + rounding).all()


def test_each_axis_has_its_own_way_to_go_on():
    texture = Bitmap(PIXELS, "nearest", wrap=("clamp", "mirror"))
    # Row 0 is the top: v = 1 - (row + 1/2) / 3.
    place = np.array([[1.2, 1 / 6], [-4.0, 5 / 6], [1 / 8, 7 / 6], [5 / 8, -1 / 6]])
    expected = PIXELS[[2, 0, 0, 2], [3, 0, 0, 2]]
    assert np.array_equal(read(texture, place), expected)
