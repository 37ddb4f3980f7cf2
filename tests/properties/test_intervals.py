"""Intervals beside those of SciPy, which resamples and counts by itself."""

import warnings

import numpy as np
import pytest
from scipy import stats

from restir_gi.reference.numerics.intervals import (
    DRAWS,
    Interval,
    bootstrap_interval,
    median_interval,
    ratio_interval,
)


def variance_of(values):
    return lambda index: values[index].var(axis=-1)


@pytest.mark.parametrize("runs", [3, 8, 32])
@pytest.mark.parametrize(
    ("corrected", "method"), [(False, "percentile"), (True, "BCa")]
)
def test_the_bootstrap_is_that_of_scipy(runs, corrected, method):
    """SciPy draws the same runs; between two neighbours of the 4000 it interpolates."""
    values = np.random.default_rng(runs).gamma(0.5, size=runs)
    statistic = variance_of(values)
    found = bootstrap_interval(statistic, runs, corrected=corrected)
    theirs = stats.bootstrap(
        (np.arange(runs),),
        lambda index, axis: statistic(index),
        n_resamples=DRAWS,
        vectorized=True,
        method=method,
        rng=0,
    )
    drawn = np.sort(theirs.bootstrap_distribution)
    assert found.value == values.var()
    for end, wanted in zip(
        (found.low, found.high), theirs.confidence_interval, strict=True
    ):
        place = np.searchsorted(drawn, wanted)
        assert drawn[max(place - 1, 0)] <= end <= drawn[min(place + 1, DRAWS - 1)]


def test_control_without_the_correction_a_skewed_number_has_another_interval():
    statistic = variance_of(np.random.default_rng(32).gamma(0.5, size=32))
    plain, corrected = (
        bootstrap_interval(statistic, 32, corrected=c) for c in (False, True)
    )
    assert corrected.high > 1.05 * plain.high


def test_kinds_of_runs_are_resampled_by_themselves():
    """The ratio of two independent means scatters more than that of one to itself."""
    rng = np.random.default_rng(0)
    a, b = rng.uniform(1, 2, (2, 40))

    def ratio(i, j):
        return a[i].mean(axis=-1) / b[j].mean(axis=-1)

    apart = bootstrap_interval(ratio, 40, 40, corrected=True)
    together = ratio_interval(a, a)
    assert apart.low < apart.value < apart.high
    assert together == Interval(1.0, 1.0, 1.0)
    theirs = stats.bootstrap(
        (a, b), lambda x, y, axis: x.mean(axis) / y.mean(axis),
        n_resamples=DRAWS, vectorized=True, method="BCa", rng=1,
    ).confidence_interval  # fmt: skip
    # An end of 4000 draws has a standard error of 0.042 sigma; of the difference of two
    # sets of draws, 5 % of a width of 3.92 sigma is 3.3 of them.
    wide = apart.high - apart.low
    assert (apart.low, apart.high) == pytest.approx(tuple(theirs), abs=0.05 * wide)


def test_runs_that_are_alike_have_an_interval_without_width():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = bootstrap_interval(variance_of(np.ones(5)), 5, corrected=True)
    assert found == Interval(0.0, 0.0, 0.0)


@pytest.mark.parametrize("count", range(6, 60))
def test_the_median_has_the_interval_of_the_sign_test(count):
    values = np.random.default_rng(count).normal(size=count)
    theirs = stats.quantile_test(values, p=0.5).confidence_interval(0.95)
    assert median_interval(values) == Interval(np.median(values), *theirs)


@pytest.mark.parametrize("count", range(1, 6))
def test_few_numbers_are_all_in_the_interval_of_their_median(count):
    values = np.random.default_rng(count).normal(size=count)
    wanted = Interval(np.median(values), values.min(), values.max())
    assert median_interval(values) == wanted
