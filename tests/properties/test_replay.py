"""Radiance found again, Russian roulette of the tail, and reservoirs from memory.

Evidence: properties.  Two routes to one number: the path as it was drawn, and the path
as its number says; equal to the last bit.
"""

from dataclasses import replace

import numpy as np
import pytest
from reference.passes.moment import Moment

from reference.options.storage import stored, stored_bytes
from reference.passes.gbuffer import visible_points
from reference.passes.initial import initial_samples
from reference.path_tracer import reflected_radiance
from reference.records import take
from reference.resampling.packing.paper import pack, unpack
from reference.resampling.reservoir import Reservoirs
from reference.resampling.suffix import age
from reference.rng import KeyedUniforms, Stream
from reference.scene.camera import pixel_centers
from reference.scene.catalogue.registry import find_scene
from reference.schedule import Schedule
from reference.settings import UNBIASED
from reference.world import build_world

WIDTH, HEIGHT = 80, 40
"""Two tiles of the roulette, the second cut off."""


def moment_of(name="cornell-box", number=5, bounces=3, **settings):
    scene = find_scene(name)
    camera = replace(scene.camera, width=WIDTH, height=HEIGHT)
    world = build_world(replace(scene, camera=camera))
    visible = visible_points(world, *pixel_centers(WIDTH, HEIGHT))
    return Moment(
        number,
        world,
        visible,
        replace(UNBIASED, **settings),
        bounces,
        11,
        Schedule(),
        "scene",
    )


def drawn(moment):
    """Initial samples of the whole frame."""
    r = slice(0, moment.pixels)
    numbers, replay = moment.numbers(r), moment.replay
    return initial_samples(
        moment.world,
        moment.visible.surface,
        "uniform",
        "as-lambertian",
        moment.bounces,
        moment.uniforms(Stream.INITIAL, r),
        moment.uniforms(Stream.PATH, r),
        moment.uniforms(Stream.SPECULAR, r),
        numbers,
        replay.tail(numbers) if replay.tail else None,
    )


@pytest.mark.parametrize("name", ["cornell-box", "glossy-floor", "many-lights"])
@pytest.mark.parametrize("roulette", [1.0, 0.5])
def test_radiance_is_found_again_to_the_last_bit(name, roulette):
    """In any order, some rows alone, and long after."""
    moment = moment_of(name, roulette=roulette)
    y = drawn(moment).y
    shines = y.radiance.any(axis=1)
    assert shines.mean() > 0.2
    order = np.random.default_rng(0).permutation(moment.pixels)[:777]
    later = replace(moment, number=900)
    some, active = take(y.suffix, order), shines[order]
    again = later.replay.radiance(moment.world, some, active)
    assert np.array_equal(again[active], y.radiance[order][active])
    assert not again[~active].any()


def test_control_another_number_is_another_path():
    moment = moment_of()
    y = drawn(moment).y
    other = replace(y.suffix, number=y.suffix.number + moment.pixels)
    everyone = np.ones(moment.pixels, bool)
    again = moment.replay.radiance(moment.world, other, everyone)
    shines = y.radiance.any(axis=1)
    assert (again != y.radiance)[shines].any(axis=1).mean() > 0.9


def heads_and_wholes(moment, weight):
    """Radiance of sample points: first bounce, all, and all with the tail weighted."""
    met = drawn(moment).y.suffix.surface
    pixel = np.arange(moment.pixels, dtype=np.uint32)
    u = KeyedUniforms(pixel, 3, 11, Stream.PATH)
    world, bounces = moment.world, moment.bounces - 1
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
    moment = moment_of()
    lives = np.random.default_rng(1).random(moment.pixels) < probability
    weight = np.where(lives, 1.0 / probability, 0.0)
    head, whole, weighted = heads_and_wholes(moment, weight)
    expected = head + weight[:, None] * (whole - head)
    bound = 4 / probability * np.finfo(float).eps * (whole / probability + head)
    assert (np.abs(weighted - expected) <= bound).all()
    assert np.array_equal(weighted[~lives], head[~lives])
    # Chance hits of a light belong to the first bounce, which a dead path keeps.
    assert (whole > head)[lives].any()


def test_control_all_reweighted_is_not_that():
    moment = moment_of()
    weight = np.full(moment.pixels, 4.0)
    _, whole, weighted = heads_and_wholes(moment, weight)
    assert np.abs(weighted - 4 * whole).max() > 0.1 * whole.max()


def test_roulette_follows_the_frame_in_which_the_path_was_drawn():
    """One weight a tile and frame: 0, or 1 over the probability."""
    moment = moment_of(roulette=0.25)
    frames = np.arange(400)
    numbers = frames[:, None] * moment.pixels + np.arange(moment.pixels)
    weight = moment.replay.tail(numbers.ravel()).reshape(400, HEIGHT, WIDTH)
    for tile in (weight[:, :32, :64], weight[:, :32, 64:], weight[:, 32:, :64]):
        assert (tile == tile[:, :1, :1]).all()
    assert set(np.unique(weight)) == {0.0, 4.0}
    # Tiles are independent: no two are alike in all of 400 frames, probability 1e-81.
    assert (weight[:, 0, 0] != weight[:, 0, 64]).any()


def test_a_sample_ages_a_frame_a_frame():
    moment = moment_of(number=5)
    suffix = drawn(moment).y.suffix
    for frame in (5, 6, 35):
        assert (age(suffix, frame, moment.pixels) == frame - 5).all()


@pytest.mark.parametrize(
    ("storage", "eps", "most", "least"),
    [
        ("float32", 2.0**-24, float(np.finfo(np.float32).max), 2.0**-126),
        # Half has 11 bits, down to 2^-14; what is smaller is rounded to 2^-25 at most.
        ("half", 2.0**-11, 65504.0, 2.0**-14),
    ],
)
def test_reservoirs_are_rounded_and_never_infinite(storage, eps, most, least):
    moment = moment_of(storage=storage)
    y = drawn(moment).y
    count = moment.pixels
    rng = np.random.default_rng(3)
    radiance = 2.0 ** rng.uniform(-30, 200, (count, 3))
    y = replace(y, radiance=radiance)
    r = Reservoirs(y, rng.random(count), np.ceil(30 * rng.random(count)))
    back = stored(storage, moment.visible.surface, r, count)
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
    again = stored(storage, moment.visible.surface, back, count)
    assert np.array_equal(again.W, back.W)


def test_bytes_of_reservoirs():
    """Three vectors and two numbers; what finds the path again comes on top."""
    moment = moment_of()
    y = drawn(moment).y
    r = Reservoirs(y, np.ones(moment.pixels), np.ones(moment.pixels))
    suffix = stored_bytes("paper", r) - 48 * moment.pixels
    for storage, size in (("float64", 88), ("float32", 44), ("half", 22)):
        assert stored_bytes(storage, r) == size * moment.pixels + suffix
    bare = replace(r, y=replace(y, suffix=None))
    assert stored_bytes("paper", bare) == 48 * moment.pixels


def test_reservoirs_come_back_from_48_bytes_as_they_were_packed():
    moment = moment_of(storage="paper")
    y = drawn(moment).y
    points = moment.visible.surface
    rng = np.random.default_rng(2)
    r = Reservoirs(
        y, rng.random(moment.pixels), np.ceil(30 * rng.random(moment.pixels))
    )
    assert stored("float64", points, r, moment.pixels) is r
    back = stored("paper", points, r, moment.pixels)
    seed = (y.suffix.number % (2**32 // moment.pixels * moment.pixels)).astype(
        np.uint32
    )
    codes = pack(points.position, points.normal, r, seed)
    _, _, expected, seeds = unpack(codes)
    for name in ("position", "normal", "radiance"):
        assert np.array_equal(getattr(back.y, name), getattr(expected.y, name))
    assert np.array_equal(back.W, expected.W)
    assert np.array_equal(back.M, r.M)
    assert back.y.suffix is y.suffix
    # The seed tells the path, to whoever knows the frame to within 2^32 / pixels.
    now = 8 * moment.pixels
    period = 2**32 // moment.pixels * moment.pixels
    assert np.array_equal(
        now - (now - seeds.astype(np.int64)) % period, y.suffix.number
    )
