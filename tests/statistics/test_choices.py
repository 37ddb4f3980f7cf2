"""Evidence against chances: how often it accuses the right, and finds the wrong."""

import numpy as np
import pytest

from restir_gi.reference.oracle.capture.shares import StreamChances
from restir_gi.reference.oracle.statistics.choices import Chances, wins

ROWS, FRAMES = 500, 3


def captured(rng, bias=1.0, rows=ROWS):
    """Choices of some frames, whose chances hang on what was kept in the last one."""
    found, kept = [], np.zeros(rows, bool)
    for _ in range(FRAMES):
        p = np.where(kept, 0.7, 0.05) * rng.uniform(0.1, 1.0, rows)
        kept = rng.random(rows) < np.minimum(bias * p, 1.0)
        found.append(Chances(kept, p, p))
    return found


def rate(threshold, runs, bias=1.0, rows=ROWS):
    """Share of captures whose evidence is beyond a threshold."""
    rng = np.random.default_rng(11)
    logs = [wins(captured(rng, bias, rows), FRAMES).log_e for _ in range(runs)]
    return float((np.array(logs) >= np.log(threshold)).mean())


@pytest.mark.parametrize("level", [0.1, 0.01])
def test_what_is_right_is_accused_no_more_often_than_allowed(level):
    # Ville's inequality: at most `level`; of 4,000 captures a binomial number, which is
    # beyond 4.5 standard deviations in 3.4 of a million runs.
    runs = 4000
    allowed = level + 4.5 * np.sqrt(level * (1 - level) / runs)
    assert rate(1 / level, runs) <= allowed


@pytest.mark.parametrize("bias", [1.3, 0.7])
def test_control_what_is_wrong_is_accused(bias):
    assert rate(1e6, 20, bias, rows=20 * ROWS) == 1.0


def test_bounds_of_rounding_are_no_evidence():
    # All that a chance between 0.1 and 0.3 allows is no evidence of anything.
    rng = np.random.default_rng(3)
    rows = 20_000
    low, high = np.full(rows, 0.1), np.full(rows, 0.3)
    for p in (0.1, 0.2, 0.3):
        won = rng.random(rows) < p
        assert wins([Chances(won, low, high)], 1).log_e < np.log(1e4)
    won = rng.random(rows) < 0.35
    assert wins([Chances(won, low, high)], 1).log_e > np.log(1e6)


def test_a_candidate_without_a_chance_is_never_kept():
    none, one = np.zeros(3), np.ones(3)
    assert wins([Chances(np.array([0, 0, 1], bool), none, none)], 1).log_e > np.log(1e6)
    assert wins([Chances(np.array([1, 1, 0], bool), one, one)], 1).log_e > np.log(1e6)
    assert wins([Chances(none.astype(bool), none, none)], 1).log_e < np.log(2)


def test_the_number_of_wins_is_told():
    won = np.array([1, 0, 0, 1], bool)
    p = np.array([0.5, 0.25, 0.25, 0.5])
    found = wins([Chances(won, p, p)], 1)
    assert (found.rows, found.kept, found.expected) == (4, 2, 1.5)
    assert found.deviation == pytest.approx(np.sqrt(0.5 + 0.375))
    assert found.excess == pytest.approx(1 / 3)


def test_ten_thousand_right_captures_are_not_accused():
    # At 1e-6 one of them would be accused with probability 0.01 at most.
    assert rate(1e6, 10_000) == 0.0


def test_a_weight_of_which_nothing_is_known_leaves_all_chances_open():
    w = np.array([[1.0, 1.0, 0.0], [3.0, 3.0, 3.0], [0.0, 4.0, 1.0]])
    error = np.array([[0.0, np.inf, 0.0], [0.5, 0.5, 0.5], [0.0, 0.0, 0.0]])
    one = StreamChances(
        names=("a", "b", "c"),
        order=(0, 1, 2),
        w=w,
        error=error,
        same=np.eye(3, dtype=bool)[..., None].repeat(3, axis=2),
        held=np.zeros((3, 3), bool),
        shown=np.ones(3, bool),
    )
    low, high = one.shares()
    np.testing.assert_allclose(low[:, 0], [1 / 4.5, 2.5 / 3.5, 0])
    np.testing.assert_allclose(high[:, 0], [1 / 3.5, 3.5 / 4.5, 0])
    np.testing.assert_allclose(low[:, 1], [0, 0, 0])
    np.testing.assert_allclose(high[:, 1], [1, 3.5 / 7.5, 4 / 6.5])
    np.testing.assert_allclose(low[:, 2], [0, 2.5 / 3.5, 1 / 4.5])
