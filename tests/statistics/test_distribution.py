"""Tests of "same distribution": exact by enumeration, and sharp on what is planted.

Exactness needs no statistics: all choices are counted.  Where columns are drawn under
the claim, each p-value is below ALPHA with probability at most ALPHA, independently of
the others, so their number exceeds `MOST` with probability 1e-9.
"""

from collections import Counter
from itertools import combinations
from itertools import permutations as permutations_of
from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import binom, mannwhitneyu

from restir_gi.reference.oracle.statistics.distribution import (
    distribution_p_values,
    location_p_values,
    permutation_p_values,
    permutations,
    resolution,
    spread_p_values,
)
from restir_gi.reference.oracle.statistics.families import (
    average_e,
    bonferroni,
    e_benjamini_hochberg,
    p_to_e,
    rejects,
)
from restir_gi.reference.oracle.statistics.power import (
    bets_needed,
    replicates_needed,
    smallest_detectable,
)
from restir_gi.reference.oracle.statistics.ranks import count_sums

COLUMNS, ALPHA = 4000, 1e-2
MOST = binom.isf(1e-9, COLUMNS, ALPHA)

few_values = st.lists(st.integers(0, 5), min_size=3, max_size=9)  # many ties

# ---------------------------------------------------------------- exactness


@given(few_values, st.integers(1, 8))
def test_sums_are_counted_as_by_hand(scores, size):
    size = min(size, len(scores) - 1)
    found = count_sums(np.array(scores), size)
    expected = Counter(sum(chosen) for chosen in combinations(scores, size))
    assert {s: n for s, n in enumerate(found) if n} == expected


@pytest.mark.parametrize(
    "p_values", [location_p_values, spread_p_values, distribution_p_values]
)
@given(few_values, st.integers(1, 8))
def test_no_level_is_exceeded(p_values, values, size):
    """P(p <= t) <= t for every t: all ways to call k of n values the backend's."""
    size = min(size, len(values) - 1)
    rows = np.array(values, np.float64)
    chosen = list(combinations(range(len(rows)), size))
    backend = np.array([rows[list(c)] for c in chosen]).T
    reference = np.array([np.delete(rows, c) for c in chosen]).T
    p = np.sort(p_values(backend, reference))
    share = np.arange(1, len(p) + 1) / len(p)
    last_of_its_value = np.append(p[1:] > p[:-1] * (1 + 1e-12), True)
    # Both sides are quotients of integers: 4 roundings.
    assert np.all(share[last_of_its_value] <= p[last_of_its_value] * (1 + 1e-15 * 4))


@given(st.lists(st.integers(0, 9), min_size=6, max_size=6), st.integers(1, 5))
def test_random_orders_count_equal_sums_as_by_hand(tenths, size):
    """All 720 orders; tenths, whose sums are rounded differently in each."""
    orders = np.array(list(permutations_of(range(6))))
    sums = np.array(tenths)[orders[:, :size]].sum(axis=1)
    far = abs(6 * sums - size * sum(tenths))
    rows = np.array(tenths)[:, None] / 10
    found = permutation_p_values(rows[:size], rows[size:], 5.0, orders)
    assert found == (1 + np.count_nonzero(far >= far[0])) / 721


@pytest.mark.parametrize(("ours", "theirs"), [(5, 9), (17, 17), (30, 12)])
def test_scipy_agrees_where_there_are_no_ties(ours, theirs):
    rng = np.random.default_rng(1)
    a, b = rng.random((ours, 20)), rng.random((theirs, 20))
    expected = mannwhitneyu(a, b, axis=0, method="exact").pvalue
    assert_allclose(location_p_values(a, b), expected, rtol=1e-12)


def test_seventeen_replicates_resolve_1e_9():
    low, high = np.arange(17.0)[:, None], np.arange(17.0, 34.0)[:, None]
    assert resolution(17, 17) == 2 / comb(34, 17) < 1e-9
    assert_allclose(location_p_values(low, high), resolution(17, 17), rtol=1e-13)
    assert_allclose(
        distribution_p_values(high, low), 2 * resolution(17, 17), rtol=1e-13
    )


@pytest.mark.parametrize(
    "p_values", [location_p_values, spread_p_values, distribution_p_values]
)
def test_equal_values_say_nothing(p_values):
    assert_array_equal(p_values(np.ones((5, 2)), np.ones((7, 2))), [1, 1])


def test_a_sum_of_more_choices_than_a_float_holds_is_refused():
    with pytest.raises(ValueError, match="1000"):
        count_sums(np.zeros(1001, np.int64), 500)


# ---------------------------------------------------------------- false alarms, power


def heavy(rng, rows, columns=COLUMNS):
    """Black in a third of the cases, else lognormal with a CV of 7."""
    light = np.exp(2 * rng.standard_normal((rows, columns)))
    return np.where(rng.random((rows, columns)) < 1 / 3, 0.0, light)


def test_false_alarms_stay_below_their_rate():
    rng = np.random.default_rng(2)
    p = distribution_p_values(heavy(rng, 12), heavy(rng, 16))
    print(f"{np.count_nonzero(p <= ALPHA)} of {COLUMNS} below {ALPHA}")
    assert np.count_nonzero(p <= ALPHA) <= MOST


@pytest.mark.slow
def test_false_alarms_stay_below_smaller_rates():
    """40,000 columns of 32 and 32 runs without ties, at 1e-3 and 1e-4."""
    rng, columns = np.random.default_rng(8), 40_000
    a, b = np.exp(2 * rng.standard_normal((2, 32, columns)))
    p = distribution_p_values(a, b)
    for alpha in (1e-3, 1e-4):
        print(f"{np.count_nonzero(p <= alpha)} of {columns} below {alpha}")
        assert np.count_nonzero(p <= alpha) <= binom.isf(1e-9, columns, alpha)


def test_false_alarms_of_random_orders_stay_below_their_rate():
    """The columns share their orders, and are not independent; 999 hold that down.

    Each column alone has the stated rate; together they fluctuate more than binomially,
    by the noise of the share of orders, √(ALPHA / 999): four times that is allowed.
    """
    rng = np.random.default_rng(3)
    a, b = heavy(rng, 12), heavy(rng, 16)
    p = permutation_p_values(a, b, 10.0, permutations(rng, 28, 999))
    alarms = np.count_nonzero(p <= ALPHA)
    assert alarms <= MOST + 4 * COLUMNS * np.sqrt(ALPHA / 999)
    assert p.min() >= 1 / 1000


@pytest.mark.parametrize("factor", [0.4, 2.5])
def test_control_a_brighter_or_darker_backend_is_found(factor):
    """CV 0.4 and 32 runs of each; missed in 0.6 % of 5,000 columns at 1e-6."""
    rng = np.random.default_rng(4)
    a, b = (rng.gamma(6, 1, (32, 8)) for _ in range(2))
    a[:, 0] *= factor
    p = distribution_p_values(a, b)
    assert p[0] < 1e-6
    assert p[1:].min() > 1e-4
    assert permutation_p_values(a, b, 50.0, permutations(rng, 64, 999))[0] == 1e-3


def test_control_a_change_of_variance_alone_is_found():
    """Four times the standard deviation between runs, 64 of each, at 1e-6.

    That is found in 98.6 % of 2,000 columns, so at least 7 of 8 with 99.5 %.
    """
    rng = np.random.default_rng(5)
    a, b = 10 + 4 * rng.standard_normal((64, 8)), 10 + rng.standard_normal((64, 8))
    assert np.count_nonzero(distribution_p_values(a, b) <= 1e-6) >= 7
    assert location_p_values(a, b).min() > 1e-4


def test_control_variance_within_images_shows_a_tenth():
    """1.1 times the noise of 1024 pixels: their spread is the functional, 24 runs."""
    rng = np.random.default_rng(6)
    a, b = (s * rng.standard_normal((24, 1024)) for s in (1.1, 1.0))
    p = distribution_p_values(a.std(axis=1)[:, None], b.std(axis=1)[:, None])
    assert p < 1e-6


def test_broken_backends_are_refused_and_broken_references_raise():
    fine = np.random.default_rng(7).random((9, 3))
    broken = fine.copy()
    broken[3, 0], broken[5, 1] = np.nan, np.inf
    for p in (
        distribution_p_values(broken, fine),
        permutation_p_values(broken, fine, 1.0, np.arange(18)[None]),
    ):
        assert_array_equal(p == 0, [True, True, False])
    with pytest.raises(ValueError, match="finite"):
        distribution_p_values(fine, broken)
    with pytest.raises(ValueError, match="columns"):
        distribution_p_values(fine, fine[:, :2])
    with pytest.raises(ValueError, match="replicate"):
        distribution_p_values(fine[:0], fine)


# ---------------------------------------------------------------- families


@given(st.lists(st.sampled_from([0.0, 0.5, 1, 3, 20, 1e9, np.inf]), min_size=1))
def test_named_columns_are_as_by_hand(e):
    m, alpha = len(e), 0.1
    fit = [k for k in range(1, m + 1) if k * sorted(e)[-k] >= m / alpha * (1 - 1e-14)]
    expected = [value >= sorted(e)[-max(fit)] for value in e] if fit else [False] * m
    assert e_benjamini_hochberg(e, alpha).tolist() == expected


def test_a_mean_of_e_values_raises_the_alarm_of_one():
    assert average_e([1.0, 3.0]) == 2
    assert average_e([np.inf, 4.0], [0.0, 1.0]) == 4
    assert average_e([np.inf, 4.0]) == np.inf
    assert rejects([1e6, 9e5], 1e-6).tolist() == [True, False]
    for e, weights in (([np.nan], None), ([-1.0], None), ([1, 1], [0.7, 0.7])):
        with pytest.raises(ValueError, match=r"not negative|non-negative"):
            average_e(e, weights)


def test_p_values_are_combined_and_turned_into_e_values():
    assert bonferroni([0.5, 1e-8, 0.1]) == pytest.approx(3e-8, rel=1e-15)
    assert bonferroni([0.5, 0.9]) == 1
    assert_allclose(p_to_e([1.0, 1e-9, 0.0], 0.1), [0.1, 0.1 * 1e9**0.9, np.inf])
    # On the grid of p-values 1/n, ..., 1: a mean at most 1, and near it.
    mean = np.mean(p_to_e(np.arange(1, 100_001) / 100_000, 0.5))
    assert 0.99 < mean <= 1
    with pytest.raises(ValueError, match="numbers"):
        bonferroni([np.nan])


def test_sample_sizes_are_those_of_the_table():
    assert_allclose(smallest_detectable(1, 1, 1e-6, 769) ** 2, 70.5, rtol=1e-2)
    assert_allclose(replicates_needed(0.3, 0.1, 1e-6, 769), 634, rtol=1e-2)
    assert_allclose(replicates_needed(1, 0.1, 1e-6, 1), 5210, rtol=1e-2)
    assert_allclose(bets_needed(0.63, -0.03, 3.7, 1e-6, 769), 19_950, rtol=0.1)
    assert bets_needed(0.1, -0.03, 367, 1e-6) > 300_000
