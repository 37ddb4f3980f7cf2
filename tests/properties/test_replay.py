"""Radiance found again, Russian roulette of the tail, and reservoirs from memory.

Evidence: properties.  Two routes to one number: the path as it was drawn, and the path
as its number says; equal to the last bit.
"""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.options.replay import replay_of
from restir_gi.reference.options.storage import stored, stored_bytes
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.passes.initial import initial_samples
from restir_gi.reference.resampling.packing.paper import pack, unpack
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.resampling.suffix import age
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.path_tracer import reflected_radiance
from restir_gi.reference.transport.world import build_world

WIDTH, HEIGHT = 80, 40
"""Two tiles of the roulette, the second cut off."""


def frame_of(name="cornell-box", number=5, bounces=3, **settings):
    scene = find_scene(name)
    camera = replace(scene.camera, width=WIDTH, height=HEIGHT)
    world = build_world(replace(scene, camera=camera))
    visible = visible_points(world, *pixel_centers(WIDTH, HEIGHT))
    return FrameContext(
        number=number,
        world=world,
        visible=visible,
        settings=replace(UNBIASED, **settings),
        bounces=bounces,
        seed=11,
        schedule=Schedule(),
        changes="scene",
    )


def drawn(frame):
    """Initial samples of the whole frame."""
    r = slice(0, frame.pixels)
    numbers, replay = frame.numbers(r), replay_of(frame)
    return initial_samples(
        frame.world,
        frame.visible.surface,
        "uniform",
        "as-lambertian",
        frame.bounces,
        directions=frame.uniforms(Stream.INITIAL, r),
        paths=frame.uniforms(Stream.PATH, r),
        speculars=frame.uniforms(Stream.SPECULAR, r),
        numbers=numbers,
        tail=replay.tail(numbers) if replay.tail else None,
    )


@pytest.mark.parametrize("name", ["cornell-box", "glossy-floor", "many-lights"])
@pytest.mark.parametrize("roulette", [1.0, 0.5])
def test_radiance_is_found_again_to_the_last_bit(name, roulette):
    """In any order, some rows alone, and long after."""
    frame = frame_of(name, roulette=roulette)
    y = drawn(frame).y
    shines = y.radiance.any(axis=1)
    assert shines.mean() > 0.2
    order = np.random.default_rng(0).permutation(frame.pixels)[:777]
    later = replace(frame, number=900)
    some, active = take(y.suffix, order), shines[order]
    again = replay_of(later).radiance(frame.world, some, active)
    assert np.array_equal(again[active], y.radiance[order][active])
    assert not again[~active].any()


def test_control_another_number_is_another_path():
    frame = frame_of()
    y = drawn(frame).y
    other = replace(y.suffix, number=y.suffix.number + frame.pixels)
    everyone = np.ones(frame.pixels, bool)
    again = replay_of(frame).radiance(frame.world, other, everyone)
    shines = y.radiance.any(axis=1)
    assert (again != y.radiance)[shines].any(axis=1).mean() > 0.9


def heads_and_wholes(frame, weight):
    """Radiance of sample points: first bounce, all, and all with the tail weighted."""
    met = drawn(frame).y.suffix.surface
    pixel = np.arange(frame.pixels, dtype=np.uint32)
    u = KeyedUniforms(pixel, 3, 11, Stream.PATH)
    world, bounces = frame.world, frame.bounces - 1
    head = reflected_radiance(world, met, 0, u)
    whole = reflected_radiance(world, met, bounces, u)
    weighted = reflected_radiance(world, met, bounces, u, tail=weight)
    return head, whole, weighted


@pytest.mark.parametrize("probability", [0.25, 0.5])
def test_only_the_tail_is_reweighted(probability):
    """Head + tail / p where the path goes on, the head alone where it ends.

    1/p is a power of two, so that the products are exact; sums of three terms of one
    sign, in another order, differ by at most 2 eps of the sum, of which up to 1/p may
    have cancelled in ``whole - head``.
    """
    frame = frame_of()
    lives = np.random.default_rng(1).random(frame.pixels) < probability
    weight = np.where(lives, 1.0 / probability, 0.0)
    head, whole, weighted = heads_and_wholes(frame, weight)
    expected = head + weight[:, None] * (whole - head)
    bound = 4 / probability * np.finfo(float).eps * (whole / probability + head)
    assert (np.abs(weighted - expected) <= bound).all()
    assert np.array_equal(weighted[~lives], head[~lives])
    # Chance hits of a light belong to the first bounce, which a dead path keeps.
    assert (whole > head)[lives].any()


def test_control_all_reweighted_is_not_that():
    frame = frame_of()
    weight = np.full(frame.pixels, 4.0)
    _, whole, weighted = heads_and_wholes(frame, weight)
    assert np.abs(weighted - 4 * whole).max() > 0.1 * whole.max()


def test_roulette_follows_the_frame_in_which_the_path_was_drawn():
    """One weight a tile and frame: 0, or 1 over the probability."""
    frame = frame_of(roulette=0.25)
    frames = np.arange(400)
    numbers = frames[:, None] * frame.pixels + np.arange(frame.pixels)
    weight = replay_of(frame).tail(numbers.ravel()).reshape(400, HEIGHT, WIDTH)
    for tile in (weight[:, :32, :64], weight[:, :32, 64:], weight[:, 32:, :64]):
        assert (tile == tile[:, :1, :1]).all()
    assert set(np.unique(weight)) == {0.0, 4.0}
    # Tiles are independent: no two are alike in all of 400 frames, probability 1e-81.
    assert (weight[:, 0, 0] != weight[:, 0, 64]).any()


def test_a_sample_ages_a_frame_a_frame():
    frame = frame_of(number=5)
    suffix = drawn(frame).y.suffix
    for number in (5, 6, 35):
        assert (age(suffix, number, frame.pixels) == number - 5).all()


@pytest.mark.parametrize(
    ("storage", "eps", "most", "least"),
    [
        ("float32", 2.0**-24, float(np.finfo(np.float32).max), 2.0**-126),
        # Half has 11 bits, down to 2^-14; what is smaller is rounded to 2^-25 at most.
        ("half", 2.0**-11, 65504.0, 2.0**-14),
    ],
)
def test_reservoirs_are_rounded_and_never_infinite(storage, eps, most, least):
    frame = frame_of(storage=storage)
    y = drawn(frame).y
    count = frame.pixels
    rng = np.random.default_rng(3)
    radiance = 2.0 ** rng.uniform(-30, 200, (count, 3))
    y = replace(y, radiance=radiance)
    r = Reservoirs(y, rng.random(count), np.ceil(30 * rng.random(count)))
    back = stored(storage, frame.visible.surface, r, count)
    for name in ("position", "normal", "radiance"):
        exact, found = getattr(r.y, name), getattr(back.y, name)
        assert found.dtype == np.float64
        within = np.minimum(exact, most) if name == "radiance" else exact
        # Half a unit in the last place; below the normal numbers it is a fixed one.
        error = abs(found - within)
        assert (error <= eps * np.maximum(abs(within), least)).all()
    assert back.y.radiance.max() <= most
    assert np.array_equal(back.M, r.M)
    assert back.y.suffix is y.suffix
    # Coming back twice changes nothing.
    again = stored(storage, frame.visible.surface, back, count)
    assert np.array_equal(again.W, back.W)


def test_bytes_of_reservoirs():
    """Three vectors and two numbers; what finds the path again comes on top."""
    frame = frame_of()
    y = drawn(frame).y
    r = Reservoirs(y, np.ones(frame.pixels), np.ones(frame.pixels))
    suffix = stored_bytes("paper", r) - 48 * frame.pixels
    for storage, size in (("float64", 88), ("float32", 44), ("half", 22)):
        assert stored_bytes(storage, r) == size * frame.pixels + suffix
    bare = replace(r, y=replace(y, suffix=None))
    assert stored_bytes("paper", bare) == 48 * frame.pixels


def test_reservoirs_come_back_from_48_bytes_as_they_were_packed():
    frame = frame_of(storage="paper")
    y = drawn(frame).y
    points = frame.visible.surface
    rng = np.random.default_rng(2)
    r = Reservoirs(y, rng.random(frame.pixels), np.ceil(30 * rng.random(frame.pixels)))
    assert stored("float64", points, r, frame.pixels) is r
    back = stored("paper", points, r, frame.pixels)
    seed = (y.suffix.number % (2**32 // frame.pixels * frame.pixels)).astype(np.uint32)
    codes = pack(points.position, points.normal, r, seed)
    _, _, expected, seeds = unpack(codes)
    for name in ("position", "normal", "radiance"):
        assert np.array_equal(getattr(back.y, name), getattr(expected.y, name))
    assert np.array_equal(back.W, expected.W)
    assert np.array_equal(back.M, r.M)
    assert back.y.suffix is y.suffix
    # The seed tells the path, to whoever knows the frame to within 2^32 / pixels.
    now = 8 * frame.pixels
    period = 2**32 // frame.pixels * frame.pixels
    assert np.array_equal(
        now - (now - seeds.astype(np.int64)) % period, y.suffix.number
    )
