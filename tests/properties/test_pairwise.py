"""Weights in pairs: they share each sample out, exactly, whoever may have made it."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.resampling.pairwise import (
    pairwise_canonical,
    pairwise_neighbor,
)
from restir_gi.reference.resampling.reservoir import balance_heuristic, one_over_m

K, ROWS = 4, 3
FORMS = [False, True]

either_form = pytest.mark.parametrize("defensive", FORMS, ids=["plain", "defensive"])


def rationals(smallest=0, count=K):
    """Arrays of twentieths, at least ``smallest`` of them, up to 50."""
    twentieths = arrays(np.int64, (count, ROWS), elements=st.integers(smallest, 1000))
    return twentieths.map(lambda a: list(a * Fraction(1, 20)))


def weights(M, p, M_c, p_c, defensive):
    """Weights of all who might have made a sample: sources, then the canonical one."""
    S = one_over_m(M)
    sources = [
        pairwise_neighbor(m, q, M_c, p_c, S, defensive)
        for m, q in zip(M, p, strict=True)
    ]
    return [*sources, pairwise_canonical(M, p, M_c, p_c, defensive)]


@either_form
@given(rationals(), rationals(), rationals(1, count=2))
def test_weights_sum_to_1_over_the_receivers_domain(defensive, M, p, own):
    """Whoever else can make the sample: sources with p = 0 or M = 0 among them."""
    M_c, p_c = own
    found = weights(M, p, M_c, p_c, defensive)
    assert_array_equal(sum(found), np.ones(ROWS, int))
    assert all((m >= 0).all() for m in found)


@either_form
@given(rationals(), rationals(), rationals(1, count=2))
def test_who_cannot_make_a_sample_has_no_weight(defensive, M, p, own):
    for m, q, weight in zip(M, p, weights(M, p, *own, defensive), strict=False):
        assert_array_equal(weight > 0, (m > 0) & (q > 0))


@given(rationals(1), rationals(), rationals(1, count=2))
def test_weights_are_their_formulas(M, p, own):
    """From the definitions, row by row; S > 0 and the receiver can make the sample."""
    M_c, p_c = own
    S, T = sum(M), sum(M) + M_c
    plain, defensive = (weights(M, p, M_c, p_c, form) for form in FORMS)
    for row in range(ROWS):
        mine = M_c[row] * p_c[row]
        share = [S[row] * q[row] / (S[row] * q[row] + mine) for q in p]
        for k in range(K):
            assert plain[k][row] == M[k][row] / S[row] * share[k]
            assert defensive[k][row] == M[k][row] / T[row] * share[k]
        rest = sum(M[k][row] * (1 - share[k]) for k in range(K))
        assert plain[K][row] == rest / S[row]
        assert defensive[K][row] == (M_c[row] + rest) / T[row]


@given(rationals(1, count=1), rationals(count=1), rationals(1, count=2))
def test_a_single_pair_is_the_balance_heuristic(M, p, own):
    """As M / normalization, where either could make the sample."""
    M_c, p_c = own
    source, canonical = weights(M, p, M_c, p_c, False)
    for m, q, weight in [(M[0], p[0], source), (M_c, p_c, canonical)]:
        by_balance = balance_heuristic([M[0], M_c], [p[0], p_c], q)
        assert_array_equal(weight * by_balance, np.where(q > 0, m, m * 0))


@either_form
@given(rationals(1), rationals(1, count=2))
def test_of_equal_targets_all_receivers_trust_is_shared_by_m(defensive, M, own):
    """Plain: M_k / T and M_c / T, as with 1/M.  Defensive: c keeps M_c / T before."""
    M_c, p_c = own
    T = one_over_m([*M, M_c])
    *sources, canonical = weights(M, [p_c] * K, M_c, p_c, defensive)
    left = one_over_m(M) / T if defensive else 1
    for m, weight in zip(M, sources, strict=True):
        assert_array_equal(weight, m / T * left)
    before = M_c / T if defensive else 0
    assert_array_equal(canonical, before + M_c / T * left)


@given(rationals(1), rationals(), rationals(1, count=2))
def test_the_defensive_form_always_trusts_the_canonical_sample(M, p, own):
    M_c, p_c = own
    canonical = weights(M, p, M_c, p_c, True)[-1]
    assert (canonical >= M_c / one_over_m([*M, M_c])).all()


@either_form
@given(rationals(), rationals(1, count=2))
def test_without_donors_the_canonical_sample_has_it_all(defensive, p, own):
    nobody = [np.full(ROWS, Fraction(0))] * K
    *sources, canonical = weights(nobody, p, *own, defensive)
    assert_array_equal(canonical, np.ones(ROWS, int))
    assert not np.any(sources)
    assert_array_equal(pairwise_canonical([], [], *own, defensive), canonical)


@either_form
def test_control_without_confidence_of_its_own_the_sum_falls_short(defensive):
    """M_c = 0: what a source cannot make is lost with that source's share, 3 of 4 here.

    The reason why a receiver must have a reservoir of its own.
    """
    M, p = rows(1, 3), rows(5, 0)
    found = weights(M, p, *rows(0, 2), defensive)
    assert list(sum(found)) == [Fraction(1, 4)]


@either_form
def test_null_rows_are_0_in_every_number_type(defensive):
    for kind in (np.float16, np.float32, np.float64, np.longdouble, object):
        zero = np.zeros(2, kind)
        *sources, _ = found = weights([zero] * 2, [zero] * 2, zero, zero, defensive)
        assert all(m.dtype == kind for m in found)
        assert not np.any(sources)


def rows(*values):
    return [np.array([Fraction(v)]) for v in values]


# ---------------------------------------------------------------- the ends


ENDS = [0.0, 5e-324, 1e-300, 1e-150, 1.0, 1e150, 1e300, np.finfo(float).max]


@either_form
@given(
    st.lists(st.sampled_from(ENDS), min_size=K, max_size=K),
    st.sampled_from(ENDS[1:]),
    st.lists(st.sampled_from([0.0, 1.0, 30.0, 500.0]), min_size=K, max_size=K),
    st.sampled_from([1.0, 20.0]),
)
def test_nothing_overflows_and_nothing_is_lost_at_any_scale(defensive, p, p_c, M, M_c):
    """K terms and a sum of K + 1, each of at most 8 roundings: 8 (K + 2) eps.

    A ratio of targets that underflows is below 1e-300, and so is its share.
    """
    M, p = ([np.array([v]) for v in values] for values in (M, p))
    found = weights(M, p, np.array([M_c]), np.array([p_c]), defensive)
    assert np.isfinite(found).all()
    assert abs(sum(found)[0] - 1) <= 8 * (K + 2) * 2.0**-52


@given(rationals(1), rationals(1), rationals(1, count=2), st.integers(-900, 900))
def test_the_unit_of_the_target_does_not_matter(M, p, own, exponent):
    """Powers of two change no bit."""
    M, p, own = ([v.astype(float) for v in values] for values in (M, p, own))
    M_c, p_c = own
    scale = 2.0**exponent
    for form in FORMS:
        here = weights(M, p, M_c, p_c, form)
        there = weights(M, [q * scale for q in p], M_c, p_c * scale, form)
        assert_array_equal(here, there)
