"""Shifts of pixels' areas: places, the Jacobian of a kept hit, and the way back."""

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np
import pytest

from restir_gi.extensions.area_restir import render_area_frames, windows
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.area_shift import AreaNeighbor, AreaShift, kept_in_place
from restir_gi.extensions.frame_loop import path_shift
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.path_tracer import first_hits
from restir_gi.reference.transport.world import build_world

SIZE = 48
ROWS = np.arange(SIZE * SIZE)


@cache
def frames():
    """Two frames of the camera that moves, and the moment of a third."""
    found = find_animation("moving-camera")

    def at(frame):
        scene = found(4 * frame)
        camera = replace(scene.camera, width=SIZE, height=SIZE)
        return validate(replace(scene, camera=camera))

    path = Animation(at, found.changes)
    shown = render_area_frames(
        build_world(at(0)), AreaSettings(), 2, 3, Schedule(), path
    )
    first, second = islice(shown, 2)
    frame = FrameContext(
        number=1,
        world=second.world,
        visible=second.visible,
        settings=AreaSettings(),
        bounces=2,
        seed=3,
        schedule=Schedule(),
    )
    return first, frame


def random_places(seed=1):
    u = np.random.default_rng(seed).random((2, len(ROWS)))
    return ROWS % SIZE + u[0], ROWS // SIZE + u[1]


def test_every_place_of_a_pixel_was_in_one_window():
    """The parts of the past are disjoint, and there is no other."""
    last, frame = frames()
    x, y = random_places()
    found = windows(frame, last, ROWS)
    count = np.zeros(len(ROWS))
    for window in found:
        x_then, y_then = np.floor(x - window.dx), np.floor(y - window.dy)
        inside = (x_then == window.rows % SIZE) & (y_then == window.rows // SIZE)
        count += inside & (window.rows != NONE)
    share = sum(window.share for window in found)
    whole = share > 1 - 1e-9
    assert whole.mean() > 0.7
    assert (share <= 1 + 1e-9).all()
    assert set(count[whole]) == {1.0}
    assert count.max() == 1


def test_shares_are_areas():
    """Of places drawn evenly, as many as it says fall into each window."""
    last, frame = frames()
    found, draws = windows(frame, last, ROWS), 400
    for window in found:
        inside = np.zeros(len(ROWS))
        for seed in range(draws):
            x, y = random_places(seed)
            x_then, y_then = np.floor(x - window.dx), np.floor(y - window.dy)
            inside += (x_then == window.rows % SIZE) & (y_then == window.rows // SIZE)
        expected = draws * window.share
        spread = np.sqrt(expected * (1 - window.share))
        there = (window.rows != NONE) & (spread > 0)
        # A sum of squares of some 2000 binomial deviates: off by 6 of its standard
        # deviations, sqrt(2 / n), with less than 1e-8, kurtosis included.
        z = ((inside - expected) / np.maximum(spread, 1e-9))[there]
        n = there.sum()
        assert n > 1000
        assert abs(np.mean(z**2) - 1) < 12 * np.sqrt(2 / n)


def test_a_still_camera_moves_nothing():
    last, frame = frames()
    (window,) = windows(replace(frame, world=last.world), last, ROWS)
    np.testing.assert_array_equal(window.rows, ROWS)
    assert not window.dx.any()
    assert (window.share == 1).all()


def test_the_jacobian_of_a_kept_hit_is_that_of_its_places():
    """|∂(x, y)_to / ∂(x, y)_from| by central differences of the mapping itself."""
    last, frame = frames()
    x, y = random_places()
    h = 0.01
    _, _, stated = kept_in_place(last.world, frame.world, first_hits(last.world, x, y))
    middle = first_hits(last.world, x, y)
    columns, same = [], middle.hit.copy()
    for dx, dy in ((h, 0.0), (0.0, h)):
        ends = []
        for sign in (1, -1):
            seen = first_hits(last.world, x + sign * dx, y + sign * dy)
            same &= seen.primitive == middle.primitive
            ends.append(kept_in_place(last.world, frame.world, seen)[:2])
        columns.append([(a - b) / (2 * h) for a, b in zip(*ends, strict=True)])
    (a, c), (b, d) = columns
    found = np.abs(a * d - b * c)
    rows = same & (stated > 0)
    assert rows.mean() > 0.9
    # A hit is rounded to 2^-22 of the scene's half extent; seen from a distance of at
    # least that, through 24 pixels a tangent, it is 2^-22 · 48 pixels, over h.
    # What h leaves of the third derivatives of a projection is h² / d².
    rounding = 2.0**-22 * SIZE / h
    tolerance = 4 * rounding * np.maximum(1, found) + h**2
    assert np.median(tolerance[rows]) < 0.01
    assert (np.abs(found - stated) < tolerance)[rows].all()
    assert np.abs(found[rows] - 1).max() > 0.05  # else it would prove nothing


def donor_of(primary):
    """All pixels of the last frame offered to the pixels that their hits fall into."""
    last, frame = frames()
    shown = windows(frame, last, ROWS)[0]
    return last, AreaNeighbor(
        AreaShift(path_shift(frame), primary, last.world, frame.world),
        ROWS,
        last.reservoirs,
        shown.rows,
        shown.dx,
        shown.dy,
    )


@pytest.mark.parametrize("primary", ["move", "keep"])
def test_there_and_back_leads_to_where_it_came_from(primary):
    """But for the rounding of hits, traced again: x_1 is no part of a path."""
    last, donor = donor_of(primary)
    at = np.flatnonzero((donor.rows != NONE) & (last.reservoirs.W[donor.rows] > 0))
    placed, forth = donor.shifted(at)
    base = take(last.reservoirs.y, donor.rows[at])
    there = base.moved(placed, forth)
    ok = np.flatnonzero(forth > 0)
    assert len(ok) > 50
    everywhere = take(there, np.searchsorted(at, np.clip(ROWS, at[0], at[-1])))
    back, home = donor.inverse(everywhere, at[ok])
    # Of the few that graze an edge the way back may end on its other side.
    returned = home > 0
    assert returned.mean() > 0.99
    for name in ("x", "y"):
        error = np.abs(getattr(back, name) - getattr(base, name)[ok])[returned]
        assert error.max() < 2.0**-22 * SIZE * 4
    # Relative errors of cosines and squared distances to neighbours of x_1: 2^-22 over
    # a cosine or a distance of 1e-2.
    product = (forth[ok] * home)[returned]
    assert np.abs(product - 1).max() < 2.0**-22 * 4 / 1e-2
    value = base.value.value[ok][returned]
    error = np.abs(back.value[returned] - value).max(axis=1)
    assert (error < 2.0**-22 * 4 / 1e-2 * value.max(axis=1)).all()


@pytest.mark.parametrize("primary", ["move", "keep"])
def test_what_falls_out_of_the_receiver_is_nothing(primary):
    _, donor = donor_of(primary)
    at = np.flatnonzero(donor.rows != NONE)
    placed, jacobian = donor.shifted(at)
    inside = (np.floor(placed.x) == at % SIZE) & (np.floor(placed.y) == at // SIZE)
    assert (~inside).any()
    assert not jacobian[~inside].any()
    assert not placed.value[~inside].any()
    assert (jacobian[inside] > 0).any()


def test_a_kept_hit_is_the_point_that_it_was():
    """What is seen at its new place is what was seen before."""
    last, donor = donor_of("keep")
    at = np.flatnonzero(donor.rows != NONE)
    placed, jacobian = donor.shifted(at)
    ok = jacobian > 0
    base = take(last.reservoirs.y, donor.rows[at])
    before = first_hits(donor.shift.world_from, base.x, base.y)
    now = first_hits(donor.shift.world_to, placed.x[ok], placed.y[ok])
    geometry = donor.shift.world_to.geometry
    apart = contact(geometry, now) - contact(geometry, take(before, np.flatnonzero(ok)))
    assert np.abs(apart).max() < 2.0**-17 * geometry.extent
    assert ok.sum() > 50


def test_another_frame_is_another_world():
    """Else the tests of a moving camera would prove nothing."""
    last, frame = frames()
    assert last.world.camera != frame.world.camera
