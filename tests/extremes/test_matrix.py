"""Every kernel at every extreme in three types, beside exact numbers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restir_gi.reference.oracle.exact.extremes import EXTREMES
from restir_gi.reference.oracle.exact.judge import judge
from restir_gi.reference.oracle.exact.matrix import TYPES, cell, judged_cell, reads
from restir_gi.reference.oracle.exact.numbers import (
    EXACT,
    UndecidedError,
    exact,
    type_of,
)
from restir_gi.reference.oracle.exact.registry import kernels, limits_of
from restir_gi.reference.oracle.exact.worst import worst_rows
from restir_gi.reference.oracle.parts import whole_contract
from tests.extremes.search import search

BY_NAME = {kernel.name: kernel for kernel in kernels()}
ROWS = 6
every_kernel = pytest.mark.parametrize("kernel", kernels(), ids=lambda k: k.name)
every_type = pytest.mark.parametrize("dtype", TYPES)


def met_by(kernel):
    return [extreme for extreme in EXTREMES if reads(kernel, extreme)]


@every_kernel
def test_finite_silent_and_as_exact_as_rounding_allows(kernel):
    """The bound is running error analysis, so that no row may exceed it."""
    for extreme in met_by(kernel):
        for dtype in TYPES:
            found = cell(kernel, extreme, dtype, ROWS)
            assert found.passed, (extreme.name, found.type, found.fault, found.inputs)


@every_kernel
def test_a_kernel_keeps_its_type(kernel):
    """Half the digits in, half the digits out: or its error would be another's."""
    for dtype in TYPES:
        found = cell(kernel, EXTREMES[0], dtype, 2)
        said = kernel.run(found.inputs)
        assert said.dtype == dtype or said.dtype.kind in "biu"


@every_kernel
def test_what_it_gives_is_defined_at_each_extreme_that_it_can_meet(kernel):
    met = {extreme.name for extreme in met_by(kernel)}
    assert set(kernel.defines) == met - {"plain"}
    assert kernel.of_contract in ("", *whole_contract())


def test_the_kernels_of_the_contract_have_their_limits():
    for name in ("jacobian", "target", "merge", "finalize", "similar", "shade"):
        assert limits_of(name)


# ---------------------------------------------------------------- controls


def spoiled(name, change):
    kernel = BY_NAME[name]
    return replace(kernel, run=lambda given: change(kernel.run(given)))


def fails(kernel, extreme="plain", dtype=np.float32, rows=64):
    at = next(e for e in EXTREMES if e.name == extreme)
    return not cell(kernel, at, dtype, rows).passed


@every_type
@pytest.mark.parametrize(
    ("name", "places"),
    [("closing: W", 4), ("weight of a new sample", 2), ("luminance", 8),
     ("jacobian", 48), ("target, scattered", 24)],
)  # fmt: skip
def test_control_an_error_of_some_places_is_seen(name, places, dtype):
    """As many roundings as the formula has, once more."""
    eps = float(np.finfo(dtype).eps)
    wrong = spoiled(name, lambda x: (x * (1 + places * eps)).astype(x.dtype))
    assert fails(wrong, dtype=dtype)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_control_what_is_not_finite_is_seen_also_in_open_rows(bad):
    at = "in a corner"
    assert fails(spoiled("jacobian", lambda x: np.where(x == 0, bad, x)), at)


def test_control_a_warning_is_seen():
    def warns(x):
        return x + 0 * (np.ones_like(x) / (x * 0)) if len(x) else x

    kernel = BY_NAME["jacobian"]
    found = cell(replace(kernel, run=lambda g: warns(kernel.run(g))), EXTREMES[0],
                 np.float64, 4)  # fmt: skip
    assert "divide" in found.fault or "invalid" in found.fault
    assert not found.passed


@pytest.mark.parametrize("name", ["which of two is kept", "similar", "cell-level"])
def test_control_a_wrong_decision_is_seen(name):
    wrong = (lambda x: x + 1) if name == "cell-level" else np.logical_not
    assert fails(spoiled(name, wrong))


def test_control_infinity_in_place_of_the_largest_number():
    kernel = BY_NAME["closing: W"]
    given_ = {k: np.array([v], np.float32) for k, v in
              {"w": 1e30, "p_hat": 1e-30, "Z": 1.0}.items()}  # fmt: skip
    most = np.array([np.finfo(np.float32).max])
    type_ = type_of(np.float32)
    assert judge(kernel, given_, most, type_).share[0] == 0
    for wrong in (most / 2, np.array([np.inf])):
        assert judge(kernel, given_, wrong, type_).share[0] > 1


# ---------------------------------------------------------------- the bound itself

numbers = st.floats(-100, 100, width=16)


@given(numbers, numbers, numbers, numbers)
def test_arithmetic_of_the_type_stays_within_the_bound(a, b, c, d):
    """(a b + c) / d − √|a|, in half precision and exactly."""
    half = [np.float16(x) for x in (a, b, c, d)]
    wide = [exact(float(x), type_of(np.float16)) for x in half]
    with np.errstate(all="ignore"):
        below = half[3] != 0
        quotient = (half[0] * half[1] + half[2]) / half[3] if below else np.float16(0)
        found = quotient - np.sqrt(abs(half[0]))
    value = (wide[0] * wide[1] + wide[2]) / wide[3] - abs(wide[0]).sqrt()
    if np.isfinite(found):
        assert abs(EXACT.mpf(float(found)) - value.value) <= value.error


def test_a_comparison_within_the_bound_is_left_open():
    half = type_of(np.float16)
    third = exact(1, half) / 3
    with pytest.raises(UndecidedError):
        assert third > exact(float(np.float16(1 / 3)), half)
    assert third > exact(0.33, half)
    assert third < exact(0.34, half)


# ---------------------------------------------------------------- the worst rows


@every_kernel
def test_the_worst_rows_that_were_found_stay_within_the_bound(kernel):
    for worst in worst_rows():
        if worst.kernel == kernel.name:
            found = judged_cell(kernel, worst.extreme, worst.inputs)
            assert found.passed, (worst, found.fault, found.judged.share)


def test_there_is_a_worst_row_for_each_kernel_and_type():
    kept = {(w.kernel, w.type) for w in worst_rows()}
    assert kept == {(k, np.dtype(t).name) for k in BY_NAME for t in TYPES}


@every_type
def test_a_search_for_worse_rows_finds_no_fault(dtype):
    """A short one; `tests.extremes.search` looks longer."""
    for name in ("jacobian", "target, scattered", "closing: W", "GGX density D"):
        assert search(BY_NAME[name], dtype, 25)[0].share <= 1


def test_control_a_search_finds_what_is_wrong_in_few_rows():
    """W too large by four places where w is above p̂ · 2⁴⁰."""
    kernel = BY_NAME["closing: W"]

    def wrong(given_):
        W = kernel.run(given_)
        return np.where(W > 2.0**40, W * (1 + 2.0**-20), W).astype(W.dtype)

    with pytest.raises(AssertionError, match="closing"):
        search(replace(kernel, run=wrong), np.float64, 200)
