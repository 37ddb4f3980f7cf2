"""Departures that the oracle lets pass keep the mean: proved by enumeration.

For every integrand at once: whatever target weighs and divides, wherever M is capped,
and whichever way round a decision is read, E[W 1{y = x}] = mu_q(x).
"""

from dataclasses import replace
from fractions import Fraction

import pytest

from restir_gi.reference.oracle.diagnosis.alternatives import CONFIDENCES, ORDERS
from restir_gi.reference.oracle.diagnosis.diagnose import known_mistakes
from tests.exact import claims, pages
from tests.exact.domain import TARGET
from tests.exact.mutants import PAST, RESERVOIR, SPATIAL, TEMPORAL, ExactMutant
from tests.mutants.plant import planted

ZERO = Fraction(0)

OTHER_TARGETS = {
    "twice as large": lambda p: 2 * p,
    "squared": lambda p: p * p,
    "constant where it is positive": lambda p: Fraction(p > 0),
    "with a floor where it is positive": lambda p: max(p, Fraction(3)) if p else ZERO,
    "shuffled where it is positive": lambda p: 1 / p if p else ZERO,
}

ORDER = (
    ExactMutant(
        "u as 1 − u",
        RESERVOIR,
        "(u * (w_a + w_b) < w_b)",
        "((u * (w_a + w_b) >= w_a) & (w_b > 0))",
    ),
    ExactMutant(
        "the stream backwards",
        SPATIAL,
        PAST,
        "(first, u_past), *others = neighbors[::-1]\n"
        "    R_s = begin(shifted(q, first))",
        also=(
            (SPATIAL, "    R_s = R_s.then(reused(q, own), u_own)\n", ""),
            (SPATIAL, "= [past, own]  # line 3", "= [first]"),
            (SPATIAL, "for q_n, u_n in neighbors:", "for q_n, u_n in others:"),
            (
                SPATIAL,
                "    Z = normalization(mis, R_s, Q)",
                "    R_s = R_s.then(reused(q, own), u_own)\n"
                "    R_s = R_s.then(reused(q, past), u_past)\n"
                "    Z = normalization(mis, R_s, [*Q, own, past])",
            ),
        ),
    ),
)

CONFIDENCE = (
    ExactMutant("never capped", RESERVOIR, "np.minimum(r.M, cap)", "r.M"),
    ExactMutant(
        "one more", RESERVOIR, "np.minimum(r.M, cap)", "np.minimum(r.M, cap + 1)"
    ),
    ExactMutant(
        "capped on arrival",
        TEMPORAL,
        "R = begin(reused(q, past))",
        "past = cap_confidence(past, cap)\n"
        "    cap = 9999\n"
        "    R = begin(reused(q, past))",
    ),
)


def biases():
    """Faults in the expectation; those in M alone are what these departures are."""
    for claim in (
        claims.several_candidates,
        claims.temporal_chain,
        claims.spatial_pass,
        claims.two_passes,
        claims.loop_of_two_frames,
    ):
        yield from (fault for fault in claim() if not fault.startswith("M is"))


def aimed_at(monkeypatch, table):
    """Give pixels another target."""
    p_hat = pages.with_nothing(table)
    monkeypatch.setattr(pages, "NOW", replace(pages.NOW, p_hat=p_hat))


@pytest.mark.parametrize("name", OTHER_TARGETS)
@pytest.mark.few(2)
def test_any_target_that_is_positive_in_the_same_places(monkeypatch, name):
    aimed_at(monkeypatch, [[*map(OTHER_TARGETS[name], row)] for row in TARGET])
    assert list(biases()) == []


def test_control_a_target_that_is_0_where_there_is_light(monkeypatch):
    aimed_at(monkeypatch, [[ZERO, *row[1:]] for row in TARGET])
    assert next(biases(), None) is not None


@pytest.mark.parametrize("mutant", [*ORDER, *CONFIDENCE], ids=lambda m: m.name)
@pytest.mark.few(2)
def test_order_and_confidence(mutant):
    with planted(mutant):
        assert list(biases()) == []


def test_control_an_order_that_is_no_order():
    odd = ExactMutant("", RESERVOIR, "(u * (w_a + w_b) < w_b)", "(u * w_a < w_b)")
    with planted(odd):
        assert next(biases(), None) is not None


def test_what_is_said_to_be_a_departure():
    """Each is of a kind that is proved above, or by its own argument in its words."""
    kinds = {h.name: h.departure for h in known_mistakes() if h.departure}
    of_order = {name for name, kind in kinds.items() if kind == "order"}
    assert of_order == {
        "keeps-the-other-side",
        "stream-reversed",
        "directions-from-the-other-end",  # 1 − u is as uniform as u
        "cosine-directions-from-the-other-end",
        "shade-back-of-sample",  # where W is 0, since p̂ is
        "jacobian-cut-at-the-back",  # where p̂ is 0
        "reuse-u-turned",  # the first, on whole samples
        "pair-u-turned",
        "light-candidates-u-turned",
        "light-reuse-u-turned",
        "bounce-u-turned",
        "cell-hashes-exchanged",  # cells are told apart by the same two words
        "cell-insert-by-upper-bits",  # in whichever slot, a cell has its own vertices
        "cell-find-by-upper-bits",
        "cell-insert-goes-on-in-the-next-bucket",
        "cell-find-goes-on-in-the-next-bucket",
        *(h.name for h in ORDERS),  # in tests of innocence
    }
    assert {name for name, kind in kinds.items() if kind == "confidence"} == {
        "never-capped",
        "cap-off-by-one",
        "capped-on-arrival",
        "reuse-never-capped",  # the first and the last, on whole samples
        "reuse-capped-beforehand",
        "pair-reuse-never-capped",  # and of pairs and of light, by the same engine
        "light-reuse-never-capped",
        "light-reuse-capped-beforehand",
        "pair-candidates-count-twice",  # the same for all pairs, whatever they hold
        "light-candidates-count-once",
        *(h.name for h in CONFIDENCES),  # in tests of innocence
    }
