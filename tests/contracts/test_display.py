"""What a screen is given: exposure, the sRGB curve, eight bits, a PNG."""

from io import BytesIO

import colour
import numpy as np
from numpy.testing import assert_allclose
from PIL import Image as Pillow

from restir_gi.reference.images.display import (
    MARKER,
    auto_exposure,
    encode_png,
    encode_srgb,
    to_display,
    write_png,
)


def grey(*values):
    return np.repeat(np.array(values, np.float32)[None, :, None], 3, axis=-1)


def test_the_curve_is_that_of_colour_science():
    linear = np.concatenate([np.linspace(0, 1, 1001), np.linspace(0, 0.01, 101)])
    expected = colour.cctf_encoding(linear, function="sRGB")
    assert_allclose(encode_srgb(linear), expected, rtol=0, atol=1e-12)


def test_known_levels():
    # 0.2140 is the linear light of the middle code value: ((0.5 + 0.055) / 1.055)^2.4
    shown = to_display(grey(-1, 0, 0.21404114, 1, 2), exposure=1)
    assert shown[0, :, 1].tolist() == [0, 0, 128, 255, 255]


def test_exposure_is_a_factor_on_light():
    rgb = grey(0.01, 0.1, 0.2)
    np.testing.assert_array_equal(to_display(rgb, 4), to_display(4 * rgb, 1))


def test_what_is_not_finite_is_magenta():
    rgb = grey(1, 1, 1, 1)
    rgb[0, 1:, 2] = [np.nan, np.inf, -np.inf]
    shown = to_display(rgb, 1)
    assert shown[0, 0].tolist() == [255, 255, 255]
    assert (shown[0, 1:] == MARKER).all()


def test_exposure_follows_the_lit_pixels_and_no_lamp():
    image = np.full((20, 20, 3), 0.04, np.float32)
    image[:10] = 0
    image[10, :5] = 1000
    image[0, 0] = np.nan, np.inf, -np.inf
    assert_allclose(auto_exposure(image), 0.8 / 0.04, rtol=1e-6)


def test_a_black_image_is_not_exposed():
    assert auto_exposure(np.zeros((2, 3, 3), np.float32)) == 1


def test_a_png_holds_the_pixels(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (3, 5, 3), np.uint8)
    np.testing.assert_array_equal(Pillow.open(BytesIO(encode_png(pixels))), pixels)
    rgb = np.random.default_rng(1).random((3, 5, 3))
    write_png(tmp_path / "a.png", rgb, 1.5)
    with Pillow.open(tmp_path / "a.png") as read:
        np.testing.assert_array_equal(read, to_display(rgb, 1.5))
