"""Levels of whole runs: no false alarm, and planted biases found.

The false alarms of the bets and of the ranks have their own tests, on distributions
that are known.  Here the loop itself is under test: that its runs are independent, that
the truth is the truth and that the bound is one.
"""

import numpy as np
import pytest
from scipy.special import stdtr

from restir_gi.reference.oracle.builtin.backend import FLOAT32, FLOAT64
from restir_gi.reference.oracle.levels.distribution import SCENES, same_distribution
from restir_gi.reference.oracle.levels.means import mean_over_runs, replicates, truth
from restir_gi.reference.oracle.levels.spheres import room
from restir_gi.reference.oracle.statistics.variance import (
    extended,
    open_moments,
    p_values,
    standard_error,
)
from tests.contracts.resamplers import Resampler


def ask_right(case):
    return getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings)


def changed(pass_name, change):
    def ask(case):
        outputs = dict(ask_right(case))
        return change(case, outputs) if case.pass_name == pass_name else outputs

    return ask


def brighter(factor):
    return changed(
        "shade", lambda case, out: {"color": out["color"] * np.float32(factor)}
    )


def test_the_right_backend_is_certified():
    """To half a percent; fails with probability 5e-7 if the bets are right."""
    found = mean_over_runs(ask_right, "float32", lambda: 60.0)
    assert found.finding.passed
    assert found.certified <= 0.005


@pytest.mark.parametrize("factor", [1.03, 0.97])
def test_control_three_percent_are_found(factor):
    found = mean_over_runs(brighter(factor), "float32", lambda: 60.0)
    assert not found.finding.passed
    assert found.runs < 20000


# ---------------------------------------------------------------- by the variance


def with_other(**choices):
    """The loop with passes that are as right, and in which pixels exceed the bound."""
    resampler = Resampler(**choices)

    def ask(case):
        own = hasattr(resampler, case.pass_name)
        backend = resampler if own else FLOAT32
        return getattr(backend, case.pass_name)(**case.inputs, **case.settings)

    return ask


def test_where_no_bound_holds_the_variance_does_not_accuse():
    """With probability 5e-7 at most; the bets do, which is why they are void there."""
    found = mean_over_runs(with_other(target="outgoing"), "float32", lambda: 0.0)
    assert found.by_variance.passed
    assert "proved" in found.finding.text


def test_control_two_percent_are_found_by_the_variance():
    ask = with_other(weights="balance")

    def darker(case):
        out = dict(ask(case))
        if case.pass_name == "shade":
            out["color"] = out["color"] * np.float32(0.98)
        return out

    found = mean_over_runs(darker, "float32", lambda: 60.0)
    assert "-0.02" in found.by_variance.text
    assert "finite variance" in found.by_variance.text


def test_p_values_of_skewed_means_are_not_too_small():
    """Of 20,000 means of 512 exponential variables some 20 are below 1e-3.

    At most 33: 34 or more have probability 3e-3 if p is right.  The control is
    Student's p-value alone, which is too small too often, of 80,000 means.
    """
    y = np.random.default_rng(5).exponential(size=(4, 512, 20_000))
    moments = [extended(open_moments(np.ones(20_000)), part) for part in y]
    assert (p_values(moments[0], 0.0) < 1e-3).sum() <= 33
    ratios = [np.divide(*standard_error(m)) for m in moments]
    student = 2 * stdtr(511, -np.abs(np.concatenate(ratios)))
    assert (student < 1e-3).sum() > 106  # 107 of 80,000 have probability 2e-3


def test_without_time_a_bound_is_told_with_what_more_would_buy():
    found = mean_over_runs(ask_right, "float32", lambda: 0.0)
    assert found.finding.passed
    assert 0.005 < found.certified < 0.5
    assert "would certify 0.005" in found.more


def test_no_run_is_above_the_bound_and_their_mean_is_the_truth():
    """Mean of 2048 runs within 6 standard errors: fails with probability 1e-8."""

    def ask(case):
        return getattr(FLOAT64, case.pass_name)(**case.inputs, **case.settings)

    y = np.concatenate([replicates(ask, "float64", seed) for seed in range(4)])
    assert y.max() <= 1 + room("float64")
    error = y[:, 0].std(ddof=1) / len(y) ** 0.5
    assert abs(y[:, 0].mean() - truth()) < 6 * error


def test_the_same_law_is_not_accused():
    """Each with probability 5e-7 / 4 at most."""
    found = same_distribution(ask_right, "float32", "sunlit-wall")
    assert found.finding.passed


@pytest.mark.parametrize(
    ("pass_name", "change"),
    [
        ("shade", lambda case, out: {"color": out["color"] * np.float32(1.4)}),
        ("spatial", lambda case, out: out | {"W": out["W"] * np.float32(0.5)}),
        (
            "temporal",
            lambda case, out: out | {"M": np.minimum(out["M"], np.float32(1))},
        ),
    ],
    ids=["brighter", "darker", "no memory"],
)
def test_control_another_law_is_found(pass_name, change):
    found = same_distribution(changed(pass_name, change), "float32", "sunlit-wall")
    assert not found.finding.passed


@pytest.mark.slow
def test_p_values_of_the_right_backend_are_not_too_small():
    """Of 160 runs at most 8 below 1e-2: 9 or more have probability 5e-5."""
    small = [
        same_distribution(ask_right, "float32", scene, seed=100 + seed).p < 1e-2
        for scene in SCENES
        for seed in range(40)
    ]
    assert sum(small) <= 8


@pytest.mark.slow
def test_bets_at_a_raised_level_keep_it():
    """Of 100 runs at 1e-2 at most 6 alarms: 7 or more have probability 1e-4."""
    alarms = 0
    for run in range(100):
        found = mean_over_runs(
            ask_right, "float32", lambda: 0.0, alpha=1e-2, first_seed=5000 + run
        )
        alarms += not found.finding.passed
    assert alarms <= 6


@pytest.mark.slow
def test_the_variance_at_a_raised_level_keeps_it():
    """Of 100 runs at 1e-2 at most 6 alarms: 7 or more have probability 1e-4."""
    alarms = 0
    for run in range(100):
        found = mean_over_runs(
            with_other(weights="balance"),
            "float32",
            lambda: 0.0,
            alpha=2e-2,
            first_seed=7000 + run,
        )
        alarms += not found.by_variance.passed  # of the first batch: half of alpha
    assert alarms <= 6
