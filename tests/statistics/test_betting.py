"""Bets are fair, find what is planted, and certify what is left.

That they are fair is enumerated: every outcome of a few steps is a column, and its
probability a weight.  No chance is involved.  The tolerance there: up to 8 logarithms
of at most 40 are added, with relative errors of 4 eps each, and exp turns their
absolute error, 3e-13, into a relative one: `ROUNDING`.

Where runs are drawn, the law is a beta law on [0, B] of mean 1, B = 3.7 and CV 0.63, as
skewed as a pixel of the toy scene.  Each run raises a false alarm with probability at
most ALPHA, by Ville's inequality, so the number of alarms is at most binomial: it
exceeds `most_alarms` with probability 1e-9.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import binom

from restir_gi.reference.oracle.statistics.betting import (
    e_value,
    interval_bets,
    open_bets,
    place,
)
from restir_gi.reference.oracle.statistics.certificate import (
    bias_grid,
    certified_bias,
    certified_interval,
    extend,
    open_certificate,
)
from restir_gi.reference.oracle.statistics.families import rejects
from restir_gi.reference.oracle.statistics.intervals import (
    outside_probability,
    truth_interval,
)

ROUNDING = 1e-12
BOUND, CV = 3.7, 0.63


def outcomes(values, chances, steps):
    """All sequences, (steps, sequences), and their probabilities."""
    each = np.array(list(product(range(len(values)), repeat=steps))).T
    return np.asarray(values)[each], np.prod(np.asarray(chances)[each], axis=0)


def history(bets, rows):
    """Bets after each row."""
    for y in rows:
        bets = place(bets, y)
        yield bets


def draws(rng, bias, columns):
    """One replicate a column, of mean 1 + bias."""
    m, v = (1 + bias) / BOUND, (CV * (1 + bias) / BOUND) ** 2
    k = m * (1 - m) / v - 1
    return BOUND * rng.beta(m * k, (1 - m) * k, columns)


def first_rejections(bets, draw, steps, alpha):
    """When each column was first rejected; 0 for never."""
    when = np.zeros(bets.count.shape, int)
    for number in range(1, steps + 1):
        bets = place(bets, draw())
        when[(when == 0) & rejects(e_value(bets), alpha)] = number
        if when.all():
            break
    return when


# ---------------------------------------------------------------- fairness, exactly

laws = st.tuples(
    st.lists(st.sampled_from([0.0, 0.25, 1.0, 1.5, 3.0]), min_size=2, max_size=3),
    st.lists(st.integers(1, 9), min_size=3, max_size=3),
)


@given(laws, st.sampled_from([3.0, 4.0, 50.0]))
def test_no_gambler_gains_or_loses_on_the_truth(law, bound):
    values, weights = law
    chances = np.array(weights[: len(values)]) / sum(weights[: len(values)])
    truth = chances @ values
    rows, probability = outcomes(values, chances, 5)
    for bets in history(open_bets(np.full(len(probability), truth), bound), rows):
        if truth > 0:
            assert_allclose(probability @ np.exp(bets.log_brighter), 1, rtol=ROUNDING)
        assert_allclose(probability @ np.exp(bets.log_darker), 1, rtol=ROUNDING)
        assert_allclose(probability @ e_value(bets), 1, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("past", "winner", "most"),
    [([0.5, 0.1, 0.9], "brighter", 1 / 0.6), ([0.1, 0.3, 0.0], "darker", 1 / 1.4)],
)
def test_a_bet_by_hand(past, winner, most):
    """In units of the bound: the past, and one replicate more of μ and variance μ²."""
    mu, y = 0.3, 0.7
    m, v = (mu + sum(past)) / 4, (mu**2 + 3 * np.var(past)) / 4
    *_, before, after = history(open_bets(2 * mu, 2.0), 2 * np.array([*past, y]))
    bet = np.copysign(min(abs(m - mu) / (v + (m - mu) ** 2), most), m - mu)
    for name in ("brighter", "darker"):
        won = getattr(after, f"log_{name}") - getattr(before, f"log_{name}")
        expected = np.log1p(bet * (y - mu)) if name == winner else 0
        # Some 20 roundings, of numbers near 1.
        assert_allclose(won, expected, rtol=0, atol=20 * 2.2e-16)


@pytest.mark.parametrize("truth", [0.8, 0.9, 1.0, 1.1])
def test_no_truth_in_the_interval_gives_a_gain(truth):
    rows, probability = outcomes([0.0, 2.0], [1 - truth / 2, truth / 2], 8)
    start = interval_bets(np.full(len(probability), 0.8), 1.1, 2.0)
    for bets in history(start, rows):
        assert probability @ np.exp(bets.log_brighter) <= 1 + ROUNDING
        assert probability @ np.exp(bets.log_darker) <= 1 + ROUNDING


@pytest.mark.parametrize(("truth", "winner"), [(0.7, "darker"), (1.2, "brighter")])
def test_control_a_truth_outside_of_the_interval_gives_a_gain(truth, winner):
    rows, probability = outcomes([0.0, 2.0], [1 - truth / 2, truth / 2], 8)
    start = interval_bets(np.full(len(probability), 0.8), 1.1, 2.0)
    *_, bets = history(start, rows)
    assert probability @ np.exp(getattr(bets, f"log_{winner}")) > 1.02


def test_a_guessed_bound_leaves_odds_fair_for_fireflies():
    """Mean 1, but a tenth of the replicates hold 70 % of it, far above B = 2."""
    rows, probability = outcomes([1 / 3, 7.0], [0.9, 0.1], 8)
    for bets in history(open_bets(np.ones(len(probability)), 2.0, False), rows):
        assert probability @ e_value(bets) <= 1 + ROUNDING


def test_control_betting_on_darker_under_a_guessed_bound_is_unfair():
    """Even if the capital is lost or kept as it is from the first violation on."""
    rows, probability = outcomes([1 / 3, 7.0], [0.9, 0.1], 8)
    kept = np.zeros(len(probability))
    for bets in history(open_bets(np.ones(len(probability)), 2.0, False), rows):
        kept = np.where(np.isneginf(bets.log_darker), kept, bets.log_darker)
    assert probability @ np.exp(bets.log_darker) > 1.2
    assert probability @ np.exp(kept) > 1.5


# ---------------------------------------------------------------- false alarms, power


def most_alarms(runs, alpha):
    return binom.isf(1e-9, runs, alpha)


def fireflies(rng, columns):
    """Mean 1, in [0, 40]: one in 50 replicates holds 80 % of the energy."""
    return np.where(rng.random(columns) < 0.02, 40.0, 0.2 / 0.98)


both_laws = pytest.mark.parametrize(
    ("draw", "bound"),
    [(lambda rng, n: draws(rng, 0, n), BOUND), (fireflies, 40.0)],
    ids=["pixel", "fireflies"],
)


def count_alarms(draw, bound, runs, steps, alpha):
    rng, bets = np.random.default_rng(11), open_bets(np.ones(runs), bound)
    when = first_rejections(bets, lambda: draw(rng, runs), steps, alpha)
    print(f"{np.count_nonzero(when)} alarms of {runs} runs at {alpha}")
    return np.count_nonzero(when)


@both_laws
def test_false_alarms_stay_below_their_rate(draw, bound):
    runs, alpha = 4000, 1e-2
    assert count_alarms(draw, bound, runs, 1000, alpha) <= most_alarms(runs, alpha)


@pytest.mark.slow
@both_laws
def test_false_alarms_stay_below_a_smaller_rate(draw, bound):
    runs, alpha = 20_000, 1e-3
    assert count_alarms(draw, bound, runs, 5000, alpha) <= most_alarms(runs, alpha)


@pytest.mark.parametrize(
    ("bias", "limit", "runs"),
    [(-0.3, 900, 200), (0.3, 900, 200), (-0.11, 6200, 100), (-0.03, 68000, 20)],
)
def test_control_planted_biases_are_found(bias, limit, runs):
    """At the level of 769 tests, 1e-6 / 769, within twice the measured 99 % quantile.

    Those are 450, 3,101 and 34,134 replicates for −30 %, −11 % and −3 %: a correct test
    misses a limit with a probability far below 1 % a run.
    """
    rng, bets = np.random.default_rng(12), open_bets(np.ones(runs), BOUND)

    def draw():
        return draws(rng, bias, runs)

    when = first_rejections(bets, draw, limit, 1e-6 / 769)
    print(f"{bias:+.0%}: median {np.median(when)}, last {when.max()}")
    assert when.all()
    assert np.median(when) > limit / 20  # not faster than information allows


# ---------------------------------------------------------------- proofs and ends


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1e-300, 2.0000001])
def test_what_no_correct_backend_returns_is_a_proof(bad):
    bets = open_bets([1.0, 1.0], 2.0)
    for y in ([0.5, 0.5], [bad, 0.5], [1.0, 1.0]):
        bets = place(bets, y)
    assert e_value(bets)[0] == np.inf
    assert np.isfinite(e_value(bets)[1])


def test_values_above_a_guessed_bound_prove_nothing():
    bets = open_bets([1.0, 1.0], 2.0, [False, True])
    for y in (0.1, 0.1, 2.5):
        bets = place(bets, y)
    assert e_value(bets)[0] < 2
    assert e_value(bets)[1] == np.inf
    assert bets.log_darker[0] == -np.inf


def test_black_stays_black_or_is_refuted():
    bets = place(place(open_bets(np.zeros(3), [0.0, 1.0, 1.0]), 0.0), [0, 0, 5e-324])
    assert_array_equal(e_value(bets), [1, 1, np.inf])


def test_no_evidence_from_a_truth_at_the_bound_that_is_met():
    bets = open_bets(1.0, 1.0)
    for _ in range(50):
        bets = place(bets, 1.0)
    assert e_value(bets) == 1


@pytest.mark.parametrize(
    ("truth", "bound"), [(-1, 1), (2, 1), (np.nan, 1), (1, np.inf), (1, np.nan)]
)
def test_no_bets_on_an_impossible_truth(truth, bound):
    with pytest.raises(ValueError, match="truth"):
        open_bets(truth, bound)


def test_evidence_beyond_every_float_is_still_a_number():
    bets = open_bets(1e-3, 1.0)
    for _ in range(1500):
        bets = place(bets, 1.0)
    assert bets.log_brighter > 1000
    assert 1e307 < e_value(bets) < np.inf


@given(st.lists(st.floats(0, 1), max_size=20), st.integers(-990, 990))
def test_units_do_not_matter(values, k):
    bets, scaled = open_bets(0.25, 1.0), open_bets(2.0**k / 4, 2.0**k)
    for y in values:
        y = np.round(y, 2) * 2.0**-3  # keeps bits clear of the subnormals
        bets, scaled = place(bets, y), place(scaled, y * 2.0**k)
    assert_array_equal(e_value(bets), e_value(scaled))


def test_an_interval_of_a_truth_with_an_error():
    low, high = truth_interval([1.0, 0.1], [0.1, 0.1], 4)
    assert_allclose(low, [0.6, 0])
    assert_allclose(high, [1.4, 0.5])
    assert_allclose(outside_probability(4, 3), 3 * 6.334e-5, rtol=1e-3)


# ---------------------------------------------------------------- certificates


def chance_of_a_wrong_one(bias, alpha, steps):
    """Probability that the interval ever excludes the bias; Y is 0 or 2, truth 1."""
    chance = (1 + bias) / 2
    open_paths = [(open_certificate(1.0, 2.5, bias_grid(4)), 1.0)]
    wrong = 0.0
    for _ in range(steps):
        reached = [
            (extend(path, y), p * q)
            for path, p in open_paths
            for y, q in ((0.0, 1 - chance), (2.0, chance))
        ]
        open_paths = []
        for path, p in reached:
            low, high = certified_interval(path, alpha)
            if low < bias < high:
                open_paths.append((path, p))
            else:
                wrong += p
    return wrong


@pytest.mark.parametrize("bias", [-0.61, -0.07, 0.0003, 0.25, 0.83])
@pytest.mark.parametrize("alpha", [0.05, 0.3, 0.8])
def test_certificates_are_wrong_no_more_often_than_stated(bias, alpha):
    """Every path of 10 steps, for biases between the candidates too."""
    assert chance_of_a_wrong_one(bias, alpha, 10) <= alpha


def test_ends_are_the_last_of_an_unbroken_row_of_rejections():
    start = open_certificate(1.0, 4.0, [-0.4, -0.2, -0.1, 0.0, 0.1, 0.2, 0.4])
    limit = np.log(2 / 0.05)
    brighter = np.array([2, 1, 0.99, 0, 1, 0, 0]) * limit
    darker = np.array([0, 0, 1, 0, 0.99, 1, 2]) * limit
    certificate = replace(start, peak_brighter=brighter, peak_darker=darker)
    assert certified_interval(certificate, 0.05) == (-0.2, 0.2)
    assert certified_interval(certificate, 0.04) == (-0.4, 0.4)
    assert certified_bias(certificate, 1e-9) == 3


def certificate_after(steps, bias, seed):
    rng, certificate = np.random.default_rng(seed), open_certificate(1.0, BOUND)
    for y in draws(rng, bias, steps):
        certificate = extend(certificate, y)
    return certificate


def test_certificates_get_small_for_correct_backends_alone():
    correct, dark = (certificate_after(4000, bias, 13) for bias in (0, -0.2))
    print(certified_interval(correct, 1e-6), certified_interval(dark, 1e-6))
    assert certified_bias(correct, 1e-6) < 0.12
    assert certified_interval(dark, 1e-6)[1] < 0
    assert 0.2 < certified_bias(dark, 1e-6) < 0.32


def test_nothing_is_certified_without_data_or_after_a_refutation():
    certificate = open_certificate(1.0, 4.0)
    assert certified_interval(certificate, 0.1) == (-1, 3)
    for bad in (np.nan, 4.1, -1.0):
        assert certified_bias(extend(certificate, bad), 0.1) == np.inf
    with pytest.raises(ValueError, match="truth"):
        open_certificate(0.0, 1.0)
