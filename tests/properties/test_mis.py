"""What the sum of weights is divided by: 1/M, 1/Z, balance heuristic."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.resampling.reservoir import (
    balance_heuristic,
    one_over_m,
    one_over_z,
)

K, ROWS = 4, 3


def rationals(smallest=0):
    """K arrays of twentieths, at least ``smallest`` of them, up to 50."""
    twentieths = arrays(np.int64, (K, ROWS), elements=st.integers(smallest, 1000))
    return twentieths.map(lambda a: list(a * Fraction(1, 20)))


masks = arrays(bool, (K, ROWS)).map(list)


@given(rationals())
def test_one_over_m_is_the_sum(M):
    assert_array_equal(one_over_m(M), sum(M))


@given(rationals(), masks)
def test_z_counts_those_who_could_have_made_it(M, holds):
    expected = [
        sum((m[row] for m, h in zip(M, holds, strict=True) if h[row]), Fraction(0))
        for row in range(ROWS)
    ]
    assert_array_equal(one_over_z(M, holds), expected)


@given(rationals(), masks)
def test_z_is_at_most_m(M, holds):
    assert (one_over_z(M, holds) <= one_over_m(M)).all()
    everybody = [np.ones(ROWS, bool)] * K
    assert_array_equal(one_over_z(M, everybody), one_over_m(M))


@given(rationals(1), rationals(), st.integers(0, K - 1))
def test_the_balance_heuristic_is_its_formula(M, p, made):
    """Σ M_k p_k / p_s; 0 where the maker could not have made it."""
    found = balance_heuristic(M, p, p[made])
    for row in range(ROWS):
        total = sum(m[row] * q[row] for m, q in zip(M, p, strict=True))
        expected = total / p[made][row] if p[made][row] else 0
        assert found[row] == expected


@given(rationals(1), rationals(), masks)
def test_weights_sum_to_1_over_the_makers(M, p, holds):
    """Unbiasedness in one line: Σ_s M_s / normalization_s = 1, exactly."""
    p = [np.where(h, q + 1, Fraction(0)) for h, q in zip(holds, p, strict=True)]
    nothing, one = Fraction(0), Fraction(1)
    by_z, by_balance = np.full((2, ROWS), nothing)
    for m, q, h in zip(M, p, holds, strict=True):
        share = np.where(h, m, nothing)
        by_z = by_z + share / np.where(h, one_over_z(M, holds), one)
        by_balance = by_balance + share / np.where(h, balance_heuristic(M, p, q), one)
    somebody = np.any(holds, axis=0)
    assert_array_equal(by_z, somebody.astype(int))
    assert_array_equal(by_balance, somebody.astype(int))


@given(rationals(1), rationals(1), masks)
def test_control_1_over_m_sums_to_less_where_supports_differ(M, p, holds):
    """The reason for its bias."""
    total = sum(np.where(h, m, 0) for m, h in zip(M, holds, strict=True))
    share = total / one_over_m(M)
    assert_array_equal(share < 1, ~np.all(holds, axis=0))


@given(rationals(), masks)
def test_of_equal_targets_the_balance_heuristic_is_1_over_z(M, holds):
    p = [np.where(h, Fraction(7, 3), Fraction(0)) for h in holds]
    made = np.full(ROWS, Fraction(7, 3))
    assert_array_equal(balance_heuristic(M, p, made), one_over_z(M, holds))
