"""Path tracer and ReSTIR GI against form factors: sunlit wall and parallel plates.

A replicate is one whole run under its own seed, with empty reservoirs.  Of each run we
keep the ratio to the truth of the picture and of its 16 tiles, and judge their means by
Student's t at a family-wise rate of 1e-6 (Bonferroni over ratios).  A tile of a run
averages some hundred samples of skewness below 4, so that the skewness of the mean of
64 runs is below 0.05 and the tails at t = 6 are off by a factor of a few at most.

Controls: an answer off by 2 % is rejected on the same data, and so is ReSTIR GI with a
Jacobian dropped, inverted or without its squares.  So a bias of 2 % of the picture
would not have gone unnoticed.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from restir_gi.reference.numerics.arrays import divide_or_zero
from restir_gi.reference.passes import pixels
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.answers import (
    parallel_plates_indirect,
    sunlit_wall_indirect,
)
from restir_gi.reference.scene.catalogue.registry import find_scene
from tests.analytic.rendering import (
    frames_of,
    moved,
    path_traced,
    what_is_seen,
    world_of,
)

ALARM = 1e-6
SIZE = 32
RUNS = 64

# The floor before the wall, and the lower plate past the upper one: every pixel counts.
CLOSE = {
    "sunlit-wall": Camera(position=(0.3, 1.5, 1.2), target=(0.1, 0, 0.9), fov=42.0),
    "parallel-plates": Camera(position=(0.1, 0.9, 0.5), target=(0, 0, 0.05), fov=34.0),
}
IDENTITY = np.eye(4)
SMALL_FAR_TURNED = np.eye(4)
"""A thousandth of the size, a kilometre from the origin, every axis askew."""
SMALL_FAR_TURNED[:3, :3] = 1e-3 * Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
SMALL_FAR_TURNED[:3, 3] = 1000.0, -700.0, 400.0

ANSWERS = {
    "sunlit-wall": sunlit_wall_indirect,
    "parallel-plates": parallel_plates_indirect,
}


def close_up(name, move=IDENTITY):
    """World of a scene seen from close by, its points and their true radiance."""
    scene = replace(find_scene(name), camera=CLOSE[name])
    world = world_of(moved(scene, move), SIZE)
    seen = what_is_seen(world)
    # Back to where the answer is at home.
    scaled_turn = move[:3, :3]
    home = (seen.position - move[:3, 3]) @ np.linalg.inv(scaled_turn).T
    normal = seen.normal @ scaled_turn / np.cbrt(np.linalg.det(scaled_turn))
    truth = ANSWERS[name](home, normal)
    assert (truth > 0).all()
    return world, seen, truth


def ratios(color, truth):
    """Ratio of picture and truth: the whole, then 16 tiles; one channel is enough.

    The scenes have one colour of light and diffuse surfaces: channels are in a fixed
    ratio, which is tested first.
    """
    scaled = color / truth
    assert np.abs(scaled - scaled[:, :1]).max() <= 16 * 2.0**-52 * scaled.max()
    side = SIZE // 4
    tiles = color[:, 1].reshape(4, side, 4, side).sum(axis=(1, 3)).ravel()
    true = truth[:, 1].reshape(4, side, 4, side).sum(axis=(1, 3)).ravel()
    return np.concatenate([[tiles.sum() / true.sum()], tiles / true])


def largest_t(runs, expected):
    """Largest |t| of the means of (R, 17) ratios."""
    error = np.std(runs, axis=0, ddof=1) / np.sqrt(len(runs))
    return (np.abs(np.mean(runs, axis=0) - expected) / error).max()


def bound(runs):
    """What right ratios exceed with probability ``ALARM`` in all."""
    count, tests = np.shape(runs)
    return stats.t.isf(ALARM / (2 * tests), count - 1)


def assert_right(runs, expected):
    """The ratios are as expected, and the same runs tell 2 % more and less from it."""
    assert largest_t(runs, expected) <= bound(runs)
    assert largest_t(runs, expected + 0.02) > bound(runs)
    assert largest_t(runs, expected - 0.02) > bound(runs)


@pytest.mark.parametrize(
    ("name", "bounces", "move"),
    [
        ("sunlit-wall", 2, IDENTITY),
        ("sunlit-wall", 1, SMALL_FAR_TURNED),
        ("parallel-plates", 1, IDENTITY),
    ],
)
def test_path_tracer_shows_the_closed_form(name, bounces, move):
    """Nor does a second bounce change it: the side that is seen receives no sun."""
    world, seen, truth = close_up(name, move)
    runs = [
        ratios(path_traced(world, "indirect", bounces, 12, seed, seen), truth)
        for seed in range(RUNS)
    ]
    assert_right(runs, 1.0)


REUSE = {
    "paper": {},
    "wide": {"radius": 0.5, "max_depth": 1.0},
    "balance": {"mis": "balance", "target": "outgoing", "source": "cosine"},
    "chosen": {"visibility": "chosen", "source": "bsdf"},
    "capped": {"temporal_cap": 2.0, "spatial_cap": 4.0, "source": "cosine"},
}


def initial_runs(world, truth, choice, frames, runs=RUNS):
    """Ratios of the mean over frames of ReSTIR GI without any reuse."""
    alone = choice | {"temporal": False, "spatial": False}
    return [
        ratios(
            np.mean(
                [f.color for f in frames_of(world, frames, seed=s, **alone)], axis=0
            ),
            truth,
        )
        for s in range(runs)
    ]


def reuse_runs(world, truth, choice, runs=48):
    """Ratios of the last of 6 frames, less those of the same samples without reuse.

    Reuse only weights them anew: what it changes has expectation 0, and a third of the
    noise of either.
    """
    without = initial_runs(world, truth, choice, 6, runs)
    last = [
        ratios(frames_of(world, 6, seed=seed, **choice)[-1].color, truth)
        for seed in range(runs)
    ]
    return np.subtract(last, without)


@pytest.mark.parametrize(
    ("name", "source", "frames"),
    [("sunlit-wall", "uniform", 40), ("parallel-plates", "cosine", 16)],
)
@pytest.mark.few(1)
def test_initial_samples_show_the_closed_form(name, source, frames):
    world, _, truth = close_up(name)
    assert_right(initial_runs(world, truth, {"source": source}, frames), 1.0)


@pytest.mark.parametrize(
    ("name", "choice"),
    [
        ("sunlit-wall", "wide"),
        ("sunlit-wall", "capped"),
        ("parallel-plates", "balance"),
        ("parallel-plates", "chosen"),
    ],
)
@pytest.mark.few(2)
def test_reuse_leaves_the_closed_form_as_it_is(name, choice):
    world, _, truth = close_up(name)
    assert_right(reuse_runs(world, truth, REUSE[choice]), 0.0)


MUTANTS = {
    "dropped": lambda *x: np.ones(len(x[0])),
    "inverted": lambda *x: divide_or_zero(np.ones(1), reconnection_jacobian(*x)),
    "unsquared": lambda *x: np.cbrt(reconnection_jacobian(*x)),
}


@pytest.mark.parametrize("mutant", MUTANTS)
@pytest.mark.few(1)
def test_control_a_wrong_jacobian_is_rejected(monkeypatch, mutant):
    monkeypatch.setattr(pixels, "reconnection_jacobian", MUTANTS[mutant])
    world, _, truth = close_up("sunlit-wall")
    runs = reuse_runs(world, truth, REUSE["wide"])
    assert largest_t(runs, 0.0) > bound(runs)
