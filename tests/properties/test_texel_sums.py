"""Weights of cells of textured lights: positive wherever the texture shines.

Evidence: an identity for any input.  A weight of 0 where something is emitted makes
next-event estimation dark there: a bias, however small the place.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restir_gi.reference.images.image import luminance_weights
from restir_gi.reference.scene.texel_sums import TexelSums
from restir_gi.reference.scene.textures import Bitmap, Checker, read

INSIDE = 12
"""Points looked at in each rectangle, along each side."""

numbers = st.floats(-3, 3, allow_nan=False)
wraps = st.sampled_from(("repeat", "mirror", "clamp"))


@st.composite
def bitmaps(draw):
    """Small ones, mostly black, of values over twelve orders of magnitude."""
    height, width = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    values = draw(
        st.lists(
            st.sampled_from((0.0, 0.0, 0.0, 1e-6, 1.0, 1e6)),
            min_size=3 * height * width,
            max_size=3 * height * width,
        )
    )
    return Bitmap(
        np.reshape(values, (height, width, 3)),
        draw(st.sampled_from(("bilinear", "nearest"))),
        (draw(numbers), draw(numbers)),
        (draw(wraps), draw(wraps)),
    )


checkers = st.builds(
    Checker,
    st.sampled_from(((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))),
    st.sampled_from(((0.0, 0.0, 0.0), (2.0, 0.0, 0.0))),
    st.tuples(numbers, numbers),
)


def looked_at(low, high):
    """A lattice of texture coordinates over a rectangle, its edges among them."""
    steps = np.linspace(0, 1, INSIDE)
    s, t = (grid.ravel() for grid in np.meshgrid(steps, steps))
    return np.stack([s, t], axis=-1) * (high - low) + low


@given(bitmaps() | checkers, numbers, numbers, st.floats(0, 2), st.floats(0, 2))
def test_the_weight_is_positive_where_anything_shines(texture, u, v, wide, high):
    low, top = np.array([u, v]), np.array([u + wide, v + high])
    weight = TexelSums.of(texture).around(low[None], top[None])[0]
    shown = read(texture, looked_at(low, top))
    assert weight > 0 or not shown.any()


@given(bitmaps(), numbers, numbers)
def test_the_weight_is_no_more_than_the_brightest_texel(texture, u, v):
    """Of the running sums, rounded at each of up to 25 texels and 4 parts of a box."""
    low, high = np.array([[u, v]]), np.array([[u + 0.3, v + 0.3]])
    weight = TexelSums.of(texture).around(low, high)[0]
    luminance = texture.pixels @ np.array(luminance_weights())
    rounding = 32 * np.finfo(float).eps * luminance.sum()
    assert 0 <= weight <= luminance.max() + rounding


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
def test_the_mean_is_that_of_the_texels_around(wrap):
    """Rectangles in the middle of texels of 8 x 8; nothing to round but the sums."""
    rng = np.random.default_rng(3)
    pixels = rng.random((8, 8, 3))
    texture = Bitmap(pixels, "nearest", wrap=(wrap, wrap))
    luminance = pixels @ np.array(luminance_weights())
    low = np.array([[0.3, 0.4], [0.05, 0.7]])
    high = np.array([[0.6, 0.45], [0.1, 0.95]])
    found = TexelSums.of(texture).around(low, high)
    wanted = [luminance[4:5, 2:5].mean(), luminance[0:3, 0:1].mean()]
    assert np.allclose(found, wanted, rtol=1e-13)


def test_a_bright_texel_far_away_does_not_hide_a_faint_one():
    """Sums in float64 lose 1 beside 1e20; the count of lit texels does not."""
    pixels = np.zeros((1, 64, 3))
    pixels[0, 0], pixels[0, 40] = 1e20, 1.0
    sums = TexelSums.of(Bitmap(pixels, "nearest"))
    low, high = np.array([[40.2, 0.5]]) / [64, 1], np.array([[40.8, 0.6]]) / [64, 1]
    assert sums.around(low, high)[0] > 0
    # Without it the weight is that of the difference of two sums: nothing.
    assert sums.sums[1, 41] - sums.sums[1, 40] == 0
