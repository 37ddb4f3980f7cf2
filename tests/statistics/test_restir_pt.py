"""ReSTIR PT: reuse brings no bias, and what is reused is what the path tracer finds.

A replicate is a run under its own seed, minus the mean of its own candidates without
reuse, whose expectation is 0; the candidates are held against the path tracer apart.
Correct reuse fails the tiles of a scene with probability 1e-4, and the image mean with
as much.  Controls: weights 1/M, and a shift without its Jacobian.
"""

from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import pytest
from scipy import stats

import extensions.restir_pt
from extensions.candidates import draw_paths
from extensions.connection import CRITERIA
from extensions.pt_settings import PathSettings
from extensions.restir_pt import render_path_frames
from extensions.shifting import Shift
from reference.rng import KeyedUniforms, Stream
from reference.scene.animation import Animation
from reference.scene.catalogue.registry import find_animation
from reference.scene.validation import validate
from reference.world import build_world
from tests.properties.path_scenes import world
from tests.statistics.replicates import (
    BATCHES,
    ONE_BAND,
    SEED_OF_INITIAL,
    in_batches,
    largest_t,
    means,
    path_traced,
    threshold,
)

FAMILY = 1e-4
SIZE, FRAMES = 24, 4
COLUMNS = 3 * (SIZE // 8) ** 2
BOUND = threshold(COLUMNS + 1, FAMILY, BATCHES)
"""On |t| of candidates: image, tiles and channels."""


@dataclass(frozen=True)
class Plan:
    """What is rendered, and how often."""

    scene: str
    bounces: int = 3
    runs: int = 150
    shift: str = "hybrid"
    mis: str = "1/Z"


PLANS = [
    Plan("paint", 1),
    Plan("paint", 5, mis="balance"),
    Plan("paint", 2, shift="replay"),
    Plan("paint", 2, shift="reconnection"),
    Plan("rough metal"),
    Plan("glossy metal", mis="balance"),
    Plan("mirror", 4),
    Plan("rough coat", 2),
    Plan("smooth coat", 2),
    Plan("glass", 4),
    Plan("glass", 5, mis="balance"),
    Plan("door-ajar", 2),
    Plan("glossy-floor", 2),
    Plan("many-lights", 1),
    Plan("paint", 2, mis="pairwise"),
    Plan("glass", 3, mis="defensive"),
]


class Flat(Shift):
    """Values are right, and all Jacobians 1."""

    def __call__(self, *whence):
        """Shift, and forget what it does to the measure."""
        value, jacobian = Shift.__call__(self, *whence)
        return value, (jacobian > 0).astype(float)


def of_reuse(plan, runs=None):
    """Means of the last frame over those of the same candidates without reuse."""
    w = world(plan.scene, SIZE)
    settings = PathSettings(shift=plan.shift, mis=plan.mis)
    alone = replace(settings, temporal=False, spatial=False)
    rows = []
    for seed in range(runs or plan.runs):

        def colors(s, seed=seed):
            frames = render_path_frames(w, s, plan.bounces, seed, ONE_BAND)
            return [frame.color for frame in islice(frames, FRAMES)]

        rows.append(colors(settings)[-1] - np.mean(colors(alone), axis=0))
    return means(rows, SIZE)


def judged(found, scale):
    """Largest |t| of the tiles; and of the image, with its relative bias."""
    n = len(found.values)
    image = float(np.abs(found.mean[0] / found.error[0]))
    print(
        f"bias of reuse {100 * found.mean[0] / scale:+.2f} % ±"
        f" {100 * found.error[0] / scale:.2f}, largest tile |t| {largest_t(found):.1f}"
        f" of {threshold(COLUMNS, FAMILY, n):.1f}"
    )
    tiles = largest_t(found) < threshold(COLUMNS, FAMILY, n)
    return tiles and image < stats.t.isf(FAMILY / 2, n - 1)


def brightness(plan):
    return float(path_traced(world(plan.scene, SIZE), 64, plan.bounces).mean[0])


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS, ids=str)
def test_reuse_brings_no_bias(plan):
    assert judged(of_reuse(plan), brightness(plan))


def of_a_camera_that_moves(settings, runs):
    """Last frame with reuse less that without, and the image's mean."""
    found = find_animation("moving-camera")

    def at(frame):
        scene = found(4 * frame)
        camera = replace(scene.camera, width=SIZE, height=SIZE)
        return validate(replace(scene, camera=camera))

    animation, w, rows = Animation(at, found.changes), build_world(at(0)), []
    for seed in range(runs):

        def last(s, seed=seed):
            frames = render_path_frames(w, s, 2, seed, ONE_BAND, animation)
            return [frame.color for frame in islice(frames, FRAMES)][-1]

        alone = replace(settings, temporal=False, spatial=False)
        rows.append(last(settings) - last(alone))
    scale = float(path_traced(build_world(at(FRAMES - 1)), 64, 2).mean[0])
    return means(rows, SIZE), scale


PAST_ALONE = PathSettings(spatial=False), 700
"""Without neighbours, whose own shifts would hide what becomes of the past."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "plan",
    [
        PAST_ALONE,
        (PathSettings(), 300),
        (PathSettings(mis="balance"), 300),
        (PathSettings(mis="defensive"), 300),
    ],
    ids=["past alone", "1/Z", "balance", "defensive"],
)
def test_a_camera_that_moves_brings_no_bias(plan):
    """What the last frame left is shifted from where its eye stood."""
    assert judged(*of_a_camera_that_moves(*plan))


@pytest.mark.slow
def test_control_the_past_without_jacobian_is_refuted(monkeypatch):
    monkeypatch.setattr(extensions.restir_pt, "Shift", Flat)
    assert not judged(*of_a_camera_that_moves(*PAST_ALONE))


@pytest.mark.parametrize("plan", [Plan("paint", 2, 40), Plan("glass", 3, 40)], ids=str)
def test_a_few_runs_show_no_bias(plan):
    assert judged(of_reuse(plan), brightness(plan))


@pytest.mark.slow
def test_control_one_over_m_is_refuted():
    plan = Plan("glass", 2, mis="1/M")
    assert not judged(of_reuse(plan), brightness(plan))


@pytest.mark.slow
def test_control_a_shift_without_jacobian_is_refuted(monkeypatch):
    monkeypatch.setattr(extensions.restir_pt, "Shift", Flat)
    plan = Plan("paint", 1)
    assert not judged(of_reuse(plan), brightness(plan))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["paint", "glossy metal", "mirror", "smooth coat", "glass"]
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

    mine, truth = in_batches(w, 2048, color, None), path_traced(w, 2048, of_truth)
    difference = mine.mean - truth.mean
    error = np.hypot(mine.error, truth.error)
    t = np.abs(difference / np.maximum(error, 1e-300))
    print(f"{100 * difference[0] / truth.mean[0]:+.2f} %, largest |t| {t.max():.1f}")
    return t[error > 0].max()
