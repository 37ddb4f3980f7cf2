"""Departures that the oracle lets pass keep the mean: proved by enumeration.

For every integrand at once: whatever target weighs and divides, wherever M is capped,
and whichever way round a decision is read, E[W 1{y = x}] = mu_q(x).
"""

from fractions import Fraction

import numpy as np
import pytest

from reference.oracle.diagnosis.diagnose import known_mistakes
from tests.exact import claims, pipeline
from tests.exact.domain import TARGET
from tests.exact.mutants import PRODUCTION, Mutant

BASE = [np.array(row, object) for row in TARGET]
ZERO = Fraction(0)

OTHER_TARGETS = {
    "twice as large": lambda p: 2 * p,
    "squared": lambda p: p * p,
    "constant where it is positive": lambda p: Fraction(p > 0),
    "with a floor where it is positive": lambda p: max(p, Fraction(3)) if p else ZERO,
    "shuffled where it is positive": lambda p: 1 / p if p else ZERO,
}

ORDER = (
    Mutant(
        "u as 1 − u",
        "reservoir",
        "(u * (w_a + w_b) < w_b)",
        "((u * (w_a + w_b) >= w_a) & (w_b > 0))",
    ),
    Mutant(
        "the stream backwards",
        "pipeline",
        "    chosen = candidates[0]\n    for c in candidates[1:]:",
        "    chosen = candidates[-1]\n    for c in candidates[-2::-1]:",
    ),
)

CONFIDENCE = (
    Mutant("never capped", "reservoir", "np.minimum(r.M, cap)", "r.M"),
    Mutant("one more", "reservoir", "np.minimum(r.M, cap)", "np.minimum(r.M, cap + 1)"),
    Mutant(
        "capped on arrival",
        "pipeline",
        "    old = k.reused_candidates(history, P_HAT[i][history.y])\n",
        "    history = k.cap_confidence(history, cap)\n"
        "    old = k.reused_candidates(history, P_HAT[i][history.y])\n"
        "    cap = 9999\n",
    ),
)


def biases(code):
    """Faults in the expectation; those in M alone are what these departures are."""
    for claim in (
        claims.several_candidates,
        claims.temporal_chain,
        claims.spatial_pass,
        claims.two_passes,
        claims.loop_of_two_frames,
    ):
        yield from (fault for fault in claim(code) if not fault.startswith("M is"))


@pytest.mark.parametrize("name", OTHER_TARGETS)
def test_any_target_that_is_positive_in_the_same_places(monkeypatch, name):
    tables = [np.array([*map(OTHER_TARGETS[name], row), ZERO], object) for row in BASE]
    monkeypatch.setattr(pipeline, "P_HAT", tables)
    assert list(biases(PRODUCTION)) == []


def test_control_a_target_that_is_0_where_there_is_light(monkeypatch):
    tables = [np.array([ZERO, *row[1:], ZERO], object) for row in BASE]
    monkeypatch.setattr(pipeline, "P_HAT", tables)
    assert next(biases(PRODUCTION), None) is not None


@pytest.mark.parametrize("mutant", [*ORDER, *CONFIDENCE], ids=lambda m: m.name)
def test_order_and_confidence(mutant):
    assert list(biases(mutant.plant())) == []


def test_control_an_order_that_is_no_order():
    odd = Mutant("", "reservoir", "(u * (w_a + w_b) < w_b)", "(u * w_a < w_b)")
    assert next(biases(odd.plant()), None) is not None


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
    }
    assert {name for name, kind in kinds.items() if kind == "confidence"} == {
        "never-capped",
        "cap-off-by-one",
        "capped-on-arrival",
        "reuse-never-capped",  # the first and the last, on whole samples
        "reuse-capped-beforehand",
    }
