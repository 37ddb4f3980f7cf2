"""Metrics against sums done by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from restir_gi.reference.images import metrics
from restir_gi.reference.images.image import luminance_weights

# Two pixels, six terms; differences 1, -2, 0, 0, 0, 3.
B = np.array([[1.0, 2.0, 0.0], [4.0, 0.5, 3.0]])
A = B + np.array([[1.0, -2.0, 0.0], [0.0, 0.0, 3.0]])


def test_absolute_errors():
    assert metrics.mse(A, B) == pytest.approx((1 + 4 + 9) / 6)
    assert metrics.rmse(A, B) == pytest.approx(np.sqrt(14 / 6))


def test_relative_errors():
    assert metrics.rel_mse(A, B) == pytest.approx((1 / 1.01 + 4 / 4.01 + 9 / 9.01) / 6)
    assert metrics.mape(A, B) == pytest.approx((1 / 1.01 + 2 / 2.01 + 3 / 3.01) / 6)
    assert metrics.smape(A, B) == pytest.approx(
        2 * (1 / 3.01 + 2 / 2.01 + 3 / 9.01) / 6
    )


def test_smape_is_symmetric_and_mape_is_not():
    assert metrics.smape(A, B) == metrics.smape(B, A)
    assert metrics.mape(A, B) != pytest.approx(metrics.mape(B, A))


@pytest.mark.parametrize("shape", [(2, 3), (1, 2, 3), (2, 1, 3)])
def test_the_shape_of_the_frame_does_not_matter(shape):
    a, b = A.reshape(shape), B.reshape(shape)
    for metric in (metrics.mse, metrics.rmse, metrics.rel_mse, metrics.mape):
        assert metric(a, b) == pytest.approx(metric(A, B), rel=1e-15)
    assert metrics.channel_means(a) == metrics.channel_means(A)


def test_of_equal_images_all_are_0():
    for metric in (metrics.mse, metrics.rmse, metrics.rel_mse, metrics.mape):
        assert metric(B, B) == 0
    assert metrics.smape(B, B) == metrics.relative_bias(B, B) == 0


def test_means_of_channels():
    assert metrics.channel_means(B) == (2.5, 1.25, 1.5)


def test_relative_bias_is_that_of_the_luminance():
    red, green, blue = luminance_weights()
    y_b = 2.5 * red + 1.25 * green + 1.5 * blue
    y_a = 3.0 * red + 0.25 * green + 3.0 * blue
    assert metrics.relative_bias(A, B) == pytest.approx(y_a / y_b - 1)
    assert metrics.relative_bias(1.5 * B, B) == pytest.approx(0.5)


def test_relative_bias_against_black():
    black = np.zeros((2, 3))
    assert metrics.relative_bias(black, black) == 0
    assert metrics.relative_bias(B, black) == np.inf
    assert metrics.relative_bias(-B, black) == -np.inf


# ---------------------------------------------------------------- standard error


def test_the_share_of_the_truth_is_taken_off():
    v = np.full((2, 3), 0.5)
    assert metrics.mse(A, B, v) == pytest.approx(14 / 6 - 0.5)
    share = np.mean(0.5 / (B**2 + 0.01))
    assert metrics.rel_mse(A, B, v) == pytest.approx(metrics.rel_mse(A, B) - share)


def test_the_corrected_error_is_that_against_the_noiseless_truth():
    """Exact: the mean over the two equally likely outcomes of noise ±s."""
    s = np.array([0.1, 0.7, 0.2])
    outcomes = [metrics.mse(A, B + sign * s, s**2) for sign in (1, -1)]
    assert np.mean(outcomes) == pytest.approx(metrics.mse(A, B))
    uncorrected = [metrics.mse(A, B + sign * s) for sign in (1, -1)]
    assert np.mean(uncorrected) > metrics.mse(A, B) + 0.1


def test_scores():
    z = metrics.z_scores(A, B, np.full((2, 3), 4.0))
    assert_allclose(z, [[0.5, -1, 0], [0, 0, 1.5]])
    assert metrics.rms(z) == pytest.approx(np.sqrt((0.25 + 1 + 2.25) / 6))
    assert metrics.excess(z, 0.9) == pytest.approx(2 / 6)


def test_without_noise_any_difference_is_certain():
    z = metrics.z_scores(A, B, np.zeros((2, 3)))
    assert z.tolist() == [[np.inf, -np.inf, 0], [0, 0, np.inf]]


def test_honest_noise_has_scores_of_unit_size_and_bias_adds_to_them():
    """Exact: over both outcomes of noise ±s, E z² = 1 + (bias / s)²."""
    s = np.array([0.1, 0.7, 0.2])
    for bias, expected in ((0, 1), (s, 2)):
        z = [metrics.z_scores(B + bias + n * s, B, 0 * B + s**2) for n in (1, -1)]
        assert metrics.rms(np.array(z)) ** 2 == pytest.approx(expected)
