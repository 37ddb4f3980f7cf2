"""Area ReSTIR: reuse over the areas of pixels brings no bias, whatever becomes of x_1.

Controls: paths that fall out of the receiver's area are not refused; a primary hit is
kept without its Jacobian.
"""

import numpy as np
import pytest

import restir_gi.extensions.area_shift
from restir_gi.extensions.area_restir import render_area_frames
from restir_gi.extensions.area_settings import AreaSettings
from tests.properties.path_scenes import world
from tests.statistics.path_runs import (
    BOUND,
    SIZE,
    brightness,
    judged,
    of_a_camera_that_moves,
    of_candidates,
    of_reuse,
)

STILL = [
    ("paint", 2, AreaSettings(mis="1/Z")),
    ("rough metal", 2, AreaSettings(mis="balance")),
    ("mirror", 3, AreaSettings(mis="defensive")),
    ("glass", 3, AreaSettings(mis="1/Z")),
    ("checker", 1, AreaSettings(mis="pairwise")),
]
PAST_ALONE = {
    primary: AreaSettings(primary=primary, spatial=False)
    for primary in ("move", "keep")
}
PAST_RUNS = 250
MOVING = [
    *((settings, PAST_RUNS) for settings in PAST_ALONE.values()),
    (AreaSettings(mis="defensive"), 120),
    (AreaSettings(primary="keep", mis="balance"), 120),
]


def still(scene, bounces, settings, runs):
    found = of_reuse(scene, settings, bounces, runs, render_area_frames)
    return judged(found, brightness(scene, bounces))


def moving(settings, runs):
    return judged(*of_a_camera_that_moves(settings, runs, render_area_frames))


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "bounces", "settings"), STILL, ids=str)
def test_reuse_brings_no_bias(scene, bounces, settings):
    assert still(scene, bounces, settings, 80)


@pytest.mark.slow
@pytest.mark.parametrize(("settings", "runs"), MOVING, ids=str)
def test_a_camera_that_moves_brings_no_bias(settings, runs):
    """The past is found by fractions of pixels."""
    assert moving(settings, runs)


def test_a_few_runs_show_no_bias():
    assert moving(AreaSettings(primary="keep"), 30)


@pytest.mark.slow
def test_control_what_falls_out_of_the_pixel_is_not_refused(monkeypatch):
    """Samples of its neighbours' areas make a pixel brighter."""
    monkeypatch.setattr(restir_gi.extensions.area_shift, "row_at", Everywhere())
    assert not moving(PAST_ALONE["move"], PAST_RUNS)


class Everywhere:
    """In place of `row_at`: whoever asks, the place is in their pixel."""

    def __call__(self, x, y, world):
        """Equal to everything."""
        return self

    def __eq__(self, pixel):
        """Yes."""
        return np.ones(len(pixel), bool)

    __hash__ = None


@pytest.mark.slow
def test_control_a_primary_hit_kept_without_its_jacobian_is_refuted(monkeypatch):
    kept = restir_gi.extensions.area_shift.kept_in_place

    def flat(*seen):
        x, y, jacobian = kept(*seen)
        return x, y, (jacobian > 0).astype(float)

    monkeypatch.setattr(restir_gi.extensions.area_shift, "kept_in_place", flat)
    assert not moving(PAST_ALONE["keep"], PAST_RUNS)


def candidates(jitter):
    alone = AreaSettings(temporal=False, spatial=False)
    w = world("checker", SIZE)
    return of_candidates(w, alone, 2, render_area_frames, jitter, 1024)


@pytest.mark.slow
def test_candidates_are_means_over_the_areas_of_pixels():
    assert candidates(np.random.default_rng(5)) < BOUND


@pytest.mark.slow
def test_control_the_centres_of_pixels_are_another_picture():
    assert candidates(None) > BOUND
