"""The passes that render are unbiased: proved by enumeration, in fractions.

No tolerance, no integrand: E[W 1{y = x}] = mu_q(x) for each x that q can use.
"""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.settings import Settings
from tests.exact import claims, domain, pages
from tests.exact.domain import (
    CELL,
    CELLS,
    EYE,
    HOLDS,
    MU,
    NORMAL,
    NOTHING,
    PIXELS,
    SOURCE,
    TARGET,
    distance,
)
from tests.exact.mutants import CLAIMS

MOVED = (
    claims.moved_temporal_pass,
    claims.moved_spatial_pass,
    claims.moved_sources_pass,
    claims.moved_fused_pass,
)

each_weight = pytest.mark.parametrize(
    "mis", ["1/Z", "balance", "pairwise", "defensive"]
)
each_visibility = pytest.mark.parametrize("visibility", ["all", "chosen"])


def test_the_domain_is_not_degenerate():
    """Jacobians far from 1, supports that differ, each hidden from somebody else."""
    ratios = (MU[:, None] / MU[None, :]).astype(float)
    assert ratios.max() > 30
    assert ratios.min() < 1 / 30
    assert (HOLDS.sum(axis=0) == [3, 2, 2, 2, 2, 1]).all()
    assert all(distance(i, x) > 0 for i in PIXELS for x in CELLS)


def test_a_pixel_draws_exactly_what_it_sees_and_reflects():
    assert ((np.array(SOURCE) > 0) == HOLDS).all()
    assert ((np.array(TARGET) > 0) >= HOLDS).all()


@pytest.mark.parametrize("i_from", PIXELS)
@pytest.mark.parametrize("i_to", PIXELS)
def test_the_jacobian_is_the_ratio_of_solid_angles_exactly(i_from, i_to):
    x_from, x_to = (np.broadcast_to(EYE[i], (len(CELLS), 3)) for i in (i_from, i_to))
    J = reconnection_jacobian(x_from, x_to, CELL[:-1], NORMAL[:-1])
    assert list(J) == list(MU[i_to] / MU[i_from])


def test_the_last_frame_differs_in_all_respects():
    """Each kind of cell is there: lost, gained, and both seen and moved."""
    now, then, moved = HOLDS[0], pages.HOLDS_THEN, pages.MOVES[:NOTHING]
    for kind in (now & ~then, then & ~now, now & then & moved, now & then & ~moved):
        assert kind.any()
    assert (np.array(pages.TARGET_THEN)[pages.LIT_THEN[:NOTHING]] > 0).all()
    assert ((np.array(pages.SOURCE_THEN) > 0) == then).all()


def test_the_jacobian_between_the_frames_is_the_ratio_of_solid_angles():
    """x_n is carried along beside what moved; and back."""
    x = np.array(CELLS)
    eye = np.broadcast_to(EYE[0], (len(x), 3))
    beside = pages.carried(eye, x)
    for i in PIXELS:
        to = np.broadcast_to(EYE[i], eye.shape)
        J = reconnection_jacobian(beside, to, CELL[x], NORMAL[x])
        assert list(J) == list(MU[i] / pages.MU_THEN)
        led, then = pages.led_back(to, x), (pages.CELL_THEN[x], pages.NORMAL_THEN[x])
        assert list(reconnection_jacobian(led, eye, *then)) == list(1 / J)


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.__name__)
def test_claim(claim):
    assert list(claim()) == []


@pytest.mark.parametrize("count", [1, 2])
def test_resampled_importance_sampling_of_few_candidates(count):
    assert list(claims.several_candidates(count)) == []


@pytest.mark.parametrize("cap", [1, Fraction(3, 2), 3, float("inf")])
@pytest.mark.parametrize("i", PIXELS)
def test_chain_of_three_frames_with_any_cap(cap, i):
    assert list(claims.temporal_chain(cap, frames=3, i=i)) == []


@pytest.mark.parametrize("mis", ["1/M", "balance", "pairwise", "defensive"])
def test_a_chain_is_exact_with_any_weights(mis):
    """Both samples come from one domain: M is exact."""
    assert list(claims.temporal_chain(frames=3, mis=mis)) == []


@each_weight
@each_visibility
@pytest.mark.parametrize("largest", [Fraction(1, 2), Fraction(3)])
def test_one_pass_with_every_option(mis, visibility, largest):
    found = claims.spatial_pass(mis=mis, visibility=visibility, largest=largest)
    assert list(found) == []


@each_weight
@each_visibility
def test_the_fused_pass(mis, visibility):
    assert list(claims.fused_pass(mis, visibility)) == []


@each_weight
@each_visibility
@pytest.mark.parametrize("claim", MOVED, ids=lambda claim: claim.__name__)
def test_passes_where_something_has_moved(claim, mis, visibility):
    assert list(claim(mis=mis, visibility=visibility)) == []


@pytest.mark.parametrize("mis", ["balance", "pairwise", "defensive"])
def test_two_passes_with_other_weights(mis):
    assert list(claims.two_passes(mis)) == []


@pytest.mark.parametrize("mis", ["balance", "pairwise", "defensive"])
def test_loop_with_other_weights(mis):
    assert list(claims.loop_of_two_frames(mis)) == []


# ---------------------------------------------------------------- degenerate shifts


@each_weight
def test_a_cell_that_a_pixel_sees_edge_on(mis, monkeypatch):
    """Pixel 0 lies in the plane of cell 3: no solid angle, no target, J = 0 twice."""
    normal, mu = NORMAL.copy(), MU.copy()
    normal[3] = [Fraction(n, 11) for n in (-6, -2, 9)]
    for module in (domain, pages):
        monkeypatch.setattr(module, "NORMAL", normal)
    mu[:, 3] = [domain.solid_angle(i, 3) for i in PIXELS]
    assert mu[0, 3] == 0
    for module in (claims, pages):
        monkeypatch.setattr(module, "MU", mu)
    p_hat, seen, pdf = pages.NOW.p_hat.copy(), pages.NOW.seen.copy(), pages.PDF.copy()
    p_hat[0, 3], seen[0, 3] = Fraction(0), True
    pdf[1:, 3] = np.array(SOURCE)[1:, 3] / mu[1:, 3]
    monkeypatch.setattr(pages, "NOW", replace(pages.NOW, p_hat=p_hat, seen=seen))
    monkeypatch.setattr(pages, "PDF", pdf)
    assert list(claims.spatial_pass(mis=mis)) == []


@each_weight
def test_a_neighbor_that_is_not_there_is_as_if_it_were_not_sought(mis):
    """It brings neither samples nor confidence."""
    s = Settings(mis=mis)

    def law(sought):
        def program(frame, uniform):
            own = frame.at(0)
            q = pages.receivers(0, len(own.W), s)
            around = pages.neighbors(q, {1: frame.at(1)}, uniform)
            if sought:
                nowhere = np.full(len(own.W), NONE)
                none = pages.frame_of(2, frame.at(2)).neighbors(q, nowhere)
                assert not none.reservoirs.W.any()
                assert not none.reservoirs.M.any()
                none = replace(none, reservoirs=pages.empty(len(nowhere)))
                around.insert(0, (none, uniform()))
            past = pages.past_of(q, None)
            given = q, past, own.opened(), around
            return pages.resampled(*given, uniform, s, pages.NO_CAP)

        return claims.explored(program, claims.fresh_frame()).as_dict()

    assert law(sought=True) == law(sought=False)


@each_weight
def test_nulls_alone(mis, monkeypatch):
    """Whoever finds nothing keeps nothing, and its trials count."""
    monkeypatch.setattr(pages, "SOURCE", [[Fraction(0)] * len(CELLS)] * len(PIXELS))
    frames = claims.fresh_frame()
    law = claims.spatial_law(frames, 0, mis=mis)
    assert law.as_dict() == {(NOTHING, 0, sum(claims.TRUST)): 1}
