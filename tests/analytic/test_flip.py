"""FLIP where its answer is known, and where the library alone would go wrong."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from restir_gi.reference.images.flip import ACES_85, flip_hdr, flip_ldr


@pytest.fixture
def noise():
    return np.random.default_rng(0).random((24, 32, 3))


def as_bytes(image):
    return np.rint(255 * image).astype(np.uint8)


def test_of_equal_images_it_is_0(noise):
    for error, mean in (
        flip_hdr(noise, noise),
        flip_ldr(as_bytes(noise), as_bytes(noise)),
    ):
        assert error.shape == (24, 32)
        assert mean == error.max() == 0


def test_black_and_white_differ_the_most(noise):
    black, white = np.zeros((24, 32, 3)), np.ones((24, 32, 3))
    _, mean = flip_ldr(as_bytes(black), as_bytes(white))
    assert 0.9 < mean <= 1


def test_the_mean_is_that_of_the_map(noise):
    error, mean = flip_hdr(noise + 0.1, noise)
    assert mean == pytest.approx(error.mean(dtype=np.float64), rel=1e-5)
    assert 0 < error.min() <= error.max() <= 1


def test_it_shows_where(noise):
    a = noise.copy()
    a[:, 20:] *= 2
    error, _ = flip_hdr(a, noise)
    assert error[:, :8].max() < 0.01 < error[:, 24:].min()


def test_the_exposures_are_the_librarys_own_if_all_is_lit(noise):
    """Its own choice, read from what it returns, for an image without black."""
    import flip_evaluator

    a, b = (noise * 1.2).astype(np.float32), noise.astype(np.float32)
    expected, mean, chosen = flip_evaluator.evaluate(b, a, "HDR", applyMagma=False)
    error, own_mean = flip_hdr(a, b)
    assert chosen["numExposures"] == 2
    assert_allclose(error, expected[..., 0], atol=1e-5)
    assert own_mean == pytest.approx(mean, abs=1e-5)


def test_the_brightest_exposure_is_where_the_curve_reaches_085():
    x = 0.6 * ACES_85
    tone = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    assert tone == pytest.approx(0.85, abs=1e-6)


@pytest.mark.parametrize("scale", [1e-38, 1e-20, 1, 1e20, 1e37])
def test_it_is_finite_at_every_scale(noise, scale):
    error, mean = flip_hdr(1.3 * noise * scale, noise * scale)
    assert np.isfinite(error).all()
    assert 0 <= mean <= 1


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 9, 3), (9, 1, 3)])
def test_any_size_will_do(shape):
    error, _ = flip_hdr(np.full(shape, 0.5), np.full(shape, 0.6))
    assert error.shape == shape[:2]
    assert (error > 0).all()


def test_a_black_truth_does_not_end_the_process(noise):
    """It does in the library: it prints a line and calls exit."""
    black = np.zeros_like(noise)
    assert flip_hdr(black, black)[1] == 0
    assert flip_hdr(noise, black)[1] > 0.1
    assert flip_hdr(1e-6 * noise, black)[1] > 0.1


def test_a_mostly_black_truth_is_judged_where_it_is_lit(noise):
    truth = noise.copy()
    truth[:20] = 0
    assert flip_hdr(truth * 1.05, truth)[1] > 0.01
    # At exposures for the median of all pixels, 0, this would be a glaring error.
    assert flip_hdr(truth + 1e-6, truth)[1] < 1e-3


def test_negative_radiance_counts_as_black(noise):
    negative = np.where(noise < 0.5, -noise, noise)
    assert flip_hdr(negative, np.maximum(negative, 0))[1] == 0
