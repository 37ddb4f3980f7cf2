"""Frames and images hold the same numbers, bit for bit."""

import colour
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restir_gi.reference.images.image import (
    Image,
    luminance,
    luminance_weights,
    to_image,
    to_rows,
)

sizes = st.tuples(st.integers(1, 9), st.integers(1, 9))


def picture(height, width, components=3, seed=0):
    shape = (height, width, components)
    return np.random.default_rng(seed).normal(size=shape).astype(np.float32)


def assert_same_bits(a, b):
    assert a.shape == b.shape
    np.testing.assert_array_equal(a.view(np.uint32), b.view(np.uint32))


# ---------------------------------------------------------------- frames


@given(sizes, st.sampled_from([1, 3]))
def test_rows_become_pixels_and_come_back(size, components):
    height, width = size
    rows = picture(height * width, 1, components)[:, 0]
    layer = to_image(rows, width, height)
    assert layer.shape == (height, width, components)
    assert_same_bits(layer[-1, 0], rows[(height - 1) * width])
    assert_same_bits(to_rows(layer), rows)


def test_scalars_become_a_layer_of_one_component():
    assert to_image(np.arange(6.0), 3, 2)[1, 2, 0] == 5


def test_what_float32_cannot_hold_becomes_infinite_without_a_warning():
    assert to_image(np.array([1e300, -1e300]), 2, 1).ravel().tolist() == [
        np.inf,
        -np.inf,
    ]


def test_rows_of_another_frame_are_refused():
    with pytest.raises(ValueError, match="12 rows do not make a 3x2 frame"):
        to_image(np.zeros((12, 3)), 3, 2)


@pytest.mark.parametrize(
    "layers",
    [
        {},
        {"color": picture(2, 3, 1)},
        {"color": picture(2, 3).astype(np.float64)},
        {"color": picture(2, 3), "normal": picture(3, 2)},
        {"color": picture(2, 3), "flow": picture(2, 3, 2)},
        {"color": picture(2, 3), "depth": picture(2, 3, 1)[..., 0]},
    ],
)
def test_an_image_checks_its_layers(layers):
    with pytest.raises(ValueError, match="layer"):
        Image(layers)


def test_the_weights_of_luminance_are_those_of_rec_709():
    expected = colour.models.RGB_COLOURSPACE_sRGB.matrix_RGB_to_XYZ[1]
    assert luminance_weights() == tuple(expected)
    assert sum(luminance_weights()) == pytest.approx(1, abs=1e-12)
    assert luminance(np.ones((2, 3, 3))).shape == (2, 3)
