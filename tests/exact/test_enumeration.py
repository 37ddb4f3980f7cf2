"""The production kernels are unbiased: proved by enumeration, in fractions.

No tolerance, no integrand: E[W 1{y = x}] = mu_q(x) for each x that q can use.
"""

from fractions import Fraction

import numpy as np
import pytest

from reference.resampling.shift import reconnection_jacobian
from tests.exact import claims
from tests.exact.domain import (
    CELL,
    CELLS,
    EYE,
    MU,
    NORMAL,
    PIXELS,
    SOURCE,
    TARGET,
    distance,
)
from tests.exact.mutants import CLAIMS, PRODUCTION


def test_the_domain_is_not_degenerate():
    """Jacobians far from 1, supports that differ, each hidden from somebody else."""
    ratios = (MU[:, None] / MU[None, :]).astype(float)
    assert ratios.max() > 30
    assert ratios.min() < 1 / 30
    assert (claims.HOLDS.sum(axis=0) == [3, 2, 2, 2, 2, 1]).all()
    assert all(distance(i, x) > 0 for i in PIXELS for x in CELLS)


def test_a_pixel_draws_exactly_what_it_sees_and_reflects():
    assert ((np.array(SOURCE) > 0) == claims.HOLDS).all()
    assert ((np.array(TARGET) > 0) >= claims.HOLDS).all()


@pytest.mark.parametrize("i_from", PIXELS)
@pytest.mark.parametrize("i_to", PIXELS)
def test_the_jacobian_is_the_ratio_of_solid_angles_exactly(i_from, i_to):
    x_from, x_to = (np.broadcast_to(EYE[i], (len(CELLS), 3)) for i in (i_from, i_to))
    J = reconnection_jacobian(x_from, x_to, CELL[:-1], NORMAL[:-1])
    assert list(J) == list(MU[i_to] / MU[i_from])


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.__name__)
def test_claim(claim):
    assert list(claim(PRODUCTION)) == []


@pytest.mark.parametrize("count", [1, 2])
def test_resampled_importance_sampling_of_few_candidates(count):
    assert list(claims.several_candidates(PRODUCTION, count)) == []


@pytest.mark.parametrize("cap", [1, Fraction(3, 2), 3, float("inf")])
@pytest.mark.parametrize("i", PIXELS)
def test_chain_of_three_frames_with_any_cap(cap, i):
    assert list(claims.temporal_chain(PRODUCTION, cap, frames=3, i=i)) == []


@pytest.mark.parametrize("mis", ["1/Z", "balance", "pairwise", "defensive"])
@pytest.mark.parametrize("visibility", ["all", "chosen"])
@pytest.mark.parametrize("limit", [Fraction(1, 2), Fraction(3)])
def test_one_pass_with_every_option(mis, visibility, limit):
    found = claims.spatial_pass(PRODUCTION, mis=mis, visibility=visibility, limit=limit)
    assert list(found) == []


@pytest.mark.parametrize("mis", ["balance", "pairwise", "defensive"])
def test_two_passes_with_other_weights(mis):
    assert list(claims.two_passes(PRODUCTION, mis)) == []


@pytest.mark.parametrize("mis", ["balance", "pairwise", "defensive"])
def test_loop_with_other_weights(mis):
    assert list(claims.loop_of_two_frames(PRODUCTION, mis)) == []
