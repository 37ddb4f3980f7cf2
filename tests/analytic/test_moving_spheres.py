"""The noise-free spheres, from a camera that moves, and moving themselves.

Evidence: analytic, free of noise.  Inside a sphere every merged weight is the same
number, whoever made the sample and in whichever frame: so the furnace shows its answer
in every pixel of every frame, and the half-lit sphere whole numbers over M, for every
form of reuse that is unbiased.  What is wrong with a shift between frames shows at
once.  Tolerance: as in ``test_spheres.py``, 1e-12 for some thousand roundings.
"""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.options.motion import TemporalShift
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import still, with_camera, with_shape
from restir_gi.reference.scene.catalogue.answers import half_lit_sphere, sphere_furnace
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.world import build_world
from tests.analytic.rendering import ONE_BAND, sized

ROUNDING = 1e-12
SIZE, FRAMES = 12, 5

WIDE = {"radius": 0.7, "min_radius": 3.0, "max_angle": 180.0, "max_depth": 1.0}
"""Whoever is met is taken, so that Jacobians are far from 1."""


def flying(scene):
    """A camera that moves and turns; most pixels find themselves in the last frame."""

    def camera_at(frame):
        x, y, z = scene.camera.position
        place = x - 0.07 * frame, y + 0.05 * frame, z + 0.04 * frame
        return replace(scene.camera, position=place)

    return with_camera(still(scene), camera_at)


def sliding(scene):
    """The sphere moves, and the camera stays."""
    return with_shape(
        still(scene), "sphere", lambda t: pose(0.0, (0.04 * t, -0.03 * t, 0.02 * t))
    )


def both(scene):
    """Sphere and camera move, each its own way."""
    eye = flying(scene)
    return with_camera(sliding(scene), lambda t: eye(t).camera)


def frames_of(name, animate, bounces=1, seed=0, **settings):
    """The first frames of an animated sphere."""
    animation = animate(sized(find_scene(name), SIZE))
    settings = {"source": "cosine", **WIDE, **settings}
    world = build_world(animation(0))
    run = render_frames(world, Settings(**settings), bounces, seed, ONE_BAND, animation)
    return [next(run) for _ in range(FRAMES)]


def error(frame, bounces=1):
    """Largest relative deviation of any pixel of the furnace."""
    return np.abs(frame.color / sphere_furnace(bounces)[1] - 1.0).max()


OPTIONS = {
    "1/Z": {},
    "balance": {"mis": "balance"},
    "pairwise": {"mis": "pairwise"},
    "defensive": {"mis": "defensive"},
    "1/M": {"mis": "1/M"},
    "late visibility": {"visibility": "chosen"},
    "no spatial reuse": {"spatial": False},
    "double-buffered": {"reuse": "double-buffered"},
    "fused": {"reuse": "fused"},
    "fused pairs": {"reuse": "fused", "mis": "pairwise"},
    "boosted": {"boost_below": 30.0},
    "boosted pairs": {"boost_below": 30.0, "mis": "defensive"},
    "shuffled": {"permutation": True},
    "searched": {"fallback_search": True, "max_depth": 0.05, "max_angle": 5.0},
    "checkerboard": {"checkerboard": True},
    "final ray": {"visibility": "none", "final_visibility": "traced"},
    "final ray, reused": {"visibility": "none", "final_visibility": "reused"},
    "small caps": {"temporal_cap": 2.0, "spatial_cap": 3.0},
}


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize("animate", [still, flying, sliding, both])
def test_the_furnace_is_even_in_every_frame(name, animate):
    for frame in frames_of("sphere-furnace", animate, seed=3, **OPTIONS[name]):
        assert error(frame) < ROUNDING


@pytest.mark.parametrize("animate", [flying, both])
def test_longer_paths_are_found_again_too(animate):
    for frame in frames_of("sphere-furnace", animate, 3, seed=5):
        assert error(frame, 3) < ROUNDING


@pytest.mark.parametrize("name", ["1/Z", "double-buffered", "fused", "boosted"])
def test_samples_are_counted_in_whole_numbers(name):
    """M times the picture is an integer, whichever frames the samples come from."""
    free = {"temporal_cap": np.inf, "spatial_cap": np.inf}
    unit, _ = half_lit_sphere()
    for frame in frames_of("half-lit-sphere", flying, seed=2, **free, **OPTIONS[name]):
        M = frame.spatial.M
        count = M * frame.color[:, 0] / unit
        assert np.abs(count - np.rint(count)).max() <= ROUNDING * M.max()
        assert (count <= M + 0.5).all()
    assert ((count > 0.5) & (count < M - 0.5)).any()


def forgets_the_motion(shift, y, x):
    return x


def stays_behind(shift, y, active):
    return y


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("points_forward", forgets_the_motion), ("forward", stays_behind)],
)
def test_control_a_wrong_shift_shows_in_the_furnace(monkeypatch, name, wrong):
    """By more than a thousandth, where the right one is off by less than 1e-12."""
    monkeypatch.setattr(TemporalShift, name, wrong)
    assert error(frames_of("sphere-furnace", sliding, seed=3)[-1]) > 1e-3


def test_control_reuse_as_it_stands_shows_in_the_furnace():
    assert error(frames_of("sphere-furnace", flying, motion="as-stored")[-1]) > 1e-2


@pytest.mark.parametrize("wrong", ["left-out", "divided"])
@pytest.mark.parametrize("name", ["no spatial reuse", "fused", "double-buffered"])
def test_control_a_wrong_jacobian_shows_in_every_pass(name, wrong):
    options = {**OPTIONS[name], "jacobian": wrong}
    assert error(frames_of("sphere-furnace", flying, seed=3, **options)[-1]) > 1e-2


def test_control_one_sided_and_clamped_limits_show():
    for beyond in ("reject", "clamp"):
        options = {"jacobian_limit": 1.5, "beyond_limit": beyond}
        assert error(frames_of("sphere-furnace", still, seed=3, **options)[-1]) > 1e-2
