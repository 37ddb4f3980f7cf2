"""Paths from the end: whole paths again, that can be shifted as any other."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import restir_gi.hashgrid.regir_gi
from restir_gi.extensions.pt_settings import CRITERIA
from restir_gi.extensions.shifting import Shift
from restir_gi.hashgrid.path_settings import CellSettings
from restir_gi.hashgrid.regir_gi import render_cell_frames
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world
from tests.properties.path_scenes import points, uniforms, world

CELLS_ALONE = CellSettings(temporal=False, spatial=False, cells=2)
ONE = Schedule(band=1 << 20)
FRAMES = 4
ROUNDINGS = 100 * 2.0**-53

PLANS = [
    ("paint", 2, 2),
    ("paint", 3, 0),
    ("rough metal", 3, 2),
    ("mirror", 3, 2),
    ("glass", 4, 0),
    ("smooth coat", 3, 3),
    ("checker", 2, 1),
    ("mirror-floor", 3, 2),
]


def last_frame(scene, bounces, settings, frames=FRAMES, seed=7):
    made = render_cell_frames(world(scene), settings, bounces, seed, ONE)
    return list(islice(made, frames))[-1]


def shifted_to_itself(scene, bounces, query):
    """Paths of the last frame, and what each is worth where it already is."""
    w = world(scene)
    frame = last_frame(scene, bounces, replace(CELLS_ALONE, query=query))
    r = frame.reservoirs
    rows = np.flatnonzero(r.W > 0)
    x = points(w)
    shift = Shift(CRITERIA["hybrid"], uniforms(len(x)))
    value, jacobian = shift(w, x, rows, r.y, rows)
    return r, rows, value, jacobian


@pytest.mark.parametrize(("scene", "bounces", "query"), PLANS)
def test_a_path_that_a_cell_has_ended_is_shifted_to_itself(scene, bounces, query):
    """Whatever a cell did, the record says the whole path, and all of it.

    A path is the product of at most 5 vertices of some 10 operations each, computed
    once from each end: 100 roundings.
    """
    r, rows, value, jacobian = shifted_to_itself(scene, bounces, query)
    assert len(rows) > 60
    assert (jacobian > 0).all()
    assert_allclose(jacobian, 1.0, rtol=ROUNDINGS)
    scale = r.y.value[rows].max(axis=1, keepdims=True)
    off = np.abs(value - r.y.value[rows]) / scale
    assert off.max() < ROUNDINGS


def test_control_numbers_of_the_neighbour_lead_elsewhere(monkeypatch):
    """What is replayed before the joint is this path's own prefix."""
    resample_bounce = restir_gi.hashgrid.regir_gi.resample_bounce

    def of_the_neighbour(frame, lookup, number, **rest):
        kept = resample_bounce(frame, lookup, number=number, **rest)
        return replace(kept, y=replace(kept.y, number=np.roll(number, 1)))

    monkeypatch.setattr(
        restir_gi.hashgrid.regir_gi, "resample_bounce", of_the_neighbour
    )
    _, _, _, jacobian = shifted_to_itself("glass", 4, 0)
    assert not (jacobian > 0).all()


@pytest.mark.parametrize("scene", ["paint", "mirror", "glass"])
def test_cells_hold_paths_that_can_be_joined_or_none(scene):
    frame = last_frame(scene, 3, CELLS_ALONE)
    (cache,) = frame.caches.values()
    r = cache.cache.reservoirs
    assert (r.y.joint[r.W > 0] == 2).all()
    assert (r.W > 0).any()
    # Nulls are there, and count.
    inserted = np.zeros(len(r.W), bool)
    inserted[cache.cache.grid.cell_storage] = True
    assert (inserted & (r.W == 0)).any()
    assert (r.M[inserted] >= 1).all()


def test_dropped_nulls_are_in_no_cell():
    settings = replace(CELLS_ALONE, nulls="dropped")
    (cache,) = last_frame("paint", 2, settings).caches.values()
    assert (cache.cache.reservoirs.W[cache.cache.grid.cell_storage] > 0).all()


def test_a_cell_holds_the_bounce_that_looks_up_or_every_bounce():
    few, many = (
        last_frame("paint", 3, replace(CELLS_ALONE, writers=writers)).caches
        for writers in ("same-bounce", "every-bounce")
    )
    assert list(few) == list(many) == [2]
    assert len(many[2].cache.points) == 3 * len(few[2].cache.points)
    assert set(few[2].reach) == {3}
    assert set(many[2].reach) == {4, 3, 2}
    all_three = last_frame("paint", 3, replace(CELLS_ALONE, query=0)).caches
    assert {v: set(cache.reach.tolist()) for v, cache in all_three.items()} == {
        1: {4},
        2: {3},
        3: {2},
    }


@pytest.mark.parametrize("writers", ["same-bounce", "every-bounce"])
def test_no_path_is_longer_than_asked(writers):
    settings = replace(CELLS_ALONE, writers=writers, query=0)
    y = last_frame("paint", 2, settings, frames=6).reservoirs.y
    assert y.end.max() == 3


def test_without_a_bounce_that_looks_up_nothing_is_stored():
    assert last_frame("paint", 1, CELLS_ALONE).caches == {}
    assert last_frame("paint", 2, replace(CELLS_ALONE, cells=0)).caches == {}


def test_paths_that_cannot_be_joined_need_no_cell():
    """Replay alone: nobody is rough enough, and every cell is empty."""
    frame = last_frame("paint", 2, replace(CELLS_ALONE, shift="replay"))
    (cache,) = frame.caches.values()
    assert len(cache.cache.grid) == 0
    assert frame.color.any()


def moving(schedule, settings, frames=3):
    found = find_animation("moving-camera")

    def at(frame):
        scene = found(10 * frame)
        camera = replace(scene.camera, width=32, height=24)
        return validate(replace(scene, camera=camera))

    scenes = [at(frame) for frame in range(frames)]
    animation = Animation(lambda frame: scenes[frame], found.changes)
    made = render_cell_frames(
        build_world(scenes[0]), settings, 3, 5, schedule, animation
    )
    return [next(made) for _ in range(frames)]


def test_bands_and_threads_change_no_bit():
    settings = CellSettings(query=0, writers="every-bounce")
    whole = moving(ONE, settings)
    for schedule in (Schedule(band=37), Schedule(band=101, threads=4)):
        for a, b in zip(whole, moving(schedule, settings), strict=True):
            assert_array_equal(a.color, b.color)
            assert_array_equal(
                a.caches[2].cache.grid.cell_storage,
                b.caches[2].cache.grid.cell_storage,
            )
    assert whole[-1].color.any()


def test_the_grid_that_is_read_has_its_own_eye():
    """A camera that moves looks into the last frame's cells, by that frame's eye."""
    first, second, _ = moving(ONE, CellSettings())
    assert first.caches[2].cache.lattice.eye != second.caches[2].cache.lattice.eye
    assert second.caches[2].cache.lattice.eye == second.world.camera.position


def test_nothing_seen_and_nothing_lit():
    w = world("paint")
    away = replace(w.camera, position=(0, 1, 50), target=(0, 1, 60))
    dark = replace(w, scene=replace(w.scene, camera=away))
    for frame in islice(render_cell_frames(dark, CellSettings(), 3, 1, ONE), 2):
        assert not frame.color.any()
    unlit = replace(w, emitters=None)
    for frame in islice(render_cell_frames(unlit, CellSettings(), 3, 1, ONE), 2):
        assert not frame.color.any()
