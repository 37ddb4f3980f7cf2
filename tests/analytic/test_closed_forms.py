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

from reference.passes import spatial
from reference.resampling.shift import reconnection_jacobian
from reference.scene.camera import Camera
from reference.scene.catalogue.answers import (
    parallel_plates_indirect,
    sunlit_wall_indirect,
)
from reference.scene.catalogue.registry import find_scene
from tests.analytic.rendering import frames_of, path_traced, what_is_seen, world_of

ALARM = 1e-6
SIZE = 32
RUNS = 64

# The floor before the wall, and the lower plate past the upper one: every pixel counts.
CLOSE = {
    "sunlit-wall": Camera(position=(0.3, 1.5, 1.2), target=(0.1, 0, 0.9), fov_x=42.0),
    "parallel-plates": Camera(position=(0.1, 0.9, 0.5), target=(0, 0, 0.05), fov_x=34.0),
}
ANSWERS = {
    "sunlit-wall": sunlit_wall_indirect,
    "parallel-plates": parallel_plates_indirect,
}


def close_up(name):
    """World of a scene seen from close by, its points and their true radiance."""
    scene = replace(find_scene(name), camera=CLOSE[name])
    world = world_of(scene, SIZE)
    seen = what_is_seen(world)
    truth = ANSWERS[name](seen.position, seen.normal)
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


def largest_t(runs, expected=1.0):
    """Largest |t| of the means of (R, 17) ratios."""
    error = np.std(runs, axis=0, ddof=1) / np.sqrt(len(runs))
    return (np.abs(np.mean(runs, axis=0) - expected) / error).max()


def bound(runs):
    """What right ratios exceed with probability ``ALARM`` in all."""
    count, tests = np.shape(runs)
    return stats.t.isf(ALARM / (2 * tests), count - 1)


def assert_right(runs):
    """The ratios are 1, and the same runs tell 1.02 and 0.98 from 1."""
    print(
        largest_t(runs),
        bound(runs),
        np.mean(runs, axis=0)[0],
        np.std(runs, axis=0) / np.sqrt(len(runs)),
        stats.skew(runs, axis=0),
    )
    assert largest_t(runs) <= bound(runs)
    assert largest_t(runs, 1.02) > bound(runs)
    assert largest_t(runs, 0.98) > bound(runs)


@pytest.mark.parametrize("bounces", [1, 2])
@pytest.mark.parametrize("name", ANSWERS)
def test_path_tracer_shows_the_closed_form(name, bounces):
    """Two bounces change nothing: what is lit from the side that is seen is not lit."""
    world, seen, truth = close_up(name)
    runs = [
        ratios(path_traced(world, "indirect", bounces, 12, seed, seen), truth)
        for seed in range(RUNS)
    ]
    assert_right(runs)


REUSE = {
    "paper": {},
    "balance": {"mis": "balance", "target": "outgoing", "source": "cosine"},
    "chosen": {"visibility": "chosen", "source": "bsdf"},
    "capped": {"temporal_cap": 2.0, "spatial_cap": 4.0, "source": "cosine"},
}


def restir_runs(world, truth, choice, runs=RUNS, frames=6):
    """Ratios of the last frame of each run."""
    return [
        ratios(
            np.mean(
                [f.color for f in frames_of(world, frames, seed=seed, **choice)],
                axis=0,
            ),
            truth,
        )
        for seed in range(runs)
    ]


@pytest.mark.parametrize(
    ("name", "choice"),
    [
        ("sunlit-wall", "paper"),
        ("sunlit-wall", "balance"),
        ("parallel-plates", "chosen"),
        ("parallel-plates", "capped"),
    ],
)
def test_restir_shows_the_closed_form(name, choice):
    world, _, truth = close_up(name)
    assert_right(restir_runs(world, truth, REUSE[choice]))


MUTANTS = {
    "dropped": lambda *x: np.ones(len(x[0])),
    "inverted": lambda *x: 1.0 / reconnection_jacobian(*x),
    "unsquared": lambda *x: np.cbrt(reconnection_jacobian(*x)),
}


@pytest.mark.parametrize("mutant", MUTANTS)
def test_control_a_wrong_jacobian_is_rejected(monkeypatch, mutant):
    """With fewer runs than the right one passes."""
    monkeypatch.setattr(spatial, "reconnection_jacobian", MUTANTS[mutant])
    world, _, truth = close_up("sunlit-wall")
    runs = restir_runs(world, truth, REUSE["paper"], runs=16)
    assert largest_t(runs) > bound(runs)
