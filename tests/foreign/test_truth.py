"""Each foreign backend is what it is said to be: biased or not, by enumeration."""

import numpy as np
import pytest

from tests.foreign.backends import DECLARED, EXTREMES, FOREIGN, RIGHT, WRONG
from tests.foreign.combined import DEPARTURES, called, composed, sample, sets_of
from tests.foreign.kernels import F
from tests.foreign.mistakes import BlindDomain, NakedAtMost
from tests.foreign.renderer import ForeignRenderer
from tests.foreign.storage import MIXING, ROUNDING
from tests.foreign.truth import TOLERANCE, Enumeration, biases, worst
from tests.foreign.world import (
    BEFORE,
    EYE,
    FACING,
    LEFT,
    LIGHT,
    MIXED,
    PLACE,
    RECEIVER,
    SEES,
    theory,
)
from tests.foreign.world import (
    RIGHT as RIGHT_PIXEL,
)

LEAST = 0.05
"""Relative bias that a mistake must have here, to be one that anybody would see."""

# ---------------------------------------------------------------- the small world


def jacobian(who, x):
    """Exact Jacobian of a shift from a pixel to the receiver."""
    size = theory().size
    return size[RECEIVER, x] / size[who, x]


def test_the_world_goes_everywhere():
    J = np.array([[jacobian(who, x) for x in range(7)] for who in (1, 2, 3)])
    assert J.min() < 0.05
    assert J.max() > 20
    assert (J > 10).any(axis=1).all()
    assert not SEES[RECEIVER].all()
    assert not SEES[LEFT].all()
    assert not SEES[RIGHT_PIXEL].all()
    held, seen = theory().held, SEES
    # Below a horizon or showing their back, though nothing stands between.
    assert (seen & ~held).sum() >= 3
    chance = theory().chance
    assert chance[held].min() > 0.02
    # Black to a pixel that holds it.
    dark = theory().integrand.sum(axis=-1) == 0
    assert (dark & held)[RIGHT_PIXEL].any()


def test_solid_angles_are_what_equation_11_says():
    for who in (LEFT, RIGHT_PIXEL, BEFORE):
        there = [np.tile(EYE[i], (7, 1)).astype(F) for i in (who, RECEIVER)]
        given = (*there, PLACE.astype(F), FACING.astype(F))
        found = ForeignRenderer().jacobian(*given)["jacobian"]
        wanted = [jacobian(who, x) for x in range(7)]
        np.testing.assert_allclose(found, wanted, rtol=3e-5)


def test_control_decisions_are_integrated_to_the_end():
    """A number that is used as its square shifts each threshold, and every mean."""

    class Squared(ForeignRenderer):
        def _accepts(self, u, before, w):
            return super()._accepts(u * u, before, w)

    assert (
        abs(Enumeration(Squared(), "ordinary", "scattered").temporal().relative) > LEAST
    )


# ---------------------------------------------------------------- right ones


def allowed(foreign):
    """Relative bias that is rounding.

    A reservoir that is stored goes through it twice, on its way in and out.
    """
    return TOLERANCE + 2 * foreign.rounding


def name_of(foreign):
    """Name of a test."""
    return foreign.name


@pytest.mark.parametrize("foreign", RIGHT, ids=name_of)
def test_the_right_are_unbiased(foreign):
    where, found = foreign.bias()
    assert abs(found.relative) < allowed(foreign), (where, found)


@pytest.mark.slow
@pytest.mark.parametrize("foreign", RIGHT, ids=name_of)
def test_the_right_are_unbiased_with_nulls_that_stand_nowhere(foreign):
    if "degenerate" in foreign.nulls:
        where, found = foreign.bias("degenerate")
        assert abs(found.relative) < allowed(foreign), (where, found)


@pytest.mark.slow
@pytest.mark.parametrize("foreign", DECLARED, ids=name_of)
def test_the_declared_are_unbiased_where_shading_looks(foreign):
    where, found = foreign.bias()
    assert abs(found.relative) < TOLERANCE, (where, found)
    where, found = worst(biases(foreign.renderer, foreign.passes))
    assert found.relative > LEAST
    assert not SEES[RECEIVER, found.patch]


# ---------------------------------------------------------------- wrong ones

BIASED = [one for one in WRONG if not one.elsewhere]


@pytest.mark.parametrize(
    "foreign",
    [
        pytest.param(one, id=one.name, marks=pytest.mark.slow if row % 4 else ())
        for row, one in enumerate(BIASED)
    ],
)
def test_the_wrong_are_biased(foreign):
    _, found = foreign.bias()
    assert abs(found.relative) > LEAST


def test_every_backend_is_enumerated_or_shown_below():
    elsewhere = {one.name for one in (*EXTREMES, *WRONG) if one.elsewhere}
    assert len(elsewhere) == 5
    assert len({one.name for one in FOREIGN}) == len(FOREIGN)


def of(text):
    """The one foreign backend whose name has this text in it."""
    (found,) = (one for one in FOREIGN if text in one.name)
    return found


def test_at_most_alone_loses_the_reservoir_at_zero():
    assert of("w_sum ≤ w alone").elsewhere.startswith("u = 0")
    numbers = [np.array([x], F) for x in (1, 1, 0, 1, 0)]
    assert NakedAtMost().merge(*numbers)["second"] == 1
    assert ForeignRenderer(accept="<=").merge(*numbers)["second"] == 0


def test_validation_at_random_darkens_by_its_share():
    validation = of("15 %").renderer.validation
    rows = 20_000
    ones, light = np.ones(rows, F), np.ones((rows, 3), F)
    flags = np.ones(rows, np.uint32)
    out = validation(ones, ones, light, light, flags, 0 * flags, 0.1)
    assert (out["M"] == 1).all()
    # A share of 15 in 100 of a sequence that is equidistributed to 1 / 1000.
    assert out["W"].mean() == pytest.approx(0.85, abs=0.005)


def lonely(distance):
    """What `target` is given for two points at a distance."""
    up, white = np.array([[0, 1, 0]], F), np.ones((1, 3), F)
    place = np.array([[0, distance, 0]], F)
    return (0 * up, up, white, place, -up, white)


def test_normalize_first_is_wrong_for_close_points_alone():
    shader, plain = of("normalize() first").renderer, ForeignRenderer()
    for distance, right in ((1e-22, False), (1e-3, True), (1e3, True), (1e22, False)):
        found = shader.target(*lonely(distance), "scattered")["p_hat"]
        wanted = plain.target(*lonely(distance), "scattered")["p_hat"]
        assert wanted == pytest.approx(1 / np.pi)
        assert (found == wanted) == right
    _, found = of("normalize() first").bias()
    assert abs(found.relative) < TOLERANCE


def test_W_overflows_for_extreme_numbers_alone():
    finalize = of("overflows").renderer.finalize
    w, p_hat = np.array([1e30, 3, 0], F), np.array([1e-30, 0.5, 1], F)
    W = finalize(w, p_hat, np.ones(3, F))["W"]
    assert np.isinf(W[0])
    assert (W[1:] == [6, 0]).all()
    _, found = worst(biases(of("overflows").renderer, ("temporal", "moved")))
    assert abs(found.relative) < TOLERANCE


def test_geometry_tested_first_needs_nulls_that_stand_somewhere():
    renderer = of("geometry tested").renderer
    for nulls, right in (("ordinary", True), ("degenerate", False)):
        _, found = worst(biases(renderer, ("initial", "moved"), nulls))
        assert (abs(found.relative) < TOLERANCE) == right


# ---------------------------------------------------------------- several at once

QUICK_SETS = 6
SLOW_SETS = 60


def combinations():
    """Parameters: singles, pairs and triples."""
    quick = [*sample(2, QUICK_SETS // 2, 1), *sample(3, QUICK_SETS // 2, 2)]
    slow = [*sets_of(1), *sample(2, SLOW_SETS, 3), *sample(3, SLOW_SETS, 4)]
    marked = [(one, ()) for one in quick]
    marked += [(one, pytest.mark.slow) for one in slow if one not in quick]
    unique = {called(one): (one, marks) for one, marks in marked}
    return [pytest.param(one, id=n, marks=m) for n, (one, m) in unique.items()]


@pytest.mark.parametrize("options", combinations())
def test_departures_together_bring_no_bias(options):
    storage = options.get("storage")
    room = TOLERANCE + 2 * ROUNDING.get(storage, 0.0)
    lit = MIXED if storage in MIXING else None
    where, found = worst(biases(composed(options), lit=lit))
    assert abs(found.relative) < room, (where, found)


@pytest.mark.parametrize("storage", MIXING)
def test_light_of_one_channel_is_biased_where_a_format_mixes_channels(storage):
    """A pixel with M = 1 of 8 reflects no red, and counts for red light in Z."""
    found = biases(composed({"storage": storage}), ("spatial",))["spatial"]
    assert LIGHT[found.patch].tolist() == [9, 0, 0]
    assert abs(found.relative + 1 / 8) < TOLERANCE


def test_there_are_more_departures_than_thirty():
    assert len(DEPARTURES) > 31
    assert len(list(sets_of(2))) > 600
    assert len(list(sets_of(3))) > 6000


def test_control_a_mistake_beside_departures_is_seen():
    (options,) = sample(3, 1, 5)
    _, found = worst(biases(BlindDomain(**options), ("moved", "spatial")))
    assert abs(found.relative) > LEAST


def test_lights_are_pure_and_mixed():
    assert ((LIGHT > 0).sum(axis=1) == 1).sum() == 3
