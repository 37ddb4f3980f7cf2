"""ReSTIR GI against the path tracer, frame by frame, while something moves.

Evidence: statistics.  A camera, an occluder and the light move; in every frame the
image mean must be within 0.5 % of the path-traced truth of *that* frame, and no 8 x 8
tile outside of its band.  Motions are three times as fast as in the catalogue.

The companion of a run, as in ``replicates.py``, is the mean of its own initial samples
over all frames so far, whose expectation is the mean of what initial samples find in
each of these frames: measured apart, with many more.  A correct estimator fails the
tiles of one scene with probability 1e-4 (Bonferroni over frames, tiles and channels,
t-quantiles after Hall's transformation), and an image mean with probability
2 Φ(-0.5 % / error) a frame, which is printed.  The control is the paper's reuse, which
takes what the last frame left as it stands: its tiles must be rejected in the last
frame.  Its bias is printed beside.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import stats

from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED, Settings
from restir_gi.reference.transport.world import World, build_world
from tests.statistics.replicates import (
    ONE_BAND,
    Means,
    hall_t,
    initially_sampled,
    means,
    path_traced,
    threshold,
)

FAMILY = 1e-4
LIMIT = 0.005
SIZE, FRAMES, STRIDE = 48, 5, 3

ALONE = replace(UNBIASED, temporal=False, spatial=False)
AS_STORED = replace(UNBIASED, motion="as-stored")


@dataclass(frozen=True)
class MotionPlan:
    """How much a scene needs until the standard error of its means is near 0.2 %."""

    scene: str
    runs: int
    initial: int
    truth: int


PLANS = [
    MotionPlan("moving-camera", 620, 1900, 2500),
    MotionPlan("moving-block", 440, 1900, 2500),
    MotionPlan("moving-light", 600, 2300, 3000),
]


def small(name: str) -> Animation:
    """Every third frame of a built-in animation, small."""
    animation = find_animation(name)

    def at(frame: int):
        scene = animation(STRIDE * frame)
        camera = replace(scene.camera, width=SIZE, height=SIZE)
        return validate(replace(scene, camera=camera))

    return Animation(at, animation.changes)


def colors(world: World, animation: Animation, settings: Settings, seed: int):
    """Indirect light of each frame of one run, (frames, N, 3)."""
    frames = render_frames(world, settings, 1, seed, ONE_BAND, animation)
    return np.array([next(frames).color for _ in range(FRAMES)])


def what_reuse_changes(
    world: World, animation: Animation, settings: Settings, runs: int
) -> list[Means]:
    """Differences of runs and their companions, a group a frame."""
    differences = []
    for seed in range(runs):
        initial = colors(world, animation, ALONE, seed)
        so_far = np.cumsum(initial, axis=0) / np.arange(1, FRAMES + 1)[:, None, None]
        differences.append(colors(world, animation, settings, seed) - so_far)
    return [means([d[t] for d in differences], SIZE) for t in range(FRAMES)]


def averaged(groups: list[Means]) -> list[Means]:
    """Means of the first frame, of the first two, of the first three, and so on."""
    values = np.cumsum([group.values for group in groups], axis=0)
    return [Means(total / (t + 1)) for t, total in enumerate(values)]


def judge(reuse: Means, initial: Means, expected: Means) -> tuple[float, float, float]:
    """Relative bias of the image mean, its error, and the largest |t| of the tiles."""
    difference = reuse.mean + initial.mean - expected.mean
    parts = (reuse, initial, expected)
    error = np.sqrt(sum(part.error**2 for part in parts)).clip(1e-300)
    # The skewness is that of the runs, which have the largest share of the error.
    t = hall_t(difference, error, reuse.skewness, len(reuse.values))
    scale = expected.mean[0]
    return float(difference[0] / scale), float(error[0] / scale), np.abs(t[1:]).max()


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.scene)
def test_every_frame_agrees_with_its_own_truth(plan):
    animation = small(plan.scene)
    worlds = [build_world(animation(t)) for t in range(FRAMES)]
    expected = [path_traced(world, plan.truth) for world in worlds]
    alone = [initially_sampled(world, UNBIASED, plan.initial) for world in worlds]
    initial = averaged(alone)
    reuse = what_reuse_changes(worlds[0], animation, UNBIASED, plan.runs)
    stored = what_reuse_changes(worlds[0], animation, AS_STORED, plan.runs // 3)
    bound = threshold(FRAMES * (len(reuse[0].mean) - 1), FAMILY, len(alone[0].values))
    biases = []
    for t in range(FRAMES):
        bias, error, tile = judge(reuse[t], initial[t], expected[t])
        paper, paper_error, paper_tile = judge(stored[t], initial[t], expected[t])
        print(
            f"{plan.scene} frame {t}: bias {bias:+.3%} +- {error:.3%}, largest |t|"
            f" {tile:.2f} of {bound:.2f}; a correct mean fails with probability"
            f" {2 * stats.norm.sf(LIMIT / error):.0e}; as stored {paper:+.2%} +-"
            f" {paper_error:.2%}, |t| {paper_tile:.1f}"
        )
        biases.append(abs(bias))
        assert tile <= bound
    assert max(biases) <= LIMIT
    assert paper_tile > bound
