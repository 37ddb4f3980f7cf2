"""Bounds on rounding hold for single precision, in several orders of operations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from restir_gi.reference.oracle.replay.bounded import constant, exact, rounding_of
from restir_gi.reference.oracle.replay.formulas import jacobian, target
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.verbs import inner, square_root, where_positive

ROUNDING = rounding_of("float32")
SINGLE = np.float32

finite = hnp.arrays(
    SINGLE,
    (16,),
    elements=st.floats(-(2.0**20), 2.0**20, width=32, allow_subnormal=False),
)
vectors = hnp.arrays(
    SINGLE,
    (16, 3),
    elements=st.floats(-(2.0**6), 2.0**6, width=32, allow_subnormal=False),
)


def within(found, bounded):
    """Whether single-precision numbers lie within the bound."""
    difference = np.abs(found.astype(float) - bounded.value)
    return (difference <= bounded.error).all()


@given(finite, finite)
def test_sums_products_and_quotients(a, b):
    A, B = exact(a, ROUNDING), exact(b, ROUNDING)
    assert within(a + b, A + B)
    assert within(a - b, A - B)
    assert within(a * b, A * B)
    safe = np.where(np.abs(b) > 2.0**-20, b, SINGLE(1))
    assert within(a / safe, A / exact(safe, ROUNDING))


@given(vectors, vectors)
def test_inner_products_in_any_order_fused_or_not(a, b):
    bounded = inner(exact(a, ROUNDING), exact(b, ROUNDING))
    x, y, z = (a[:, k] * b[:, k] for k in range(3))
    wide = [a[:, k].astype(float) * b[:, k].astype(float) for k in range(3)]
    fused = (wide[0] + (wide[1] + wide[2]).astype(SINGLE)).astype(SINGLE)
    for found in ((x + y) + z, x + (y + z), (z + x) + y, fused):
        assert within(found, bounded)


@given(vectors, vectors, vectors, vectors)
@settings(max_examples=200)
def test_the_jacobian_in_three_ways_of_writing_it(x_from, x_to, position, normal):
    n = normal / np.maximum(np.linalg.norm(normal, axis=1), SINGLE(1e-3))[:, None]
    n = n.astype(SINGLE)
    y = SamplePoint(*(exact(v, ROUNDING) for v in (position, n, n)))
    a, b = (
        ReceiverPoint(*(exact(v, ROUNDING) for v in (x, x, x))) for x in (x_from, x_to)
    )
    J = jacobian(a, b, y)
    v, w = x_from - position, x_to - position
    d, e = (v * v).sum(axis=1), (w * w).sum(axis=1)
    with np.errstate(all="ignore"):
        c_v, c_w = np.abs((n * v).sum(axis=1)), np.abs((n * w).sum(axis=1))
        normalized = [
            np.abs((n * (u / np.sqrt(s)[:, None])).sum(axis=1))
            for u, s in ((v, d), (w, e))
        ]
        ways = [
            (c_w / np.sqrt(e)) / (c_v / np.sqrt(d)) * (d / e),
            normalized[1] / normalized[0] * d / e,
            c_w / c_v * np.sqrt(d / e) * (d / e),
        ]
    # Where a denominator is 0 the contract says 0, which these ways do not.
    known = np.isfinite(J.error) & (d > 0) & (e > 0) & (c_v > 0)
    for found in ways:
        ok = np.abs(found.astype(float) - J.value) <= J.error
        assert ok[known].all()


@given(vectors, vectors, vectors, vectors)
def test_the_target_in_two_ways_of_writing_it(position, normal, x, radiance):
    n = normal / np.maximum(np.linalg.norm(normal, axis=1), SINGLE(1e-3))[:, None]
    n, light = n.astype(SINGLE), np.abs(radiance)
    albedo = np.full_like(light, 0.5)
    receiver = ReceiverPoint(*(exact(v, ROUNDING) for v in (x, n, albedo)))
    y = SamplePoint(*(exact(v, ROUNDING) for v in (position, -n, light)))
    p_hat = target("scattered", receiver, y)
    v = position - x
    d = np.sqrt((v * v).sum(axis=1))
    Y = light * SINGLE([0.2126, 0.7152, 0.0722])
    with np.errstate(all="ignore"):
        omega = np.where(d[:, None] > 0, v / d[:, None], SINGLE(0))
    cosine = np.maximum((n * omega).sum(axis=1), SINGLE(0))
    first = (Y * albedo).sum(axis=1) * cosine / SINGLE(np.pi)
    second = (Y * (albedo / SINGLE(np.pi))).sum(axis=1) * cosine
    known = np.isfinite(p_hat.error)
    for found in (first, second):
        ok = np.abs(found.astype(float) - p_hat.value) <= p_hat.error
        assert ok[known].all()


@given(finite)
def test_roots(a):
    x = np.abs(a)
    assert within(np.sqrt(x), square_root(exact(x, ROUNDING)))


def _perhaps_zero():
    """3 · (1/3) − 1, which rounding may leave on either side of 0."""
    third = exact(np.array([1 / 3]), ROUNDING)
    three, one = constant(3.0, third), constant(1.0, third)
    return three * third - one


def test_zero_over_zero_is_zero_and_what_may_be_zero_has_no_bound():
    zero, one = exact(np.zeros(1), ROUNDING), exact(np.ones(1), ROUNDING)
    assert (one / zero).value == 0
    assert (one / zero).error == 0
    assert np.isinf((one / _perhaps_zero()).error)


def test_a_sign_within_the_bound_leaves_both_open():
    x = constant(3.0, exact(np.zeros(1), ROUNDING))
    uncertain = where_positive(_perhaps_zero(), x)
    assert uncertain.value - uncertain.error <= 0
    assert uncertain.value + uncertain.error >= 3


@pytest.mark.parametrize("change", [1 + 2.0**-20, 1 - 2.0**-20])
def test_control_an_error_of_8_units_is_outside(change):
    """2⁻²⁰ is 16 half units: more than four of them, and than the two of a product."""
    a = np.linspace(1, 2, 16, dtype=SINGLE)
    A = exact(a, ROUNDING)
    assert not within((a * a * SINGLE(change)), A * A)
