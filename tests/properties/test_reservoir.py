"""Reservoirs: identities of merge, finalize and cap, for any numbers.

The distribution of a whole stream is proved in ``tests/exact``; here single calls are
looked at, also where two random numbers differ by one bit.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.arrays import divide_or_zero
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    cap_confidence,
    choose_second,
    finalize,
    initial_candidates,
    merge,
    reused_candidates,
)
from restir_gi.reference.strategies import (
    ROWS,
    candidates,
    reservoirs,
    samples,
    scalars,
    uniforms,
)

EPS = np.finfo(np.float64).eps
ALMOST_ONE = np.full(ROWS, 1 - 2.0**-24)
LARGEST = np.full(ROWS, 1 - 2.0**-53)
ZERO = np.zeros(ROWS)

numbered = candidates(), candidates(first=ROWS)


def is_near(a, b, steps):
    """Whether numbers agree to some roundings of half an eps each."""
    return bool(np.all(abs(a - b) <= steps * EPS / 2 * np.maximum(abs(a), abs(b))))


# ---------------------------------------------------------------- merge


@given(*numbered, scalars(-5, 5), scalars(-5, 5))
def test_merge_keeps_the_expectation(a, b, f_a, f_b):
    """f(y) W is constant on either side of the choice: two calls integrate it.

    Per row f_a w_a / p̂_a + f_b w_b / p̂_b.  Each term takes at most 7 roundings, and the
    sum one more; they add up in units of the terms, not of the sum.
    """
    took_b, took_a = (merge(a, b, u) for u in (ZERO, LARGEST))
    P_b = divide_or_zero(b.w, a.w + b.w)
    f = np.concatenate([f_a, f_b])
    one = np.ones(ROWS)
    fW_a, fW_b = (f[c.y] * finalize(c, one).W for c in (took_a, took_b))
    terms = f_a * divide_or_zero(a.w, a.p_hat), f_b * divide_or_zero(b.w, b.p_hat)
    # Where b is certain to be taken, u near 1 takes it too: nothing is left for a.
    found = np.where(a.w > 0, (1 - P_b) * fW_a, 0.0) + P_b * fW_b
    tolerance = 8 * EPS * (abs(terms[0]) + abs(terms[1]) + abs(P_b * fW_b))
    # 1 - P_b cancels: its error is that of 1.
    tolerance = tolerance + EPS * abs(fW_a)
    assert (abs(found - (terms[0] + terms[1])) <= tolerance).all()


@given(*numbered, uniforms())
def test_merge_adds_up(a, b, u):
    c = merge(a, b, u)
    assert_array_equal(c.w, a.w + b.w)
    assert_array_equal(c.M, a.M + b.M)


@given(*numbered, uniforms())
def test_merge_keeps_one_of_both_whole(a, b, u):
    c = merge(a, b, u)
    took_b = c.y >= ROWS
    assert_array_equal(c.y, np.where(took_b, b.y, a.y))
    assert_array_equal(c.p_hat, np.where(took_b, b.p_hat, a.p_hat))


@given(candidates(y=samples()), candidates(y=samples()), uniforms())
def test_merge_keeps_all_fields_of_a_sample_together(a, b, u):
    """A sample is a position with its own normal and its own light."""
    c = merge(a, b, u)
    took_b = choose_second(a.w, b.w, u)[:, None]
    for name in ("position", "normal", "radiance"):
        expected = np.where(took_b, getattr(b.y, name), getattr(a.y, name))
        assert_array_equal(getattr(c.y, name), expected)


@given(*numbered, uniforms())
def test_merge_leaves_its_input_alone(a, b, u):
    before = [column.copy() for c in (a, b) for column in (c.y, c.p_hat, c.w, c.M)]
    merge(a, b, u)
    after = [column for c in (a, b) for column in (c.y, c.p_hat, c.w, c.M)]
    for old, new in zip(before, after, strict=True):
        assert_array_equal(old, new)


# ---------------------------------------------------------------- the choice


@given(scalars(0, 1e30), uniforms())
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_weight_of_0_is_never_taken(dtype, w, u):
    w, u = w.astype(dtype), u.astype(dtype)
    assert not choose_second(w, w * 0, u).any()
    assert not choose_second(w * 0, w * 0, u).any()


def test_control_a_weak_comparison_takes_a_weight_of_0():
    """What `<=` would do: the reason why the comparison is strict."""
    w, u = np.array([0.0, 1.0]), np.zeros(2)
    assert (u * (w + 0) <= 0).all()
    assert not choose_second(w, 0 * w, u).any()


SMALLEST = {np.float16: 2.0**-24, np.float32: 2.0**-149, np.float64: 2.0**-1074}


@pytest.mark.parametrize("dtype", SMALLEST)
def test_the_first_positive_weight_is_always_taken(dtype):
    """Also subnormal ones, where u w rounds to w for u near 1."""
    info, tiny = np.finfo(dtype), SMALLEST[dtype]
    w = np.array([tiny, 3 * tiny, info.tiny, 1.0, info.max], dtype)
    for u in (0.0, 0.5, 1 - 2.0**-11, 1 - info.epsneg):
        assert choose_second(w * 0, w, np.full(5, u, dtype)).all()


def test_control_a_product_alone_refuses_the_smallest_weight():
    w, u = np.float32([2.0**-149]), np.float32([1 - 2.0**-24])
    assert u * (0 + w) >= w
    assert choose_second(0 * w, w, u).all()


@given(scalars(0, 1e10), scalars(0, 1e10))
def test_the_choice_is_monotonous_in_u(w_a, w_b):
    """One threshold: below it b is taken, above it a."""
    u = np.linspace(0, 1, 9, endpoint=False)
    for a, b in zip(w_a, w_b, strict=True):
        taken = choose_second(np.full(9, a), np.full(9, b), u)
        assert (np.diff(taken.astype(int)) <= 0).all()


@given(arrays(np.int64, ROWS, elements=st.integers(0, 2**20)), *[uniforms()] * 2)
def test_the_threshold_is_where_it_should_be(w, v, u):
    """Whole weights and multiples of 2⁻²⁴ below 2⁵³: the product is exact."""
    w_a, w_b = w, np.floor(v * 2**8)
    expected = (u * 2**24).astype(int) * (w_a + w_b).astype(int) < w_b * 2**24
    assert_array_equal(choose_second(w_a.astype(float), w_b, u), expected)


# ---------------------------------------------------------------- nothing and nulls


def empty(rows=ROWS):
    return Candidates(np.full(rows, -1), np.zeros(rows), np.zeros(rows), np.zeros(rows))


def same(a, b):
    for name in ("y", "p_hat", "w", "M"):
        assert_array_equal(getattr(a, name), getattr(b, name))


@given(candidates(), uniforms())
def test_an_empty_reservoir_changes_nothing(c, u):
    same(merge(c, empty(), u), c)


@given(candidates(), uniforms())
def test_an_empty_reservoir_takes_all(c, u):
    """The sample of a null is of no matter."""
    merged = merge(empty(), c, u)
    alive = c.w > 0
    assert_array_equal(merged.y[alive], c.y[alive])
    assert_array_equal(merged.p_hat, c.p_hat)
    assert_array_equal(merged.w, c.w)
    assert_array_equal(merged.M, c.M)


@given(reservoirs(), scalars(0.25, 4), scalars(1, 100), uniforms())
def test_a_null_dilutes(r, p_hat, k, u):
    """M trials without success: same sample, W M / (M + k).

    Six roundings: two products, two quotients, and two on the right.
    """
    null = Candidates(np.full(ROWS, -1), ZERO, ZERO, k)
    for order in (0, 1):
        pair = reused_candidates(r, p_hat), null
        c = merge(pair[order], pair[1 - order], u)
        closed = finalize(c, c.M)
        alive = r.W > 0
        assert_array_equal(closed.y[alive], r.y[alive])
        assert is_near(closed.W, r.W * (r.M / (r.M + k)), 6)


@given(reservoirs(), scalars(0.25, 4), uniforms())
def test_a_copy_of_itself_changes_nothing_but_M(r, p_hat, u):
    """Four roundings: two products, two quotients; doubling is exact."""
    c = reused_candidates(r, p_hat)
    both = merge(c, c, u)
    closed = finalize(both, both.M)
    assert_array_equal(closed.y, r.y)
    assert is_near(closed.W, r.W, 4)
    assert_array_equal(closed.M, 2 * r.M)


# ---------------------------------------------------------------- opening and closing


@given(reservoirs(), scalars(0.25, 4))
def test_closing_undoes_opening(r, p_hat):
    """Four roundings."""
    closed = finalize(reused_candidates(r, p_hat), r.M)
    assert is_near(closed.W, r.W, 4)
    assert_array_equal(closed.M, r.M)
    assert_array_equal(closed.y, r.y)


@given(reservoirs(), scalars(0.25, 4), scalars(0.25, 4))
def test_the_jacobian_multiplies(r, p_hat, jacobian):
    """Three roundings a side."""
    c = reused_candidates(r, p_hat, jacobian)
    assert is_near(c.w, p_hat * jacobian * (r.W * r.M), 6)
    same(reused_candidates(r, p_hat, np.ones(ROWS)), reused_candidates(r, p_hat))


@given(scalars(2.0**-10, 2.0**10), scalars(2.0**-10, 2.0**10))
def test_one_fresh_sample_weighs_1_over_its_density(p_hat, pdf):
    """Whatever p̂ is, it cancels: f W = f / p.  Three roundings, and one of 1/p."""
    c = initial_candidates(np.arange(ROWS), p_hat, pdf)
    assert is_near(finalize(c, c.M).W, 1 / pdf, 4)
    assert_array_equal(c.M, 1)


def test_a_fresh_null_counts():
    p_hat, pdf = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    c = initial_candidates(np.arange(3), p_hat, pdf)
    assert_array_equal(c.w, 0)
    assert_array_equal(c.M, 1)


@given(candidates(), arrays(bool, ROWS), scalars(2.0**-10, 1000))
def test_finalize_is_total(c, is_zero, divisor):
    """0 where p̂, w or the divisor is; else w = W p̂ Z, to two roundings a side."""
    normalization = np.where(is_zero, 0.0, divisor)
    W = finalize(c, normalization).W
    kept = (c.w > 0) & (c.p_hat > 0) & (normalization > 0)
    assert_array_equal(W[~kept], 0)
    assert is_near((W * normalization * c.p_hat)[kept], c.w[kept], 4)


# ---------------------------------------------------------------- the cap


@given(reservoirs(), st.floats(1, 600))
def test_the_cap_limits_trust_alone(r, cap):
    capped = cap_confidence(r, cap)
    assert_array_equal(capped.M, np.minimum(r.M, cap))
    assert_array_equal(capped.W, r.W)
    assert_array_equal(capped.y, r.y)


@given(reservoirs(), st.floats(1, 600), st.floats(1, 600))
def test_of_two_caps_the_lower_one_counts(r, a, b):
    twice = cap_confidence(cap_confidence(r, a), b)
    assert_array_equal(twice.M, cap_confidence(r, min(a, b)).M)


@given(reservoirs())
def test_no_cap_changes_nothing(r):
    assert_array_equal(cap_confidence(r, float("inf")).M, r.M)


@given(uniforms(12), st.integers(1, 8), st.integers(1, 8))
def test_caps_agree_until_one_is_reached(u, low, more):
    """Chains under two caps are the same numbers until M exceeds the lower one."""

    def chain(cap):
        r, history = None, []
        for t, number in enumerate(u):
            new = initial_candidates(np.array([t]), np.array([1.0 + t % 3]), np.ones(1))
            if r is not None:
                new = merge(reused_candidates(r, 1.0 + r.y % 3), new, number)
            r = cap_confidence(finalize(new, new.M), cap)
            history.append((r.y[0], r.W[0]))
        return history

    # M of frame t is t + 1 before it is capped; frame `low` is the first that forgets.
    assert chain(low)[: low + 1] == chain(low + more)[: low + 1]


def test_control_caps_differ_afterwards():
    def frames(cap):
        r = Reservoirs(np.zeros(1), np.ones(1), np.array([5.0]))
        old = reused_candidates(cap_confidence(r, cap), np.ones(1))
        both = merge(
            old, initial_candidates(np.ones(1), np.ones(1), 2 * np.ones(1)), 0.9
        )
        return finalize(both, both.M).W[0]

    assert frames(2.0) != frames(3.0)
