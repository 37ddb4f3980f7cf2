"""Limits on the Jacobian: the same for a shift and for its way back."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from restir_gi.reference.resampling.jacobian_limits import clamp_jacobian, within_limit
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.strategies import views_of_a_patch

ratios = st.lists(
    st.fractions(Fraction(1, 100), 100, max_denominator=100), min_size=1, max_size=5
).map(lambda values: np.array(values, object))
limits = st.fractions(1, 20, max_denominator=20)


@given(ratios, limits)
def test_there_and_back_are_refused_together(J, limit):
    assert_array_equal(within_limit(J, limit), within_limit(1 / J, limit))


@given(ratios, limits)
def test_the_limit_is_on_the_larger_of_j_and_its_inverse(J, limit):
    assert_array_equal(within_limit(J, limit), np.maximum(J, 1 / J) <= limit)


@given(ratios, limits)
def test_clamping_moves_what_is_refused_to_the_nearer_end(J, limit):
    found = clamp_jacobian(J, limit)
    for old, new in zip(J, found, strict=True):
        assert new == sorted([1 / limit, old, limit])[1]
    assert_array_equal(found == J, within_limit(J, limit))


@given(ratios, limits)
def test_clamping_commutes_with_the_way_back(J, limit):
    assert_array_equal(clamp_jacobian(1 / J, limit), 1 / clamp_jacobian(J, limit))


@given(views_of_a_patch(eyes=2), st.floats(1.5, 20))
def test_real_shifts_are_refused_in_both_directions(views, limit):
    """But for J within its rounding of the limit: 64 eps on either side."""
    here, there = views.eyes
    J = reconnection_jacobian(here, there, views.position, views.normal)
    back = reconnection_jacobian(there, here, views.position, views.normal)
    largest = np.maximum(J, 1 / J)
    clear = abs(largest - limit) > 2.0**-46 * limit
    assert_array_equal(within_limit(J, limit)[clear], within_limit(back, limit)[clear])


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64, np.longdouble])
def test_ends_of_the_number_line(kind):
    """No shift at all stays none; no limit refuses nothing else; nothing overflows."""
    most, least = np.finfo(kind).max, np.finfo(kind).smallest_subnormal
    J = np.array([0, least, 1, most], kind)
    assert within_limit(J, np.inf).tolist() == [False, True, True, True]
    assert within_limit(J, 10.0).tolist() == [False, False, True, False]
    assert within_limit(J, 1.0).tolist() == [False, False, True, False]
    assert_array_equal(clamp_jacobian(J, np.inf), J)
    clamped = clamp_jacobian(J, 4.0)
    assert clamped.dtype == kind
    assert clamped.tolist() == [0.0, 0.25, 1.0, 4.0]


def test_rationals_stay_rational_and_the_answer_is_a_mask():
    J = np.array([Fraction(0), Fraction(1, 7), Fraction(2), Fraction(9)], object)
    clamped = clamp_jacobian(J, Fraction(3))
    assert list(clamped) == [0, Fraction(1, 3), 2, 3]
    assert {type(value) for value in clamped} == {Fraction}
    assert within_limit(J, Fraction(3)).dtype == bool


def test_control_a_limit_on_one_side_refuses_one_direction_alone():
    J, limit = np.array([Fraction(1, 9)], object), Fraction(3)
    assert (limit >= J) != (limit >= 1 / J)
