"""Light reservoirs in world space: what is taken from cells brings no bias.

Controls: 1/M; the inverse shift in the scene of the receivers; lights drawn by power
and counted as if they were drawn evenly.

A correct method fails a test of reuse with a probability of at most 2e-4, half of it by
its tiles, and one of candidates with 1e-4: `tests.statistics.path_runs`.
"""

from dataclasses import replace

import numpy as np
import pytest

import restir_gi.hashgrid.world_reservoirs
from restir_gi.hashgrid.light_settings import LightSettings
from restir_gi.hashgrid.lights import draw_lights, reflected
from restir_gi.hashgrid.world_reservoirs import LightNeighbor, render_light_frames
from restir_gi.reference.numerics.records import take
from tests.properties.path_scenes import world
from tests.statistics.path_runs import (
    BOUND,
    SIZE,
    brightness,
    judged,
    of_a_scene_that_moves,
    of_candidates,
    of_last_frames,
)

WITHOUT = {"cells": 0}
RUNS = 50

PLANS = {
    "paint": LightSettings(),
    "rough metal": LightSettings(mis="balance", chance="balance", visible=True),
    "smooth coat": LightSettings(mis="pairwise", facings=4),
    "glass": LightSettings(cells=2, candidates=2),
    "many-lights": LightSettings(cap=100.0, mis="defensive"),
    "checker": LightSettings(candidates=1, reuse=2, mis="1/Z"),
}


def still(scene, settings, bounces, runs=RUNS):
    w = world(scene, SIZE)
    found = of_last_frames(w, settings, bounces, runs, render_light_frames, WITHOUT)
    return judged(found, brightness(scene, bounces))


def moving(name, settings, runs=RUNS, stride=1):
    return judged(
        *of_a_scene_that_moves(
            name, settings, runs, render_light_frames, WITHOUT, stride
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("bounces", [1, 2, 3])
@pytest.mark.parametrize("scene", PLANS)
def test_reuse_brings_no_bias(scene, bounces):
    assert still(scene, PLANS[scene], bounces)


def test_a_few_runs_show_no_bias():
    assert still("paint", LightSettings(), 2, 40)


def test_control_one_over_m_is_refuted():
    """Blocks face away from a light that the walls behind them see."""
    assert not still("paint", LightSettings(mis="1/M"), 2, 40)


MOVES = {"moving-camera": 10, "moving-light": 8, "moving-block": 8}


@pytest.mark.slow
@pytest.mark.parametrize("mis", ["1/Z", "balance"])
@pytest.mark.parametrize("name", MOVES)
def test_what_moves_brings_no_bias(name, mis):
    assert moving(name, LightSettings(mis=mis), stride=MOVES[name])


@pytest.mark.slow
def test_control_the_inverse_shift_in_the_scene_of_the_receivers(monkeypatch):
    """What a lamp would have been worth before it moved is another number."""

    def as_it_is_now(self, samples, at):
        points, lights = take(self.points_from, self.rows[at]), take(samples, at)
        return reflected(self.world, points, lights, self.chance), np.ones(len(at))

    monkeypatch.setattr(LightNeighbor, "inverse", as_it_is_now)
    assert not moving("moving-light", LightSettings(mis="balance"), 120, 20)


CANDIDATES = {
    "paint": (1, LightSettings()),
    "rough metal": (2, LightSettings(chance="balance")),
    "smooth coat": (3, LightSettings(candidates=1)),
    "glass": (3, LightSettings()),
    "rough glass": (3, LightSettings(candidates=2)),
    "many-lights": (1, LightSettings(chance="balance")),
    "checker": (2, LightSettings(candidates=3)),
}


def candidates(scene, frames=256):
    bounces, settings = CANDIDATES[scene]
    alone = replace(settings, **WITHOUT)
    w = world(scene, SIZE)
    return of_candidates(w, alone, bounces, render_light_frames, frames=frames)


@pytest.mark.slow
@pytest.mark.parametrize("scene", CANDIDATES)
def test_without_reuse_it_is_the_path_tracer(scene):
    assert candidates(scene) < BOUND


@pytest.mark.slow
def test_control_the_density_of_a_light_is_forgotten(monkeypatch):
    """Lamps of different powers come as often as others, and count as often."""

    def even(emitters, u):
        lights, density = draw_lights(emitters, u)
        return lights, np.full_like(density, 1.0 / len(emitters.probability))

    monkeypatch.setattr(restir_gi.hashgrid.world_reservoirs, "draw_lights", even)
    assert candidates("many-lights") > BOUND
