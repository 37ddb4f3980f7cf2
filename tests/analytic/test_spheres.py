"""Inside a sphere, where ReSTIR GI has no noise: the furnace, and the half-lit sphere.

Each chord of length d between two points of a sphere of radius R meets both normals at
cos θ = d / 2R.  So the Jacobian of a reconnection is a ratio of two distances, and with
p = cos θ / π and p̂ = f it cancels out of every merged weight, which becomes ρ L M.  The
furnace (L the same everywhere) must therefore come out right in each pixel of each
frame, whatever is reused; and where L is 1 or 0, M times the picture counts ones.

Tolerance.  A chord d is known to 2⁻⁵³ R, its cosine and any ratio of chords to
2⁻⁵³ R / d; some 16 such ratios meet in a weight.  A random chord is shorter than δ with
probability (δ / 2R)², so that among 10⁵ the shortest is about R / 150, and
16 · 150 · 2⁻⁵³ = 3e-13.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.stats import binom

from restir_gi.reference.passes import pixels, temporal
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.scene.catalogue.answers import half_lit_sphere, sphere_furnace
from restir_gi.reference.scene.catalogue.registry import find_scene
from tests.analytic.rendering import frames_of, path_traced, what_is_seen, world_of

ROUNDING = 1e-12

MIS = ("1/M", "1/Z", "balance", "pairwise", "defensive")
IN_WHOLE_NUMBERS = MIS[:-1]
"""Weights that count each sample alike on a sphere: all but the defensive ones."""

VISIBILITY = ("all", "chosen", "none")
CAPS = (1.0, 8.0, 30.0, 500.0, np.inf)
REUSE = ((True, True), (True, False), (False, True), (False, False))
RADII = (
    {"radius": 0.0, "min_radius": 1.0},
    # Whoever is met is taken, so that Jacobians are far from 1.
    {"radius": 0.7, "min_radius": 3.0, "max_angle": 180.0, "max_depth": 1.0},
)


def settings(mis, visibility, cap, reuse, radius):
    """Settings under which a sphere has no noise."""
    return {
        "source": "cosine",
        "target": "scattered",
        "mis": mis,
        "visibility": visibility,
        "temporal_cap": cap,
        "spatial_cap": cap,
        "temporal": reuse[0],
        "spatial": reuse[1],
        **radius,
    }


@pytest.fixture(scope="module")
def furnace():
    return world_of(find_scene("sphere-furnace"), 12)


@pytest.fixture(scope="module")
def half_lit():
    return world_of(find_scene("half-lit-sphere"), 12)


def error(color, answer):
    """Largest relative deviation of any pixel."""
    return np.abs(color / answer - 1.0).max()


# ---------------------------------------------------------------- the furnace


@pytest.mark.parametrize("bounces", range(5))
@pytest.mark.parametrize("light", ["direct", "indirect", "full"])
def test_path_tracer_shows_the_furnace_without_noise(furnace, light, bounces):
    """Both techniques have one density here, d / 2πR: MIS adds no noise."""
    answers = dict(
        zip(("direct", "indirect", "full"), sphere_furnace(bounces), strict=True)
    )
    color = path_traced(furnace, light, bounces, samples=1, seed=bounces)
    if answers[light] == 0:
        assert not color.any()
    else:
        assert error(color, answers[light]) < ROUNDING


def test_each_bounce_of_the_furnace_adds_its_term(furnace):
    """Bounce k + 1 less bounce k is e ρ^(k+2): nothing is lost, nothing comes twice."""
    pictures = [path_traced(furnace, "full", k) for k in range(6)]
    for k in range(5):
        term = sphere_furnace(k + 1)[1] - sphere_furnace(k)[1]
        # Of two pictures of size 4, each right to ROUNDING.
        assert np.abs(pictures[k + 1] - pictures[k] - term).max() < 8 * ROUNDING


@pytest.mark.parametrize("mis", MIS)
@pytest.mark.parametrize("visibility", VISIBILITY)
def test_restir_shows_the_furnace_whatever_is_reused(furnace, mis, visibility):
    for number, choice in enumerate(product(CAPS, REUSE, RADII)):
        frames = frames_of(
            furnace, 4, seed=number, **settings(mis, visibility, *choice)
        )
        for frame in frames:
            assert error(frame.color, sphere_furnace(1)[1]) < ROUNDING, choice


@pytest.mark.parametrize("bounces", [1, 2, 3, 4])
def test_restir_shows_longer_paths_too(furnace, bounces):
    reuse = settings("1/Z", "all", 30.0, (True, True), RADII[1])
    for frame in frames_of(furnace, 3, bounces, seed=5, **reuse):
        assert error(frame.color, sphere_furnace(bounces)[1]) < ROUNDING


MUTANTS = {
    "dropped": lambda *x: np.ones(len(x[0])),
    "inverted": lambda *x: 1.0 / reconnection_jacobian(*x),
    "unsquared": lambda *x: np.cbrt(reconnection_jacobian(*x)),
    "clamped": lambda *x: np.clip(reconnection_jacobian(*x), 1 / 3, 3.0),
}


@pytest.mark.parametrize("mutant", MUTANTS)
def test_control_a_wrong_jacobian_shows_in_the_furnace(furnace, monkeypatch, mutant):
    """By more than a hundredth, where the right one is off by less than 1e-12."""
    monkeypatch.setattr(pixels, "reconnection_jacobian", MUTANTS[mutant])
    reuse = settings("1/Z", "all", 30.0, (True, True), RADII[1])
    frames = frames_of(furnace, 2, seed=5, **reuse)
    assert error(frames[-1].color, sphere_furnace(1)[1]) > 1e-2


@pytest.mark.parametrize("source", ["uniform", "bsdf"])
@pytest.mark.parametrize("target", ["scattered", "outgoing"])
def test_control_other_densities_and_targets_have_noise(furnace, source, target):
    """The identity needs p̂ ∝ p: for Lambertian surfaces the BSDF's is the cosine's."""
    reuse = settings("1/Z", "all", 30.0, (True, True), RADII[1])
    reuse |= {"source": source, "target": target}
    last = frames_of(furnace, 3, seed=5, **reuse)[-1]
    exact = source == "bsdf" and target == "scattered"
    assert (error(last.color, sphere_furnace(1)[1]) < ROUNDING) == exact


# ---------------------------------------------------------------- the half-lit sphere


def ones(color, M):
    """M times the picture in units: the number of samples on the grey half."""
    unit, _ = half_lit_sphere()
    count = np.reshape(M, (-1, 1)) * color / unit
    assert np.array_equal(count[:, 0], count[:, 1])
    assert np.array_equal(count[:, 0], count[:, 2])
    # M up to some hundreds, each within ROUNDING of the picture.
    assert np.abs(count - np.rint(count)).max() <= ROUNDING * np.max(M)
    return np.rint(count[:, 0])


def test_the_camera_of_the_half_lit_sphere_sees_grey_alone(half_lit):
    color = what_is_seen(half_lit).color
    assert (color == color[0, 0]).all()
    assert color[0, 0] > 0


@pytest.mark.parametrize("mis", IN_WHOLE_NUMBERS)
@pytest.mark.parametrize("visibility", VISIBILITY)
def test_restir_counts_samples_in_whole_numbers(half_lit, mis, visibility):
    """Nulls are half of all samples here: leaving them out of M breaks the count."""
    for number, (reuse, radius) in enumerate(product(REUSE, RADII)):
        choice = settings(mis, visibility, np.inf, reuse, radius)
        for frame in frames_of(half_lit, 4, seed=number, **choice):
            M = frame.spatial.M
            count = ones(frame.color, M)
            assert (count >= 0).all()
            assert (count <= M).all()
        # Not trivial: some pixels have merged samples of both kinds.
        if any(reuse):
            assert ((count > 0) & (count < M)).any()


def assert_binomial(count, trials, alarm):
    """Each outcome is as frequent as Binomial(trials, 1/2) says.

    The number of pixels that show j is Binomial(N, P(j)): exact tails, both sides, the
    rate divided among the outcomes and the two sides.
    """
    outcomes = np.arange(trials + 1)
    seen = (count[:, None] == outcomes).sum(axis=0)
    assert seen.sum() == len(count)
    law = binom(len(count), binom.pmf(outcomes, trials, 0.5))
    tail = np.minimum(law.cdf(seen), law.sf(seen - 1))
    assert tail.min() >= alarm / (2 * len(outcomes))


ALARM = 1e-6


def test_samples_of_a_pixel_are_binomial():
    """No sharing between pixels: T frames are T independent trials in each of N pixels.

    False alarms: 1e-6.  A mean off by 5 σ = 5 / (2 √(N T)) = 0.9 % would be found.
    """
    world = world_of(find_scene("half-lit-sphere"), 112)
    reuse = settings("1/Z", "all", np.inf, (True, False), RADII[0])
    frames = frames_of(world, 6, seed=11, **reuse)
    for trials in (1, 2, 6):
        frame = frames[trials - 1]
        assert set(frame.spatial.M) == {trials}
        assert_binomial(ones(frame.color, trials), trials, ALARM / 3)


def test_a_sample_of_a_neighbour_is_as_good_as_ones_own():
    """One neighbour at most, one frame: where M = 2, two trials of two pixels.

    Only pixels 8 apart are looked at, which cannot have met the same neighbour 3 pixels
    away.  False alarms: 1e-6.
    """
    world = world_of(find_scene("half-lit-sphere"), 192)
    reuse = settings("1/Z", "all", np.inf, (False, True), RADII[0])
    reuse |= {"min_radius": 3.0, "iterations_many": 1}
    frame = frames_of(world, 1, seed=12, **reuse)[0]
    x, y = np.arange(192 * 192) % 192, np.arange(192 * 192) // 192
    apart = (x % 8 == 4) & (y % 8 == 4) & (frame.spatial.M == 2)
    assert apart.sum() > 400
    assert_binomial(ones(frame.color[apart], 2), 2, ALARM)


def test_control_skipping_nulls_is_found(monkeypatch):
    """The bug that the furnace cannot see: only what carries light counts in M.

    Then M times the picture is still a whole number, namely M; so the law is asked for
    with the M that there ought to be.
    """

    def without_nulls(y, p_hat, pdf, M):
        new = initial_candidates(y, p_hat, pdf, M)
        return replace(new, M=np.where(new.w > 0, 1.0, 0.0))

    initial_candidates = temporal.initial_candidates
    monkeypatch.setattr(temporal, "initial_candidates", without_nulls)
    world = world_of(find_scene("half-lit-sphere"), 32)
    reuse = settings("1/Z", "all", np.inf, (True, False), RADII[0])
    frame = frames_of(world, 6, seed=11, **reuse)[-1]
    assert np.array_equal(ones(frame.color, frame.spatial.M), frame.spatial.M)
    with pytest.raises(AssertionError):
        assert_binomial(ones(frame.color, 6), 6, ALARM / 3)


def test_control_a_loaded_coin_is_found():
    """47 % instead of 50 %."""
    count = np.random.default_rng(0).binomial(6, 0.47, 112 * 112)
    with pytest.raises(AssertionError):
        assert_binomial(count, 6, ALARM / 3)
