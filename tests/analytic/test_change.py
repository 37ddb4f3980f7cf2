"""A light that goes out: what is left of it, with and without sample validation.

Evidence: analytic.  The truth is black, to the last bit, from the moment of the switch:
any light in the picture is of the past.
"""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import Animation, still
from restir_gi.reference.scene.catalogue.animations import CHANGE
from restir_gi.reference.scene.catalogue.registry import find_animation, find_scene
from restir_gi.reference.settings import BIASED, UNBIASED
from restir_gi.reference.transport.world import build_world

SIZE, WITHIN = 16, 6


def small(animation, size=SIZE):
    def at(frame):
        scene = animation(frame)
        return replace(scene, camera=replace(scene.camera, width=size, height=size))

    return Animation(at, animation.changes)


def frames_of(animation, settings, count, seed=3, bounces=1):
    world = build_world(animation(0))
    frames = render_frames(world, settings, bounces, seed, Schedule(), animation)
    return [next(frames) for _ in range(count)]


@pytest.fixture(scope="module")
def switched():
    return small(find_animation("light-switch"))


def light_of(frames):
    return np.array([frame.color.mean() for frame in frames])


def test_validation_forgets_the_light_within_six_frames(switched):
    light = light_of(frames_of(switched, BIASED, CHANGE + WITHIN))
    assert BIASED.validate_every == WITHIN
    assert light[: CHANGE - 1].min() > 0
    assert light[-1] == 0


def test_without_validation_it_stays(switched):
    """Of 2 %, which is all that may be left, there is many times as much."""
    settings = replace(BIASED, validate_every=0)
    light = light_of(frames_of(switched, settings, CHANGE + WITHIN))
    assert light[-1] > 0.2 * light[:CHANGE].max()


def test_the_unbiased_form_needs_no_validation(switched):
    """Radiance is found again in each frame: the light is gone at once."""
    light = light_of(frames_of(switched, UNBIASED, CHANGE + 1))
    assert light[CHANGE - 1] > 0
    assert light[CHANGE] == 0


@pytest.mark.parametrize("every", [1, 4])
def test_a_scene_that_stays_keeps_all_its_samples(every):
    """What is traced again with the same random numbers is what it was, bit for bit."""
    scene = find_scene("cornell-box")
    # Something may change in this animation, but nothing does.
    animation = small(Animation(still(scene).scene_at, "scene"))
    settings = replace(BIASED, temporal_cap=1e9, spatial=False, validate_every=every)
    frames = frames_of(animation, settings, 9, bounces=2)
    drawn = np.cumsum([1] + [n % every != every - 1 for n in range(1, 9)])
    for frame, M in zip(frames, drawn, strict=True):
        assert (frame.temporal.M == M).all()


def test_pixels_that_begin_anew_draw_in_a_validating_frame_too():
    """Where the camera jumps there is nothing to validate, and would be nothing."""
    scene = find_scene("cornell-box")
    aside = replace(scene.camera, position=(0.6, 1.5, 3.4))
    jump = [scene, replace(scene, camera=aside)]
    animation = small(Animation(lambda t: jump[min(t, 1)], "scene"))
    settings = replace(BIASED, validate_every=1)
    _, last = frames_of(animation, settings, 2)
    assert (last.temporal.M == 1).all()


def test_control_other_random_numbers_empty_the_reservoirs(monkeypatch):
    """Were the path drawn again, its radiance would differ, and M with it."""
    from restir_gi.reference.options import history
    from restir_gi.reference.options.replay import Replay, replay_of

    def drawn_anew(frame):
        replay = replay_of(frame)
        return Replay(
            replay.bounces, lambda n: replay.uniforms(n + frame.pixels), replay.tail
        )

    scene = find_scene("cornell-box")
    animation = small(Animation(still(scene).scene_at, "scene"))
    settings = replace(BIASED, temporal_cap=1e9, spatial=False, validate_every=4)
    monkeypatch.setattr(history, "replay_of", drawn_anew)
    last = frames_of(animation, settings, 4, bounces=2)[-1]
    assert (last.temporal.M < 3).mean() > 0.2
