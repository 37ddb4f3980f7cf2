"""Error maps: what their colours say."""

import numpy as np
import pytest

from restir_gi.reference.images.display import MARKER
from restir_gi.reference.images.metrics import mape
from restir_gi.reference.reports.comparison.histogram import histogram_bars
from restir_gi.reference.reports.comparison.maps import (
    difference_map,
    flip_map,
    relative_error_map,
    scale_of,
    z_map,
)


def test_red_is_where_a_is_brighter():
    a, b = np.full((2, 4, 6, 3), 0.5)
    a[0] += 0.2
    a[1] -= 0.2
    a[2] = np.nan
    shown = difference_map(a, b)
    assert shown.low == -shown.high == pytest.approx(-0.2)
    brighter, darker, unknown, equal = shown.pixels()[:, 0].astype(int)
    assert brighter[0] > 2 * brighter[2]
    assert darker[2] > 2 * darker[0]
    assert tuple(unknown) == MARKER
    assert equal.min() > 240


def test_the_mean_of_the_relative_map_is_mape():
    a, b = np.random.default_rng(0).random((2, 4, 6, 3))
    assert relative_error_map(a, b).values.mean() == pytest.approx(mape(a, b))


def test_the_z_map_shows_the_channel_that_stands_out():
    z = np.array([[[1.0, -7.0, 2.0], [np.inf, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    shown = z_map(z)
    assert shown.values.tolist() == [[-7, np.inf, 0]]
    low, high, middle = shown.pixels()[0].astype(int)
    assert low[2] > low[0]
    assert high[0] > high[2]
    assert middle.min() > 240


def test_the_bar_runs_from_low_to_high():
    shown = flip_map(np.array([[0.0, 1.0]]))
    assert shown.bar()[[0, -1]].tolist() == shown.pixels()[0].tolist()


@pytest.mark.parametrize(
    ("difference", "scale"),
    [([0, 0, 0], 1), ([0] * 1000 + [-5], 5), ([3.0] * 1000 + [500], 3)],
)
def test_the_scale_ignores_fireflies_and_is_never_0(difference, scale):
    assert scale_of(np.array(difference, float)) == scale


def test_the_histogram_counts_every_pixel():
    values = np.array([0, 0, 0.1, -0.1, 5, -5, -5, np.nan])
    bars = histogram_bars(values, limit=1)
    assert sum(bar.count for bar in bars) == 7
    assert (bars[0].count, bars[30].count, bars[-1].count) == (2, 2, 1)
    assert bars[30].middle == pytest.approx(0, abs=1e-12)
    assert max(bar.height for bar in bars) == 1
