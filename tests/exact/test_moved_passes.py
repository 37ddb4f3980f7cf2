"""The passes across two frames that differ, integrated exactly over injected samples.

A pixel goes on from another pixel of the last frame.  Between the two frames half of
the sample points have turned and moved with their shape, others hide, and the light has
changed: some sample points that shone are dark, and some that were dark shine.  Every
joint outcome of the old and the new sample, and of the decision between them, is a row.
E[W 1{y = x}] must be the solid angle of x *now*, for every x that the pixel sees and
that shines now: to rounding, without statistics.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from restir_gi.reference.numerics.records import take
from restir_gi.reference.options.motion import (
    EarlierPixels,
    EarlierReservoirs,
    TemporalShift,
)
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.passes.pixels import FrameReservoirs, History, sees
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.resampling.suffix import Suffix
from restir_gi.reference.resampling.target import target
from restir_gi.reference.restir_gi import PassInput, resampled
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.scene.motion import Motion
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.settings import Settings
from tests.exact.test_passes import (
    COLOR,
    NORMAL,
    NOTHING,
    PAINT,
    PIXELS,
    PLACE,
    build,
    receivers,
    side,
)

PAST = 4.0
"""Confidence of what the last frame left."""

MOVES = np.array([True, True, True, False, False, False, False])
"""Cells that belong to the shape that moves: shape 1, the first screen."""

MOVE = pose(25.0, (0.2, 0.1, -0.3))
PLACE_THEN = np.where(MOVES[:, None], (PLACE - MOVE[:3, 3]) @ MOVE[:3, :3], PLACE)
NORMAL_THEN = np.where(MOVES[:, None], NORMAL @ MOVE[:3, :3], NORMAL)

HIDDEN_THEN = [(0, 4), (1, 3), (2, 0)]
LIGHT_NOW = np.array([3.0, 1.0, 2.0, 0.0, 0.5, 4.0, 0.0])
LIGHT_THEN = np.array([1.0, 0.0, 5.0, 2.0, 0.0, 4.0, 0.0])

ROUNDING = 4500 * np.finfo(float).eps
"""A carried point has 40 operations on numbers up to 3 m, at distances of at least
0.9 m: 133 eps.  A Jacobian has three distances and, with cosines above 0.05, 20 for the
angle: 23 · 133 eps, and some 100 for the rest, with a reserve of a half."""


def unlit_in(place, normal):
    """Pixels that are behind the patch of a cell."""
    eyes = build(PAINT, hidden=[], unlit=[]).visible.surface.position
    facing = np.sum((eyes[:, None] - place[:NOTHING]) * normal[:NOTHING], axis=-1)
    return [(int(i), int(x)) for i, x in zip(*np.nonzero(facing < 0), strict=True)]


class Lamp:
    """Stands in for the replay: radiance by cell and world."""

    def __init__(self, after):
        self.after = after

    def radiance(self, world, suffix, active):
        """Radiance of the cells in one of the two frames."""
        light = LIGHT_NOW if world is self.after else LIGHT_THEN
        return np.where(active, light[suffix.number], 0.0)[:, None] * COLOR


def cells(number, place, normal, light):
    """Sample points by number, in one of the two frames."""
    n = len(number)
    zero = np.zeros((n, 3))
    primitive = np.where(MOVES[number], 2, 0).astype(np.int32)
    surface = SurfacePoints(
        place[number], normal[number], None, zero, zero,
        np.zeros(n, np.int32), primitive, np.ones(n, bool),
    )  # fmt: skip
    radiance = light[number][:, None] * COLOR
    return Samples(place[number], normal[number], radiance, Suffix(number, surface))


class TwoFrames:
    """Both frames, and the way between."""

    def __init__(self):
        unlit = unlit_in(PLACE, NORMAL)
        unlit_then = unlit_in(PLACE_THEN, NORMAL_THEN)
        self.now = build(PAINT, unlit=unlit)
        self.then = build(PAINT, PLACE_THEN, NORMAL_THEN, HIDDEN_THEN, unlit_then)
        shapes = len(self.now.world.scene.meshes)
        rotation = np.tile(np.eye(3), (shapes, 1, 1))
        translation = np.zeros((shapes, 3))
        rotation[1], translation[1] = MOVE[:3, :3], MOVE[:3, 3]
        forth = Motion(rotation, translation)
        after = self.now.world
        self.shift = TemporalShift(
            self.then.world, after, forth, forth.reversed, Lamp(after)
        )
        self.holds_then = self.then.holds & (LIGHT_THEN[:NOTHING] > 0)

    def truth(self, i):
        """Solid angles of what pixel i can be lit by, now."""
        lit = self.now.holds[i] & (LIGHT_NOW[:NOTHING] > 0)
        return np.where(lit, self.now.mu[i], 0.0)


@pytest.fixture(scope="module")
def frames():
    return TwoFrames()


def in_pairs(frames, i, j, settings, of_old, of_new):
    """Weights with m for M, straight from theory: one source, the past."""
    now = frames.now
    points = take(now.visible.surface, np.full(NOTHING + 1, i))
    every = np.arange(NOTHING + 1)
    here = cells(every, PLACE, NORMAL, LIGHT_NOW)
    p_c = target(settings.target, now.world.materials, points, here)
    source = take(frames.then.visible.surface, np.full(NOTHING + 1, j))
    there = cells(every, PLACE_THEN, NORMAL_THEN, LIGHT_THEN)
    p_k = target(settings.target, now.world.materials, source, there)
    p_k = p_k * np.append(frames.holds_then[j] * frames.then.mu[j] / now.mu[i], 0.0)
    theirs, mine = PAST * p_k, 1.0 * p_c
    both = theirs + mine
    share = np.divide(theirs, both, out=np.zeros_like(both), where=both > 0)
    a, b = (PAST, 1.0) if settings.mis == "defensive" else (1.0, 0.0)
    m_k, m_c = a * share / (a + b), (a * (1 - share) + b) / (a + b)
    (old, w_old), (new, w_new) = of_old, of_new
    return w_old / PAST * m_k[old], w_new * m_c[new]


def contributions(frames, i, j, settings):
    """E[W 1{y = x}] at pixel i, which goes on from pixel j of the last frame."""
    now, then = frames.now, frames.then
    old_support = [*np.flatnonzero(frames.holds_then[j]), NOTHING]
    new_support = [*np.flatnonzero(now.holds[i]), NOTHING]
    old, new, bit = (
        g.ravel() for g in np.meshgrid(old_support, new_support, (0, 1), indexing="ij")
    )
    n = len(old)
    points = take(now.visible.surface, np.full(n, i))

    p_old, W_old = law(then, j, frames.holds_then, old)
    p_new, W_new = law(now, i, now.holds, new)
    old_now = cells(old, PLACE, NORMAL, LIGHT_NOW)
    p_hat_old = target(settings.target, now.world.materials, points, old_now)
    fresh = cells(new, PLACE, NORMAL, LIGHT_NOW)
    p_hat_new = target(settings.target, now.world.materials, points, fresh)
    # Weights as theory has them.
    mu_now, mu_then = np.append(now.mu[i], 1.0), np.append(then.mu[j], 1.0)
    w_old = p_hat_old * W_old * PAST * mu_now[old] / mu_then[old]
    if settings.visibility == "all":
        everyone = np.ones(n, bool)
        w_old = np.where(sees(now.world, points, old_now, everyone), w_old, 0.0)
    w_new = p_hat_new * W_new
    if settings.mis in ("pairwise", "defensive"):
        w_old, w_new = in_pairs(frames, i, j, settings, (old, w_old), (new, w_new))
    u, chance = side(bit, w_old, w_new)
    probability = p_old * p_new * chance

    pdf = np.divide(1.0, W_new, out=np.zeros(n), where=W_new > 0)
    initial = InitialSamples(fresh, pdf, np.ones(n), np.zeros((n, 3)))
    stored = Reservoirs(
        cells(old, PLACE_THEN, NORMAL_THEN, LIGHT_THEN), W_old, np.full(n, PAST)
    )
    q = receivers(now.world, take(now.visible, np.full(n, i)), settings)
    past = goes_on_from(frames, j, stored, q)
    given = PassInput(q, past, initial, u, [])
    kept = resampled(given, settings, settings.temporal_cap)
    assert_allclose(probability.sum(), 1, rtol=1e-13)
    assert (kept.M == PAST + 1).all()
    found = [
        np.sum((probability * kept.W)[kept.y.suffix.number == x])
        for x in range(NOTHING)
    ]
    return np.array(found)


def goes_on_from(frames, j, stored, q):
    """Pixel j of the last frame, as the past of q."""
    visible = take(frames.then.visible, np.full(len(stored.W), j))
    last = EarlierReservoirs(frames.then.world, visible, stored, frames.shift)
    return History(last, last, shifted=True).of(last, q, np.arange(len(stored.W)))


def law(stage, i, holds, cell):
    """Probability that pixel i of a frame draws cells, and their W."""
    p = np.append(np.where(holds[i], stage.chance[i], 0.0), 0.0)
    p[NOTHING] = 1 - p.sum()
    measure = np.append(stage.mu[i], 0.0)
    return p[cell], np.divide(measure[cell], p[cell])


def stream_contributions(frames, i, j, k, settings):
    """The same after a stream of the past, the pixel's own, and a neighbour's k."""
    now, then = frames.now, frames.then
    supports = [frames.holds_then[j], now.holds[i], now.holds[k]]
    cells_of = [[*np.flatnonzero(s), NOTHING] for s in supports]
    past, own, theirs, first, second = (
        g.ravel() for g in np.meshgrid(*cells_of, (0, 1), (0, 1), indexing="ij")
    )
    n = len(past)
    points = take(now.visible.surface, np.full(n, i))
    p_past, W_past = law(then, j, frames.holds_then, past)
    p_own, W_own = law(now, i, now.holds, own)
    p_theirs, W_theirs = law(now, k, now.holds, theirs)
    mu, mu_past, mu_theirs = (
        np.append(m, 1.0) for m in (now.mu[i], then.mu[j], now.mu[k])
    )

    def weight(cell, W, M, ratio):
        y = cells(cell, PLACE, NORMAL, LIGHT_NOW)
        w = target(settings.target, now.world.materials, points, y) * W * M * ratio
        if settings.visibility == "all":
            w = np.where(sees(now.world, points, y, np.ones(n, bool)), w, 0.0)
        return w

    w = [
        weight(past, W_past, PAST, mu[past] / mu_past[past]),
        weight(own, W_own, 1.0, 1.0),
        weight(theirs, W_theirs, 2.0, mu[theirs] / mu_theirs[theirs]),
    ]
    u_own, chance_own = side(first, w[0], w[1])
    u_theirs, chance_theirs = side(second, w[0] + w[1], w[2])
    probability = p_past * p_own * p_theirs * chance_own * chance_theirs

    every = np.arange(n)
    q = receivers(now.world, take(now.visible, np.full(n, i)), settings)
    stored = Reservoirs(
        cells(past, PLACE_THEN, NORMAL_THEN, LIGHT_THEN), W_past, np.full(n, PAST)
    )
    mine = Reservoirs(cells(own, PLACE, NORMAL, LIGHT_NOW), W_own, np.ones(n))
    lent = Reservoirs(
        cells(theirs, PLACE, NORMAL, LIGHT_NOW), W_theirs, np.full(n, 2.0)
    )
    around = FrameReservoirs(now.world, take(now.visible, np.full(n, k)), lent)
    neighbors = [(around.neighbors(q, every), u_theirs)]
    given = PassInput(q, goes_on_from(frames, j, stored, q), mine, u_own, neighbors)
    kept = resampled(given, settings, 1e9)
    assert_allclose(probability.sum(), 1, rtol=1e-13)
    number = kept.y.suffix.number
    return np.array(
        [np.sum((probability * kept.W)[number == x]) for x in range(NOTHING)]
    )


@pytest.mark.parametrize("kind", ["scattered", "outgoing"])
@pytest.mark.parametrize("mis", ["1/Z", "balance"])
@pytest.mark.parametrize("visibility", ["all", "chosen"])
def test_a_stream_of_past_own_and_neighbour_is_unbiased(frames, kind, mis, visibility):
    """As in the spatial pass: samples of the neighbour are asked of the last frame."""
    settings = Settings(target=kind, mis=mis, visibility=visibility)
    for i, j, k in np.ndindex(PIXELS, PIXELS, PIXELS):
        if k != i:
            found = stream_contributions(frames, i, j, k, settings)
            assert_allclose(found, frames.truth(i), rtol=ROUNDING, atol=0)


def is_true(frames, settings):
    """Whether it holds for every pixel and every pixel it may go on from."""
    return all(
        np.allclose(
            contributions(frames, i, j, settings), frames.truth(i), ROUNDING, atol=0
        )
        for i in range(PIXELS)
        for j in range(PIXELS)
    )


def test_the_two_frames_differ_in_all_respects(frames):
    """Each kind of cell is there: lost, gained, dimmed, and both seen and moved."""
    now = np.array([frames.truth(i) > 0 for i in range(PIXELS)])
    assert (now & ~frames.holds_then).any()
    assert (frames.holds_then & ~now).any()
    assert (now & frames.holds_then & MOVES[:NOTHING]).any()
    assert (now & frames.holds_then & ~MOVES[:NOTHING]).any()


@pytest.mark.parametrize("kind", ["scattered", "outgoing"])
@pytest.mark.parametrize("mis", ["1/Z", "balance", "pairwise", "defensive"])
@pytest.mark.parametrize("visibility", ["all", "chosen"])
def test_the_temporal_pass_is_unbiased_across_the_change(frames, kind, mis, visibility):
    settings = Settings(target=kind, mis=mis, visibility=visibility)
    assert is_true(frames, settings)


def test_1_over_m_is_biased_across_the_change(frames):
    assert not is_true(frames, Settings(mis="1/M"))


def unmoved(shift, y, x):
    return x


def as_it_is_now(shift, y, active):
    return y


def only_led_back(shift, y, active, backward=TemporalShift.backward):
    """Position and normal of then, radiance of now."""
    return replace(backward(shift, y, active), radiance=y.radiance)


PLANTED = {
    "the Jacobian forgets that the sample moved": ("points_forward", unmoved),
    "Z is asked of this frame": ("backward", as_it_is_now),
    "Z is asked with the light of now": ("backward", only_led_back),
    "samples stay behind": ("forward", as_it_is_now),
}


@pytest.mark.parametrize("name", PLANTED)
def test_control_planted_mistakes_are_refuted(frames, monkeypatch, name):
    function, wrong = PLANTED[name]
    assert is_true(frames, Settings())
    monkeypatch.setattr(TemporalShift, function, wrong)
    assert not is_true(frames, Settings())


def test_control_visibility_of_now_in_the_weights_is_refuted(frames, monkeypatch):
    """Whoever asks this frame whether the last one saw the sample is found out."""

    def of_now(q_n, y, asked):
        y, _ = q_n.before(y, asked)
        return sees(frames.now.world, q_n.x, y, asked & q_n.supports(y))

    monkeypatch.setattr(EarlierPixels, "could_make", of_now)
    assert not is_true(frames, Settings())
