"""ReGIR GI: cells that end paths, and screen-space reuse of them, bring no bias.

Controls, each of which is the article's form or a part of it: cells weighted by 1/M;
paths that found nothing forgotten; a Jacobian left out; suffixes without the weight of
their prefix.

A correct method fails a test of reuse with a probability of at most 2e-4, half of it by
its tiles, and one of candidates with 1e-4: `tests.statistics.path_runs`.
"""

from dataclasses import replace

import numpy as np
import pytest

import restir_gi.hashgrid.regir_gi
from restir_gi.hashgrid.path_settings import CellSettings
from restir_gi.hashgrid.regir_gi import render_cell_frames
from tests.properties.path_scenes import world
from tests.statistics.path_runs import (
    BOUND,
    SIZE,
    Flat,
    brightness,
    judged,
    of_a_scene_that_moves,
    of_candidates,
    of_last_frames,
)

WITHOUT = {"cells": 0, "temporal": False, "spatial": False}
CELLS_ALONE = CellSettings(temporal=False, spatial=False)

PLANS = {
    "paint": CELLS_ALONE,
    "rough metal": replace(CELLS_ALONE, cells=2),
    "mirror": replace(CELLS_ALONE, query=0),
    "glass": replace(CELLS_ALONE, facings=4),
    "checker": replace(CELLS_ALONE, cell_mis="defensive"),
    "many-lights": replace(CELLS_ALONE, cells=4, cell_reuse=1),
}
RUNS = 60


def still(scene, settings, bounces, runs=RUNS):
    w = world(scene, SIZE)
    found = of_last_frames(w, settings, bounces, runs, render_cell_frames, WITHOUT)
    return judged(found, brightness(scene, bounces))


@pytest.mark.slow
@pytest.mark.parametrize("bounces", [2, 3, 4])
@pytest.mark.parametrize("scene", PLANS)
def test_cells_bring_no_bias(scene, bounces):
    assert still(scene, PLANS[scene], bounces)


SCREEN = {
    "paint": CellSettings(neighbors=2, mis="balance"),
    "mirror-floor": CellSettings(neighbors=2, mis="balance", query=0),
    "glass": CellSettings(neighbors=1, mis="defensive", query=3),
}


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCREEN)
def test_screen_space_reuse_on_top_brings_no_bias(scene):
    assert still(scene, SCREEN[scene], 3)


def test_a_few_runs_show_no_bias():
    assert still("paint", CELLS_ALONE, 2, 40)


def test_control_the_articles_weights_are_refuted():
    assert not still("paint", replace(CELLS_ALONE, cell_mis="1/M"), 2, 40)


def test_control_forgetting_nulls_is_refuted():
    assert not still("paint", replace(CELLS_ALONE, nulls="dropped"), 2, 40)


@pytest.mark.slow
def test_control_without_a_jacobian_cells_are_biased(monkeypatch):
    path_shift = restir_gi.hashgrid.regir_gi.path_shift

    def flat(frame):
        shift = path_shift(frame)
        return Flat(shift.criterion, shift.uniforms)

    monkeypatch.setattr(restir_gi.hashgrid.regir_gi, "path_shift", flat)
    assert not still("paint", replace(CELLS_ALONE, cells=4), 2, 250)


@pytest.mark.slow
@pytest.mark.parametrize("query", [0, 1, 2])
def test_a_camera_that_moves_brings_no_bias(query):
    settings = CellSettings(query=query, mis="balance", neighbors=2)
    found = of_a_scene_that_moves(
        "moving-camera", settings, 60, render_cell_frames, WITHOUT
    )
    assert judged(*found)


CANDIDATES = {"paint": 1, "rough metal": 2, "mirror": 3, "glass": 4, "checker": 3}


def candidates(scene):
    alone = replace(CELLS_ALONE, cells=0)
    w = world(scene, SIZE)
    return of_candidates(w, alone, CANDIDATES[scene], render_cell_frames)


@pytest.mark.slow
@pytest.mark.parametrize("scene", CANDIDATES)
def test_paths_from_the_end_are_those_of_the_path_tracer(scene):
    assert candidates(scene) < BOUND


@pytest.mark.slow
def test_control_suffixes_without_the_weight_of_their_prefix(monkeypatch):
    """The way to x_v scatters light, too."""
    prepend = restir_gi.hashgrid.regir_gi.prepend

    def unweighted(step, suffix, first):
        return prepend(replace(step, weight=np.ones_like(step.weight)), suffix, first)

    monkeypatch.setattr(restir_gi.hashgrid.regir_gi, "prepend", unweighted)
    assert candidates("mirror") > BOUND
