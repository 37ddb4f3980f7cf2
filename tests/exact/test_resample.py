"""`restir_gi.reference.resampling.generalized` is unbiased: proved by enumeration.

E[W 1{z = x}] is the measure of x for each weight but 1/M, one pass or two, supports
that differ, confidences of any kind; and weights sum to one over those who could have
made a sample.
"""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from restir_gi.reference import restir_gi
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.resampling.generalized import resample
from tests.exact import claims, shifted
from tests.exact.domain import CELLS, HOLDS, MU, NOTHING, PIXELS, SEES
from tests.exact.explore import explore
from tests.exact.pages import Kept
from tests.exact.shifted import DOMAIN
from tests.mutants.plant import planted
from tests.mutants.reuse import BIASES, ENGINE

CAP = Fraction(2)
UNBIASED = ("1/Z", "balance", "pairwise", "defensive")
each_weight = pytest.mark.parametrize("mis", UNBIASED)


@pytest.fixture(autouse=True)
def _every_pass_by_the_engine(monkeypatch):
    """1/M and 1/Z too, which have passes of their own."""
    monkeypatch.setattr(restir_gi, "resampled", shifted.by_the_engine)


@each_weight
def test_one_pass(mis):
    assert list(claims.spatial_pass(mis=mis)) == []


@each_weight
def test_one_pass_where_large_jacobians_are_refused(mis):
    assert list(claims.pass_with_mirrored_limit(mis)) == []


@each_weight
def test_two_passes(mis):
    """Inputs of the second share those of the first."""
    assert list(claims.two_passes(mis)) == []


def test_a_chain_of_frames():
    assert list(claims.temporal_chain()) == []


@each_weight
@pytest.mark.slow
def test_two_frames_of_both(mis):
    assert list(claims.loop_of_two_frames(mis, CAP)) == []


PARTS = [None, [0, 2, 3], [1, 4, 5], [0, 2, 3]]
"""What sources lend to pixel 0: as windows of the past, of which two are alike."""


def windows(mis):
    """Pixels that know disjoint parts of another one's area."""

    def program(frame, uniform):
        everyone = np.arange(len(frame.r0.W))
        sources = []
        for j, part in zip((0, 1, 2, 2), PARTS, strict=True):
            shown = shifted.toys(DOMAIN.p_hat, j, frame.at(j))
            sources.append(
                shifted.ToyDonor(
                    DOMAIN, 0, j, shown, everyone, part=part, same_domain=j == 0
                )
            )
        return shifted.resampled(sources, uniform, mis)

    law = explore(program, claims.fresh_frame())
    yield from claims.faults(
        0, claims.contributions(law, law.outcomes), claims.truth(0)
    )


@each_weight
def test_windows(mis):
    assert list(windows(mis)) == []


def expected_of_one_over_m(i):
    """Dark by the share of those that could not have made it."""
    M = np.array(claims.TRUST)
    held = [Fraction(int(M[HOLDS[:, x]].sum()), int(M.sum())) for x in CELLS]
    return [a * b for a, b in zip(claims.truth(i), held, strict=True)]


@pytest.mark.parametrize("i", PIXELS)
def test_one_over_m_has_the_bias_that_it_should(i):
    found = claims.spatial_contributions(i, mis="1/M")
    assert found == expected_of_one_over_m(i)
    assert found != claims.truth(i)


# ------------------------------------------------------------ sums of weights


def alone(tables, i, k, x, M, mis):
    """Weight of source k for cell x, which it alone has: W at the receiver by W J."""
    sources = []
    for j in range(len(M)):
        cell = np.array([x if j == k else NOTHING])
        weight = np.array([Fraction(j == k)], object)
        r = Kept(cell, weight, np.array([M[j]], object))
        shown = shifted.toys(tables.p_hat, j, r)
        here = shifted.ToyDonor(
            tables, i, j, shown, np.zeros(1, int), same_domain=j == i
        )
        sources.append(here)
    decisions = [np.array([Fraction(1, 2)], object)] * len(M)
    kept = resample(sources, decisions, mis, 9999, shifted.target)
    ratio = tables.jacobian(k, i, np.array([x]))[0] if k != i else Fraction(1)
    return kept.W[0] / ratio


def sums(tables, M, mis):
    """Σ m_k(x) over those who can make x, for each pixel, and cell of its domain."""
    found = []
    for i, x in np.argwhere(tables.held[:, :NOTHING]):
        makers = [k for k in range(len(M)) if tables.held[k][x] and M[k] > 0]
        found.append(sum(alone(tables, i, k, x, M, mis) for k in makers))
    return found


@each_weight
@pytest.mark.parametrize("M", [(1, 1, 1), claims.TRUST, (Fraction(1, 3), 20, 7)])
def test_weights_sum_to_one(mis, M):
    found = sums(DOMAIN, [Fraction(m) for m in M], mis)
    assert len(found) == HOLDS.sum()
    assert set(found) == {1}


fractions = st.builds(Fraction, st.integers(1, 9), st.integers(1, 9))


@st.composite
def random_tables(draw):
    """Four pixels: who can make what, targets, measures, confidences."""
    size = 4
    shape = st.lists(st.booleans(), min_size=NOTHING, max_size=NOTHING)
    held = np.array([[*draw(shape), False] for _ in range(size)])
    p_hat = [[draw(fractions) if h else Fraction(0) for h in row] for row in held]
    mu = np.array([[draw(fractions) for _ in row] for row in held], object)
    tables = shifted.SourceTables(
        np.array(p_hat, object), held, held, lambda a, b, x: mu[b][x] / mu[a][x]
    )
    return tables, [draw(fractions) for _ in range(size)]


@each_weight
@given(drawn=random_tables())
@settings(max_examples=12, deadline=None)
def test_weights_of_any_tables_sum_to_one(mis, drawn):
    assert set(sums(*drawn, mis)) <= {1}


def test_control_weights_1_m_do_not():
    assert set(sums(DOMAIN, [Fraction(1)] * 3, "1/M")) > {1}


@each_weight
def test_a_slot_without_donor_is_as_if_it_were_not(mis):
    """It brings neither samples nor confidence."""
    M = [Fraction(m) for m in claims.TRUST]
    cells, W = np.array([0, 2, 3]), np.array([Fraction(n) for n in (2, 1, 3)], object)
    kept = []
    for slots in ([0, 1], [0, 1, 2]):
        sources = []
        for j in slots:
            r = Kept(cells, W, np.full(3, M[j], object))
            rows = np.full(3, NONE) if j == 2 else np.arange(3)
            shown = shifted.toys(DOMAIN.p_hat, j, r)
            sources.append(
                shifted.ToyDonor(DOMAIN, 0, j, shown, rows, same_domain=j == 0)
            )
        u = [np.full(3, Fraction(2, 5), object)] * len(slots)
        kept.append(resample(sources, u, mis, 9999, shifted.target))
    np.testing.assert_array_equal(kept[0].y.cell, kept[1].y.cell)
    np.testing.assert_array_equal(kept[0].W, kept[1].W)
    np.testing.assert_array_equal(kept[0].M, kept[1].M)


def test_weights_in_pairs_need_somebody_who_covers_the_domain():
    r = Kept(np.array([0]), np.array([Fraction(1)]), np.array([Fraction(1)]))
    shown = shifted.toys(DOMAIN.p_hat, 1, r)
    source = shifted.ToyDonor(DOMAIN, 0, 1, shown, np.zeros(1, int))
    u = [np.array([Fraction(0)])]
    with pytest.raises(ValueError, match="domain"):
        resample([source], u, "pairwise", 9, shifted.target)


# ------------------------------------------------------------ controls

UNASKED = "slots without a source have the confidence of the first row"
"""No claim has such slots; the test of them above does."""

MISTAKES = [
    mutant for mutant in BIASES if mutant.module == ENGINE and mutant.name != UNASKED
]

EVIDENCE = {
    "chain": claims.temporal_chain,
    "1/Z": claims.spatial_pass,
    "balance": claims.balance_pass,
    "pairwise": claims.pairwise_pass,
    "defensive": claims.defensive_pass,
    "windows": lambda: windows("balance"),
    "frames": lambda: claims.loop_of_two_frames("balance", CAP),
}


@pytest.mark.parametrize("mutant", MISTAKES, ids=lambda mutant: mutant.name)
def test_control_a_mistake_is_refuted(mutant):
    """By at least one of the claims; the code is whole again afterwards."""
    with planted(mutant):
        assert any(is_refuted(claim) for claim in EVIDENCE.values())
    assert not is_refuted(EVIDENCE["1/Z"])


def is_refuted(claim):
    """A fault is found, or a sample is not worth what is kept of it."""
    try:
        return next(claim(), None) is not None
    except AssertionError:
        return True


def test_the_domain_has_partial_supports():
    """Else nobody would learn anything from it."""
    assert {int(n) for n in HOLDS.sum(axis=0)} == {1, 2, 3}
    assert (SEES | ~HOLDS).all()
    assert all(MU[i][x] > 0 for i in PIXELS for x in CELLS)
