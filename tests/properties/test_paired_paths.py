"""Pairs of paths: what they are worth, and where shifts of both kinds lead."""

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from restir_gi.extensions.area_restir import area_drawn
from restir_gi.extensions.area_shift import AreaShift, PlacedValue
from restir_gi.extensions.frame_loop import path_shift
from restir_gi.gradient_domain.gradient_restir import (
    MINUS,
    PLUS,
    WHOLE,
    PairValue,
    choose_pair,
    contribution,
    difference,
    inner_shift,
    integrand,
    outer_shift,
    paired,
    render_gradient_frames,
    share_of_base,
    target,
)
from restir_gi.gradient_domain.pairs import pair_at, pair_windows, pivots, pixel_pairs
from restir_gi.gradient_domain.settings import GradientSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.schedule import Schedule
from tests.properties.path_scenes import world
from tests.statistics.path_runs import SIZE, moving
from tests.statistics.replicates import g_buffer

positive = st.floats(1e-6, 1e6)


# ------------------------------------------------------------ worth


@given(positive, positive, positive)
def test_weights_of_both_ways_sum_to_one(p, q, jacobian):
    """Equations 4 and 13: of base and offset path, drawn in one or the other pixel."""
    p, q, jacobian = (np.array([v]) for v in (p, q, jacobian))
    total = share_of_base(p, q, jacobian) + share_of_base(q, p, 1.0 / jacobian)
    # Five roundings, and the inverse of a rounded inverse.
    assert abs(total[0] - 1.0) < 8 * 2.0**-53


def test_a_base_path_alone_has_all_the_weight():
    one, none = np.ones(1), np.zeros(1)
    assert share_of_base(one, one, none) == 1.0
    assert share_of_base(none, one, none) == 0.0


def values(rng, size=64):
    """Of random samples, a third without offset path, channels of both signs."""
    inner = np.where(rng.random(size) < 1 / 3, 0.0, rng.lognormal(size=size))
    offset = rng.random((size, 3)) * (inner > 0)[:, None]
    none = np.zeros(size)
    base = PlacedValue(none, none, rng.random((size, 3)), none + 1.0)
    k = rng.integers(0, 2, size).astype(np.int8)
    return PairValue(k, base, offset, inner, np.zeros(size, np.int8))


def signed(value, sign):
    return replace(value, sign=np.full(len(value.k), sign, np.int8))


def test_what_a_sample_says_of_a_difference():
    """Equation 15, row by row; a failed inner shift leaves the base path alone."""
    value = values(np.random.default_rng(1))
    for row, found in enumerate(difference(value)):
        f, g = value.base.value[row], value.offset[row] * value.inner[row]
        expected = f - g if value.k[row] == 0 else g - f
        assert_array_equal(found, expected)
    alone = value.inner == 0
    assert alone.any()
    assert_array_equal(np.abs(integrand(value))[alone], value.base.value[alone])


def test_parts_of_both_signs_make_the_whole():
    """In each channel; and a sample has a target exactly where it has a part."""
    value = values(np.random.default_rng(2))
    plus, minus, whole = (signed(value, s) for s in (PLUS, MINUS, WHOLE))
    assert_array_equal(contribution(plus) + contribution(minus), integrand(value))
    assert_array_equal(contribution(whole), integrand(value))
    magnitude = np.abs(contribution(plus)) + np.abs(contribution(minus))
    assert_array_equal(magnitude, np.abs(integrand(value)))
    for v in (plus, minus, whole):
        assert_array_equal(target(v) > 0, contribution(v).any(axis=1))
    mixed = (integrand(value) > 0).any(axis=1) & (integrand(value) < 0).any(axis=1)
    assert mixed.any()
    assert (target(plus)[mixed] > 0).all()
    assert (target(minus)[mixed] > 0).all()


def test_targets_are_those_of_the_parts():
    """Luminance of max(G, 0), and of max(−G, 0), by channel."""
    value = values(np.random.default_rng(4))
    weights = target_weights()
    for sign in (PLUS, MINUS):
        part = np.maximum(sign * integrand(value), 0.0)
        found = target(signed(value, sign))
        # Three products and two sums each.
        np.testing.assert_allclose(found, part @ weights, rtol=8 * 2.0**-53)


def test_channels_of_both_signs_do_not_cancel():
    """Luminance of the difference may be 0 where the difference is not."""
    none = np.zeros(1)
    base = PlacedValue(none, none, np.array([[1.0, 0.0, 0.0]]), none + 1)
    r, g, _ = target_weights()
    offset = np.array([[0.0, r / g, 0.0]])
    value = PairValue(
        np.zeros(1, np.int8), base, offset, none + 1, np.zeros(1, np.int8)
    )
    assert target(value)[0] == pytest.approx(r, rel=1e-12)


def target_weights():
    none = np.zeros(3)
    base = PlacedValue(none, none, np.eye(3), none + 1)
    zeros = np.zeros(3, np.int8)
    return target(PairValue(zeros, base, np.zeros((3, 3)), none, zeros))


# ------------------------------------------------------------ shifts


@cache
def still(name):
    """The shift within the image of a scene, and the new paths of its pixels."""
    w = world(name, SIZE)
    frame = FrameContext(0, w, g_buffer(w), GradientSettings(), 3, 5, Schedule())
    within = AreaShift(path_shift(frame), "move", w, w)
    return within, area_drawn(frame, slice(0, SIZE * SIZE))


SCENES = ["paint", "rough metal", "mirror", "glass", "checker"]
each_scene = pytest.mark.parametrize("name", SCENES)
PAIRS = pixel_pairs(SIZE, SIZE)
EVERY = slice(0, len(PAIRS))


@each_scene
@pytest.mark.parametrize("k", [0, 1])
def test_an_offset_path_leads_back_to_its_base_path(name, k):
    """The inner shift is its own inverse, with the inverse Jacobian."""
    within, drawn = still(name)
    r = paired(within, drawn, PAIRS, k, EVERY)
    at = np.flatnonzero((r.W > 0) & (r.y.inner > 0))
    assert len(at) > 100
    base, pairs = take(r.y.base, at), take(PAIRS, at)
    onward = 1.0 if k == 0 else -1.0
    other = pairs.second if k == 0 else pairs.first
    placed, jacobian = within(base, other, onward * pairs.dx, onward * pairs.dy)
    assert_array_equal(jacobian, r.y.inner[at])
    offset = base.moved(placed, jacobian)
    f, inner = inner_shift(within, offset, np.full(len(at), 1 - k), pairs)
    # Hits of camera rays are traced afresh: places in the image are rounded, and
    # cosines and distances with them, to 2^-22 of the scene over 1e-2 of it.
    returned = inner > 0
    assert returned.mean() > 0.995
    product = (inner * jacobian)[returned]
    assert np.abs(product - 1).max() < 2.0**-22 * 4 / 1e-2
    error = np.abs(f - base.value.value)[returned].max(axis=1)
    bound = 2.0**-22 * 4 / 1e-2 * base.value.value[returned].max(axis=1)
    assert (error < bound).all()


def around(step):
    """Pairs, and those a few pixels away of the same axis."""
    x, y = PAIRS.first % SIZE, PAIRS.first // SIZE
    return pair_at(PAIRS.axis, x + step[0], y + step[1], SIZE, SIZE)


@each_scene
def test_the_outer_shift_is_that_of_the_base_path(name):
    """Whose Jacobian is all of it; k stays, and the offset path is rebuilt."""
    within, drawn = still(name)
    both = [paired(within, drawn, PAIRS, k, EVERY) for k in (0, 1)]
    u = np.random.default_rng(4).random(len(PAIRS))
    r = choose_pair(both, PLUS, u)
    rows = around((2, 1))
    at = np.flatnonzero((rows != NONE) & (r.W > 0))
    to, samples = take(PAIRS, rows[at]), take(r.y, at)
    dx, dy = np.full(len(at), 2.0), np.full(len(at), 1.0)
    value, jacobian = outer_shift(within, samples, pairs=to, dx=dx, dy=dy, sign=MINUS)
    pixel = np.where(samples.k == 0, to.first, to.second)
    placed, expected = within(samples.base, pixel, dx, dy)
    assert_array_equal(jacobian, expected)
    there = jacobian > 0
    assert there.sum() > 50
    assert_array_equal(value.k[there], samples.k[there])
    assert set(value.sign[there]) == {MINUS}
    assert_array_equal(value.base.value, placed.value)
    moved = samples.base.moved(placed, jacobian)
    offset, inner = inner_shift(within, moved, samples.k, to)
    assert_array_equal(value.offset[there], offset[there])
    assert_array_equal(value.inner[there], inner[there])
    # Where the base path has no place, the sample is nothing: not ±f of an offset path.
    assert not value.base.value[~there].any()
    assert not value.offset[~there].any()
    assert (~there).any()


# ------------------------------------------------------------ motion


@cache
def two_frames():
    """A frame of a camera that moves, and the context of the next one."""
    first, _, animation = moving("moving-camera")
    frames = render_gradient_frames(
        first, GradientSettings(), 2, 3, Schedule(), animation
    )
    before, after = islice(frames, 2)
    about = GradientSettings(), 2, 3, Schedule()
    return before, FrameContext(1, after.world, after.visible, *about)


def test_the_nearer_pixel_is_the_pivot():
    _, frame = two_frames()
    visible = frame.visible
    found = pivots(PAIRS, visible)
    a, b = visible.depth[PAIRS.first], visible.depth[PAIRS.second]
    hit_a, hit_b = (visible.surface.hit[p] for p in (PAIRS.first, PAIRS.second))
    second = hit_b & (~hit_a | (b < a))
    assert_array_equal(found, np.where(second, PAIRS.second, PAIRS.first))
    assert second.any()
    assert (hit_a & ~hit_b).any() or hit_a.all()


def test_pairs_of_the_past_have_the_pivot_where_it_was():
    """Both pixels move with it, by one fraction of a pixel."""
    last, frame = two_frames()
    pivot = pivots(PAIRS, frame.visible)
    is_second = pivot == PAIRS.second
    found = pair_windows(frame, last, PAIRS)
    assert len(found) == 4
    assert any((window.dx != np.round(window.dx)).any() for window in found)
    for window in found:
        at = np.flatnonzero(window.rows != NONE)
        assert len(at) > 100
        then = take(PAIRS, window.rows[at])
        assert_array_equal(then.axis, PAIRS.axis[at])
        pivot_then = np.where(is_second[at], then.second, then.first)
        # Its centre comes from within a pixel of that of the pixel then.
        x = pivot[at] % SIZE - window.dx[at] - pivot_then % SIZE
        y = pivot[at] // SIZE - window.dy[at] - pivot_then // SIZE
        assert np.abs(x).max() < 1
        assert np.abs(y).max() < 1
        overlap = (1 - np.abs(x)) * (1 - np.abs(y))
        np.testing.assert_allclose(window.share[at], overlap, rtol=0, atol=1e-9)
    assert (sum(window.share for window in found) <= 1 + 1e-9).all()


def test_pairs_of_a_still_camera_stay():
    last, frame = two_frames()
    (window,) = pair_windows(replace(frame, world=last.world), last, PAIRS)
    assert_array_equal(window.rows, np.arange(len(PAIRS)))
    assert not window.dx.any()
    assert (window.share == 1).all()
