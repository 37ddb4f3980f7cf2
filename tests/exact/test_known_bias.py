"""Biased variants have the bias that theory gives them, to the last digit.

An integrand is given by what each cell contributes to each pixel, a = f mu, in whole
numbers, so that the pixels' true values are 6, 4 and 11.
"""

from fractions import Fraction

import numpy as np
import pytest

from restir_gi.reference.resampling import reservoir
from tests.exact import claims, pages
from tests.exact.domain import CELLS, HOLDS, MU, PIXELS, SOURCE, TARGET
from tests.exact.mutants import MUTANTS
from tests.mutants.plant import planted

SHARE = np.array([[2, 1, 1, 0, 1, 1], [1, 0, 2, 1, 0, 0], [4, 3, 0, 2, 2, 0]])
"""What cell x contributes to pixel i: f_i(x) mu_i(x)."""

TRUTH = [6, 4, 11]

BY_NAME = {mutant.name: mutant for mutant in MUTANTS}


def pixel_value(contributions, i):
    """E[f(y) W] from E[W 1{y = x}]."""
    return sum(SHARE[i][x] / MU[i][x] * contributions[x] for x in CELLS)


def test_the_integrand_lives_where_the_pixels_see():
    assert ((SHARE > 0) <= HOLDS).all()
    assert SHARE.sum(axis=1).tolist() == TRUTH


@pytest.mark.parametrize("i", PIXELS)
def test_unbiased_weights_give_the_truth(i):
    found = claims.spatial_contributions(i, mis="1/Z")
    assert pixel_value(found, i) == TRUTH[i]


def expected_of_one_over_m(i, trust):
    """mu_i(x) times the share of M whose domain holds x."""
    held = [sum(M for M, holds in zip(trust, HOLDS[:, x], strict=True) if holds)
            for x in CELLS]  # fmt: skip
    return [
        c * Fraction(h, sum(trust)) for c, h in zip(claims.truth(i), held, strict=True)
    ]


@pytest.mark.parametrize("i", PIXELS)
def test_one_over_m_is_dark_by_the_share_that_could_not_have_made_it(i):
    found = claims.spatial_contributions(i, mis="1/M")
    assert found == expected_of_one_over_m(i, claims.TRUST)


@pytest.mark.parametrize(
    ("i", "value"), [(0, Fraction(13, 3)), (1, Fraction(3)), (2, Fraction(26, 3))]
)
def test_one_over_m_of_equal_pixels(i, value, monkeypatch):
    """-27.8, -25 and -21.2 %: 13/3 for 6, 3 for 4, 26/3 for 11."""
    monkeypatch.setattr(claims, "TRUST", (1, 1, 1))
    found = claims.spatial_contributions(i, mis="1/M")
    assert pixel_value(found, i) == value


@pytest.mark.parametrize("i", PIXELS)
def test_samples_never_tested_for_visibility_leak(i):
    """Hidden cells contribute what M says of those who see them, all others as ever."""
    found = claims.spatial_contributions(i, mis="1/Z", visibility="none")
    for x in CELLS:
        others = [k for k in PIXELS if k != i and HOLDS[k][x]]
        share = Fraction(1)
        if not HOLDS[i][x]:
            # The pixel's own M is counted although it could not have made x.
            M = sum(claims.TRUST[k] for k in others)
            share = Fraction(M, M + claims.TRUST[i])
        reflects = TARGET[i][x] > 0
        assert found[x] == (MU[i][x] * share if reflects else 0)


def test_without_the_jacobian_each_donor_brings_its_own_measure():
    """C(x) = Σ_k M_k mu_k(x) / Z(x): the sources' measure, not the receiver's."""
    for i in PIXELS:
        expected = average_over_makers(i, lambda k, x: MU[k][x])
        with planted(BY_NAME["the Jacobian is left out"]):
            assert claims.spatial_contributions(i) == expected
        assert claims.spatial_contributions(i, jacobian="left-out") == expected


def test_divided_by_the_jacobian_the_measure_is_off_by_its_square():
    """C(x) = Σ_k M_k mu_k(x)² / mu_i(x) / Z(x), which is what Algorithm 4 prints."""
    for i in PIXELS:
        expected = average_over_makers(i, lambda k, x, i=i: MU[k][x] ** 2 / MU[i][x])
        with planted(BY_NAME["the weight is divided by the Jacobian"]):
            assert claims.spatial_contributions(i) == expected
        assert claims.spatial_contributions(i, jacobian="divided") == expected


def average_over_makers(i, measure):
    """Mean of measures of each cell over those who could have made it, by M."""
    return [
        sum(claims.TRUST[k] * measure(k, x) for k in makers)
        / Fraction(sum(claims.TRUST[k] for k in makers))
        if (makers := [k for k in PIXELS if HOLDS[k][x]]) and HOLDS[i][x]
        else Fraction(0)
        for x in CELLS
    ]


@pytest.mark.parametrize("i", PIXELS)
def test_nulls_left_out_condition_the_mean_on_success(i):
    """Two trials, each a hit with probability P: brighter by (1 - (1-P)²) / P = 2 - P.

    A mean over the hits alone has expectation mu / P whenever there is a hit at all.
    """
    P = sum(SOURCE[i])
    with planted(BY_NAME["new samples that found nothing do not count"]):
        assert two_candidates(i) == [mu * (2 - P) for mu in claims.truth(i)]


def two_candidates(i):
    """E[W 1{y = x}] of two merged candidates, with 1/M."""

    def program(rows, uniform):
        a, b = (claims.candidate(i, uniform) for _ in range(2))
        kept = reservoir.merge(a, b, uniform())
        return pages.closed(reservoir.finalize(kept, kept.M))

    law = claims.explored(program, claims.NOWHERE)
    return claims.contributions(law, law.outcomes)


@pytest.mark.parametrize("i", PIXELS)
def test_one_over_m_after_a_change_is_dark_by_what_the_past_could_not_make(i):
    """mu_i(x) times the share of M that could make x: the past in its own frame."""
    law = claims.moved_temporal_law(i, mis="1/M")
    then = [claims.PAST if held else 0 for held in pages.HOLDS_THEN]
    total = claims.PAST + 1
    assert claims.contributions(law, law.outcomes) == [
        mu * Fraction(M + 1, total) for mu, M in zip(claims.truth(i), then, strict=True)
    ]
