"""Figures of the gradient domain: what runs by turns leave behind, and its errors."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np
import pytest

from restir_gi.figures.gradient_domain.gradients import times_smaller
from restir_gi.figures.gradient_domain.rounds import (
    FRAMES,
    Rounds,
    RoundScene,
    Variant,
    by_rounds,
)
from restir_gi.figures.gradient_domain.scores import (
    gradient_errors,
    gradient_flips,
    gradient_picture,
    image_errors,
    image_flips,
    relative_gradient_errors,
)
from restir_gi.figures.gradient_domain.toy import VARIANTS, functions, toy
from restir_gi.figures.gradient_domain.variants import METHODS, PRIMAL, scene_of
from restir_gi.gradient_domain.reconstruction import differences
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports import timing
from restir_gi.reference.reports.figures.record import Work

SMALL = Work(16, 3, Schedule())


@dataclass
class StubFrame:
    """A frame that knows from where it is."""

    estimates: object


def made_of(seeds, clock=None, seconds=0.0):
    """A method whose frame n of seed s is 100 s + n everywhere."""

    def render(
        world, settings, bounces, seed, schedule, animation
    ) -> Iterator[StubFrame]:
        seeds.append(seed)
        for frame in count():
            if clock:
                clock.append(clock[-1] + seconds)
            yield StubFrame(np.full((256, 9), 100.0 * seed + frame))

    return Variant(render, None)


def test_copies_have_seeds_of_their_own_and_are_averaged(monkeypatch):
    """Of two methods one takes a third of the other's time: three copies of it."""
    clock = [0.0]
    monkeypatch.setattr(timing.time, "perf_counter", lambda: clock[-1])
    fast, slow = [], []
    variants = {"fast": made_of(fast, clock, 1.0), "slow": made_of(slow, clock, 3.1)}
    found = by_rounds(scene_of("cornell-box", 16), variants, SMALL, 2, like="slow")
    assert found.copies == {"fast": 3, "slow": 1}
    # The first of each is the trial by which the times are measured.
    assert fast[1:] == list(range(9))
    assert slow[1:] == list(range(3))
    for run in range(3):
        last = FRAMES - 1
        expected = 100.0 * np.mean(range(3 * run, 3 * run + 3)) + last
        np.testing.assert_allclose(found.estimates["fast"][run], expected)
        np.testing.assert_allclose(found.estimates["slow"][run], 100.0 * run + last)
    assert found.seconds["slow"] == pytest.approx(3.1)
    assert found.spent("fast") == pytest.approx(3.0)
    assert found.truth.count == 6


def test_without_a_model_there_is_one_copy_each():
    seeds = []
    found = by_rounds(
        scene_of("cornell-box", 16), {"one": made_of(seeds)}, SMALL, 1, like=""
    )
    assert seeds == [0, 1, 2]
    assert found.copies == {"one": 1}


def test_only_a_camera_may_move():
    """Its last frame is what is looked at; other scenes stand still."""
    still, moving = scene_of("moving-block", 16), scene_of("moving-camera", 16)
    assert still.animation is None
    assert still.shown is still.world
    assert moving.shown.camera.position != moving.world.camera.position
    assert moving.shown.camera.width == 16


@pytest.mark.parametrize("variant", [*METHODS.values(), PRIMAL])
def test_variants_have_pixels_and_differences(variant):
    scene = scene_of("moving-camera", 16)
    frame = next(variant.frames(scene, 0, Schedule()))
    assert frame.estimates.shape == (256, 9)


# ------------------------------------------------------------ errors


def some(seed=0, size=8):
    return np.random.default_rng(seed).random((size * size, 3))


def estimates_of(image, size=8):
    d = differences(image, size)
    return np.concatenate([image, d.x, d.y], axis=1)


def known(image):
    """A truth without noise."""
    return Moments(4, image, np.zeros_like(image))


def test_errors_of_the_truth_are_none():
    image = some()
    assert image_errors([image], known(image)) == (0.0, 0.0)
    assert image_flips([image], known(image), 8) == 0.0
    assert gradient_flips([estimates_of(image)], known(image), 8) == 0.0
    worse = image + 0.2 * some(1)
    assert image_errors([worse], known(image))[0] > 0
    assert image_flips([worse], known(image), 8) > 0
    assert gradient_flips([estimates_of(worse)], known(image), 8) > 0


def test_errors_of_differences_are_those_that_are_asked_for():
    """Pixels do not count, and of differences those of the mask."""
    a = np.zeros((64, 9))
    b, pixels = a.copy(), np.zeros((64, 2), bool)
    b[:, :3] = 7.0
    assert not gradient_errors([a, b, a]).any()
    b[5, 3:6] = 2.0  # to the right of pixel 5
    b[9, 6:9] = 4.0  # below pixel 9
    pixels[5, 0] = True
    right = gradient_errors([a, b], pixels)
    np.testing.assert_allclose(right, 2.0)  # 2² / 2
    pixels[:] = False
    pixels[9, 1] = True
    np.testing.assert_allclose(gradient_errors([a, b], pixels), 8.0)


def test_relative_errors_of_differences_are_those_of_the_light_of_the_pair():
    """An image ten times as bright, ten times as noisy: the same error, but for ε."""
    image = 1e3 * (1 + some())
    runs = [estimates_of(image * (1 + 0.1 * some(seed))) for seed in (1, 2)]
    brighter = [10 * run for run in runs]
    found = relative_gradient_errors(runs, known(image), 8)
    # ε = 0.01 beside squares of 1e6 or more: 1e-8 of the error.
    np.testing.assert_allclose(
        relative_gradient_errors(brighter, known(10 * image), 8), found, rtol=2e-8
    )
    # One difference wrong by 6, between pixels of 1 and 3: 6² / 2² / 2 of 384 numbers.
    pair = np.repeat([[1.0, 3.0] * 32], 3, axis=0).T.copy()
    right, wrong = estimates_of(pair), estimates_of(pair)
    wrong[0, 3] += 6.0
    found = relative_gradient_errors([right, wrong], known(pair), 8)
    np.testing.assert_allclose(found, 36 / 4.01 / 2 / 384)


def test_a_picture_of_differences_is_grey_where_there_is_none():
    image = np.repeat(np.arange(8.0)[None], 8, axis=0).reshape(-1, 1) * np.ones(3)
    picture = gradient_picture(differences(image, 8), known(image), 8)
    assert (picture[:, -1] == 128).all()
    assert (picture[:, :-1] == 255).all()
    dark = gradient_picture(differences(-image, 8), known(image), 8)
    assert (dark[:, :-1] == 0).all()


def test_time_is_a_part_of_the_comparison():
    """Twice the error in a quarter of the time is half of it in the same."""
    rng = np.random.default_rng(3)
    noise = [rng.normal(size=(64, 9)) for _ in range(400)]
    found = Rounds(
        RoundScene("x", None, 1),
        {"a": noise[:200], "b": [np.sqrt(2.0) * n for n in noise[200:]]},
        {"a": 1, "b": 1},
        {"a": 4.0, "b": 1.0},
        None,
    )
    # Of 200 runs of 384 numbers each the mean square is known to 0.5 %.
    assert times_smaller(found, "b", "a", same_time=False).value == pytest.approx(
        0.5, rel=0.05
    )
    assert times_smaller(found, "b", "a", same_time=True).value == pytest.approx(
        2.0, rel=0.05
    )


# ------------------------------------------------------------ the toy


@pytest.mark.parametrize("name", VARIANTS)
def test_the_toy_is_unbiased(name):
    """Within 5 standard errors: it fails with probability 6e-7."""
    grid = np.linspace(-2, 2, 4001)
    f = functions(grid)
    truth = np.trapezoid(f[0] - f[1], grid)
    rng = np.random.default_rng(1)
    x, u = rng.uniform(-2, 2, (2, 16, 20000)), rng.random((2, 16, 20000))
    _, found = VARIANTS[name](x, u)
    assert abs(found.mean() - truth) < 5 * found.std(ddof=1) / np.sqrt(len(found))


def test_the_toy_prefers_what_differs():
    """By at least five times; with a reservoir for each sign by far more."""
    rows = {row["variant"]: row for row in toy(Work(16, 16, Schedule())).rows}
    assert rows["with ReSTIR, one reservoir"]["times smaller"].low > 5
    assert rows["with ReSTIR, one a sign"]["times smaller"].low > 5
    rng = np.random.default_rng(2)
    x, u = rng.uniform(-2, 2, (2, 16, 4000)), rng.random((2, 16, 4000))
    shares = {}
    for name, make in VARIANTS.items():
        kept, _ = make(x, u)
        shares[name] = np.mean(np.abs(kept) > 0.9)
    assert shares["after ReSTIR"] < 0.2
    assert min(v for k, v in shares.items() if k != "after ReSTIR") > 0.9
