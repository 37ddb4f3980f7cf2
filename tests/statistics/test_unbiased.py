"""ReSTIR GI against the path tracer, on every built-in scene.

Evidence: statistics.  The image mean must be within 0.5 % of the truth and no 8 x 8
tile outside of its band; a correct estimator fails the tiles of one scene with
probability 1e-4 (Bonferroni over tiles and channels, t-quantiles after Hall's
transformation).  The control is the same test with the Jacobian left out or the
neighbours' visibility ignored, which must fail.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import reference.passes.spatial
from reference.resampling.shift import reconnection_jacobian
from reference.scene.catalogue.registry import find_scene
from reference.settings import BIASED, UNBIASED
from tests.statistics.replicates import (
    Means,
    g_buffer,
    largest_t,
    means,
    run,
    small_world,
    threshold,
    truth,
)

FAMILY = 1e-4
SIZE = 64
LIMIT = 0.005


@dataclass(frozen=True)
class Plan:
    """How much a scene needs until the standard error of its mean is near 0.15 %."""

    scene: str
    runs: int
    frames: int
    samples: int
    control: str  # what is planted: no Jacobian, one that is too large, or 1/M


PLANS = [
    Plan("cornell-box", 500, 6, 6000, "1/M"),
    Plan("door-ajar", 500, 6, 12000, "1/M"),
    Plan("sunlit-wall", 400, 6, 12000, "jacobian"),
    # Between points of one plate the Jacobian is 1 on average: it is planted too large.
    Plan("parallel-plates", 400, 6, 12000, "jacobian x 1.1"),
    Plan("glossy-floor", 900, 6, 2500, "1/M"),
    Plan("grazing-light", 400, 6, 12000, "jacobian"),
    Plan("checker", 700, 6, 4000, "jacobian"),
    Plan("many-lights", 160, 6, 5000, "1/M"),
]


def replicate(plan: Plan, settings: object, runs: int) -> tuple[Means, Means]:
    """Differences that reuse makes, and the companions without reuse."""
    world = small_world(find_scene(plan.scene), SIZE, SIZE)
    visible = g_buffer(world)
    pairs = [run(world, settings, plan.frames, seed, visible) for seed in range(runs)]
    reuse = means([a - b for a, b in pairs], SIZE)
    return reuse, means([b for _, b in pairs], SIZE)


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.scene)
def test_reuse_and_initial_samples_agree_with_the_path_tracer(plan):
    world = small_world(find_scene(plan.scene), SIZE, SIZE)
    expected = truth(world, plan.samples)
    reuse, initial = replicate(plan, UNBIASED, plan.runs)
    scale = expected.mean[0]
    # What reuse changes, and what the initial samples find: both against the truth.
    difference = reuse.mean[0] + initial.mean[0] - scale
    error = np.sqrt(
        (reuse.values[:, 0] + initial.values[:, 0]).var(ddof=1) / plan.runs
        + expected.error[0] ** 2
    )
    bias_of_reuse = reuse.mean[0] / scale
    bias_of_initial = initial.mean[0] / scale - 1
    print(
        f"{plan.scene}: relative bias {difference / scale:+.3%} +- {error / scale:.3%};"
        f" of reuse {bias_of_reuse:+.3%} +- {reuse.error[0] / scale:.3%}"
        f" (largest |t| {largest_t(reuse):.2f}), of initial samples"
        f" {bias_of_initial:+.3%} +- {initial.error[0] / scale:.3%}"
    )
    assert abs(bias_of_reuse) <= LIMIT
    bound = threshold(len(reuse.mean) - 1, FAMILY, plan.runs)
    assert largest_t(reuse) <= bound
    # Initial samples and truth are both noisy: their errors add.
    t = (initial.mean - expected.mean) / np.hypot(initial.error, expected.error).clip(
        1e-300
    )
    assert np.abs(t[1:]).max() <= threshold(len(t) - 1, FAMILY, 64)
    assert abs(t[0]) <= threshold(1, FAMILY, 64)


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
        monkeypatch.setattr(reference.passes.spatial, "reconnection_jacobian", wrong)
        settings = UNBIASED
    reuse, _ = replicate(replace(plan, runs=runs), settings, runs)
    bound = threshold(len(reuse.mean) - 1, FAMILY, runs)
    assert largest_t(reuse) > bound
