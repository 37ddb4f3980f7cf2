"""ReSTIR GI against the path tracer, on every built-in scene.

Evidence: statistics.  The image mean must be within 0.5 % of the truth and no 8 x 8
tile outside of its band.  A correct estimator fails the tiles of one scene with
probability 1e-4 (Bonferroni over tiles and channels, t-quantiles after Hall's
transformation), and the image mean with probability 2 Φ(-0.5 % / error): 2e-2 for an
error of 0.22 %, which no plan exceeds; the test prints it.  The control is the same
test with a planted mistake, which the tiles must reject.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats

import restir_gi.reference.passes.pixels
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import BIASED, UNBIASED, Settings
from tests.statistics.replicates import (
    BATCHES,
    GAP,
    Means,
    apart,
    g_buffer,
    initially_sampled,
    largest_t,
    means,
    path_traced,
    run,
    runs_at_once,
    small_world,
    tall,
    threshold,
)

FAMILY = 1e-4
SIZE = 64
LIMIT = 0.005
AT_ONCE = 8


@dataclass(frozen=True)
class StillPlan:
    """How much a scene needs until the standard error of its mean is near 0.2 %."""

    scene: str
    runs: int
    frames: int
    initial: int  # samples a pixel of the initial pass alone
    truth: int  # samples a pixel of the path tracer
    control: str  # what is planted: no Jacobian, one that is too large, or 1/M


PLANS = [
    StillPlan("cornell-box", 310, 6, 2500, 2500, "1/M"),
    StillPlan("door-ajar", 740, 6, 13500, 8000, "1/M"),
    StillPlan("sunlit-wall", 310, 6, 5000, 5000, "jacobian"),
    # Between points of one plate the Jacobian is 1 on average: it is planted too large.
    StillPlan("parallel-plates", 310, 6, 7500, 5000, "jacobian x 1.1"),
    StillPlan("glossy-floor", 620, 6, 5000, 2500, "1/M"),
    StillPlan("grazing-light", 440, 6, 12500, 6200, "jacobian"),
    StillPlan("checker", 500, 6, 2500, 3100, "jacobian"),
    StillPlan("many-lights", 150, 6, 5000, 2500, "1/M"),
]


def what_reuse_changes(plan: StillPlan, settings: Settings, runs: int) -> Means:
    """Differences of runs and their companions without reuse."""
    world = small_world(find_scene(plan.scene), SIZE, SIZE)
    visible = g_buffer(world)
    pairs = []
    for first in range(0, runs, AT_ONCE):
        many = [visible] * min(AT_ONCE, runs - first)
        pairs += runs_at_once(world, settings, plan.frames, first, many)
    return means([a - b for a, b in pairs], SIZE)


def beside_each_other(gap):
    """Three runs in one tall frame, twice: only what the last one sees differs."""
    world = small_world(find_scene("cornell-box"), 24, 20)
    rng = np.random.default_rng(1)
    one, two, *lasts = (g_buffer(world, rng) for _ in range(4))
    for last in lasts:
        whole, seen = tall(world, [one, two, last], gap)
        color, initial = run(whole, UNBIASED, 3, 5, seen)
        yield apart(color, world, 3), apart(initial, world, 3)


def test_runs_in_one_frame_do_not_know_each_other():
    """What another run sees, and does, changes no bit of this one."""
    (color, initial), (other_color, other_initial) = beside_each_other(GAP)
    assert np.array_equal(color[:2], other_color[:2])
    assert np.array_equal(initial[:2], other_initial[:2])
    assert not np.array_equal(color[2], other_color[2])
    assert not np.array_equal(color[0], color[1])


def test_control_without_rows_between_them_they_do():
    (color, initial), (other_color, other_initial) = beside_each_other(0)
    assert np.array_equal(initial[:2], other_initial[:2])
    assert not np.array_equal(color[1], other_color[1])


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.scene)
def test_reuse_and_initial_samples_agree_with_the_path_tracer(plan):
    world = small_world(find_scene(plan.scene), SIZE, SIZE)
    expected = path_traced(world, plan.truth)
    initial = initially_sampled(world, UNBIASED, plan.initial)
    reuse = what_reuse_changes(plan, UNBIASED, plan.runs)
    scale = expected.mean[0]
    parts = [reuse, initial, expected]
    error = np.sqrt(sum(part.error**2 for part in parts)).clip(1e-300)
    difference = reuse.mean + initial.mean - expected.mean
    bias, error_of_bias = difference[0] / scale, error[0] / scale
    false_alarm = 2 * stats.norm.sf(LIMIT / error_of_bias)
    print(
        f"{plan.scene}: bias {bias:+.3%} +- {error_of_bias:.3%};"
        f" of reuse alone {reuse.mean[0] / scale:+.3%} +- {reuse.error[0] / scale:.3%}"
        f" (largest |t| {largest_t(reuse):.2f}); a correct estimator's mean would"
        f" fail with probability {false_alarm:.0e}"
    )
    assert abs(bias) <= LIMIT
    tiles = len(reuse.mean) - 1
    assert largest_t(reuse) <= threshold(tiles, FAMILY / 2, plan.runs)
    # Initial samples against the truth, in 64 batches each.
    t = (initial.mean - expected.mean) / np.hypot(initial.error, expected.error).clip(
        1e-300
    )
    assert np.abs(t[1:]).max() <= threshold(tiles, FAMILY / 2, BATCHES)


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.scene)
def test_the_same_test_rejects_a_planted_bias(plan, monkeypatch):
    runs = min(plan.runs, 200)
    settings = BIASED
    planted = {
        "jacobian": lambda *views: np.ones(len(views[0])),
        "jacobian x 1.1": lambda *views: 1.1 * reconnection_jacobian(*views),
    }
    if plan.control in planted:
        wrong = planted[plan.control]
        monkeypatch.setattr(
            restir_gi.reference.passes.pixels, "reconnection_jacobian", wrong
        )
        settings = UNBIASED
    reuse = what_reuse_changes(plan, settings, runs)
    bound = threshold(len(reuse.mean) - 1, FAMILY, runs)
    assert largest_t(reuse) > bound
