"""ReSTIR PT: reuse brings no bias, and what is reused is what the path tracer finds.

The candidates are held against the path tracer apart.  Controls: weights 1/M, and a
shift without its Jacobian.
"""

from dataclasses import dataclass

import numpy as np
import pytest

import restir_gi.extensions.frame_loop
from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.pt_settings import CRITERIA, PathSettings
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from tests.properties.path_scenes import world
from tests.statistics.path_runs import (
    COLUMNS,
    FAMILY,
    SIZE,
    Flat,
    brightness,
    judged,
    of_a_camera_that_moves,
    of_reuse,
)
from tests.statistics.replicates import (
    BATCHES,
    SEED_OF_INITIAL,
    in_batches,
    path_traced,
    threshold,
)

BOUND = threshold(COLUMNS + 1, FAMILY, BATCHES)
"""On |t| of candidates: image, tiles and channels."""


@dataclass(frozen=True)
class PathPlan:
    """What is rendered, and how often."""

    scene: str
    bounces: int = 3
    runs: int = 100
    shift: str = "hybrid"
    mis: str = "1/Z"


PLANS = [
    PathPlan("paint", 1),
    PathPlan("paint", 5, mis="balance"),
    PathPlan("paint", 2, shift="replay"),
    PathPlan("paint", 2, shift="reconnection"),
    PathPlan("rough metal"),
    PathPlan("glossy metal", mis="balance"),
    PathPlan("mirror", 4),
    PathPlan("rough coat", 2),
    PathPlan("smooth coat", 2),
    PathPlan("glass", 4),
    PathPlan("glass", 5, mis="balance"),
    PathPlan("rough glass", 3, 40, mis="balance"),
    PathPlan("door-ajar", 2),
    PathPlan("glossy-floor", 2),
    PathPlan("many-lights", 1),
    PathPlan("mirror-floor", 4),
    PathPlan("glass-floor", 5, mis="balance"),
    PathPlan("specular-floor", 2),
    PathPlan("paint", 2, mis="pairwise"),
    PathPlan("glass", 3, mis="defensive"),
]


def judged_plan(plan):
    """Whether its reuse shows no bias."""
    settings = PathSettings(shift=plan.shift, mis=plan.mis)
    found = of_reuse(plan.scene, settings, plan.bounces, plan.runs)
    return judged(found, brightness(plan.scene, plan.bounces))


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS, ids=str)
def test_reuse_brings_no_bias(plan):
    assert judged_plan(plan)


PAST_ALONE = PathSettings(spatial=False), 250
"""Without neighbours, whose own shifts would hide what becomes of the past."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "plan",
    [
        PAST_ALONE,
        (PathSettings(mis="1/Z"), 150),
        (PathSettings(mis="balance"), 150),
        (PathSettings(mis="defensive"), 150),
    ],
    ids=["past alone", "1/Z", "balance", "defensive"],
)
def test_a_camera_that_moves_brings_no_bias(plan):
    """What the last frame left is shifted from where its eye stood."""
    assert judged(*of_a_camera_that_moves(*plan))


@pytest.mark.slow
def test_control_the_past_without_jacobian_is_refuted(monkeypatch):
    monkeypatch.setattr(restir_gi.extensions.frame_loop, "Shift", Flat)
    assert not judged(*of_a_camera_that_moves(*PAST_ALONE))


@pytest.mark.parametrize(
    "plan", [PathPlan("paint", 2, 40), PathPlan("mirror", 2, 40)], ids=str
)
@pytest.mark.few(1)
def test_a_few_runs_show_no_bias(plan):
    assert judged_plan(plan)


@pytest.mark.slow
def test_control_one_over_m_is_refuted():
    plan = PathPlan("glass", 2, mis="1/M")
    assert not judged_plan(plan)


@pytest.mark.slow
def test_control_a_shift_without_jacobian_is_refuted(monkeypatch):
    monkeypatch.setattr(restir_gi.extensions.frame_loop, "Shift", Flat)
    plan = PathPlan("paint", 1)
    assert not judged_plan(plan)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "paint",
        "glossy metal",
        "mirror",
        "smooth coat",
        "glass",
        "mirror-floor",
        "glass-floor",
    ],
)
@pytest.mark.parametrize("bounces", [1, 4])
def test_candidates_are_what_the_path_tracer_finds(name, bounces):
    """Trees of paths and the path tracer: the same mean in every tile."""
    assert largest_difference(name, bounces, bounces) < BOUND


@pytest.mark.slow
def test_control_a_bounce_too_few_is_refuted():
    assert largest_difference("paint", 1, 2) > BOUND


def largest_difference(name, bounces, of_truth):
    """Of trees of paths and the path tracer, in standard errors."""
    w = world(name, SIZE)

    def color(points, pixel, number):
        u = KeyedUniforms(pixel, number, SEED_OF_INITIAL, Stream.PATH)
        keys = np.arange(len(points))
        tree = draw_paths(w, points, bounces, CRITERIA["hybrid"], keys, u)
        weight = np.divide(tree.w, tree.p_hat, out=0 * tree.w, where=tree.p_hat > 0)
        return tree.y.value * weight[:, None]

    mine, truth = in_batches(w, 1024, color, None), path_traced(w, 1024, of_truth)
    difference = mine.mean - truth.mean
    error = np.hypot(mine.error, truth.error)
    t = np.abs(difference / np.maximum(error, 1e-300))
    print(f"{100 * difference[0] / truth.mean[0]:+.2f} %, largest |t| {t.max():.1f}")
    return t[error > 0].max()
