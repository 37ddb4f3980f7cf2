"""Whether choices bring a bias is calculated; what is said of each agrees with it."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.oracle.diagnosis.diagnose import HYPOTHESES
from restir_gi.reference.oracle.diagnosis.hypothesis import combined, compatible
from restir_gi.reference.oracle.diagnosis.innocence import (
    EYES,
    LOOKS,
    NOTHING,
    SITUATIONS,
    SURFACE_SITUATIONS,
    TOLERANCE,
    WEIGHT_SITUATIONS,
    bias_of,
    bias_of_rules,
    expectations,
    situations_of,
    world,
)
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.formulas import jacobian, weight
from restir_gi.reference.oracle.replay.reuse import STREAMS
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

BY_NAME = {h.name: h for h in HYPOTHESES}
OF_REUSE = [h for h in HYPOTHESES if set(h.passes) & set(STREAMS)]
OF_VISIBILITY = [h for h in OF_REUSE if h.declared]


@pytest.mark.parametrize("pass_name", STREAMS)
def test_the_contract_brings_no_bias(pass_name):
    assert bias_of_rules(pass_name, CONTRACT_RULES) == ""


@pytest.mark.parametrize("hypothesis", OF_REUSE, ids=lambda h: h.name)
def test_what_is_said_of_a_hypothesis_is_what_the_sums_say(hypothesis):
    passes = [name for name in hypothesis.passes if name in STREAMS]
    found = [bias_of_rules(name, hypothesis.rules) for name in passes]
    assert (not any(found)) == bool(hypothesis.departure), found


@pytest.mark.parametrize("situation", SURFACE_SITUATIONS, ids=lambda s: s.look)
@pytest.mark.parametrize("pass_name", STREAMS)
def test_the_contract_brings_no_bias_on_declared_surfaces(pass_name, situation):
    """Of whoever does other things with them the same worlds ask."""
    mu = world(situation.eyes, situation.hidden).mu[0][:NOTHING]
    (found,) = expectations(pass_name, CONTRACT_RULES, situation).values()
    assert found == pytest.approx(mu, rel=TOLERANCE)


def test_whoever_has_other_surfaces_is_asked_about_each_look():
    rules = BY_NAME["target-lobe-left-out"].rules
    assert {s.look for s in situations_of(rules)} == {"", *LOOKS}
    assert situations_of(CONTRACT_RULES) == (*SITUATIONS, *WEIGHT_SITUATIONS)
    other = replace(CONTRACT_RULES, normalization="balance")
    assert situations_of(other) == SITUATIONS


def scaled(formula, factor):
    def planted(*args):
        x = formula(*args)
        return Bounded(x.value * factor, x.error, x.rounding)

    return planted


PLANTED = {
    "a weight that is 0.1 % too large": {"weight": scaled(weight, 1.001)},
    "a Jacobian that is 0.1 % too small": {"jacobian": scaled(jacobian, 0.999)},
    "a cut of J far out": {"clamped": (0.0, 90.0)},
    "a refusal that Z does not know": {"refused": (0.02, 50.0)},
    "balance of half the domain": {
        "normalization": "balance",
        "visibility_in_z": False,
    },
    "a chain that begins elsewhere": {
        "normalization": "chained-balance",
        "order": "reversed",
    },
}


@pytest.mark.parametrize("name", PLANTED)
def test_control_a_bias_is_found(name):
    assert bias_of_rules("spatial", replace(CONTRACT_RULES, **PLANTED[name]))


def test_the_words_say_what_comes_out():
    text = bias_of("spatial", (BY_NAME["jacobian-omitted"],))
    assert text.startswith("E[W 1(y = x)] of a patch is ")
    assert "instead of" in text


def test_innocent_choices_may_be_biased_together():
    chosen = BY_NAME["chained-balance"], BY_NAME["stream-reversed"]
    assert all(bias_of("spatial", (h,)) == "" for h in chosen)
    assert bias_of("spatial", chosen) != ""


@pytest.mark.parametrize("hypothesis", OF_VISIBILITY, ids=lambda h: h.name)
def test_what_is_declared_is_not_held_against_hidden_samples(hypothesis):
    declared = replace(hypothesis, departure=hypothesis.declared)
    assert bias_of("spatial", (hypothesis,)) != ""
    assert bias_of("spatial", (declared,)) == ""


def test_pairs_of_other_kinds_are_innocent():
    """One of each kind: they do not look at each other."""
    names = (
        "own-first",
        "capped-on-arrival",
        "target-always-outgoing",
        "balance-in-weights",
        "jacobian-refused-both-ways-at-10",
        "stored-as-packed-half",
    )
    chosen = tuple(BY_NAME[name] for name in names)
    assert compatible(chosen)
    assert bias_of("spatial", chosen) == ""


def test_the_worlds_go_everywhere():
    """J from 1/100 to 100, M at the cap and 0, nulls, and patches out of the domain."""
    at = world("near and far", False)
    mu = at.mu[:, 0]
    assert mu[0] / mu[1] < 0.011
    assert mu[0] / mu[2] > 90
    assert {s.eyes for s in SITUATIONS} == set(EYES)
    assert any(0.0 in s.M for s in SITUATIONS)
    assert any(s.M[0] == s.cap for s in SITUATIONS)
    assert any(s.M[0] > 255 for s in SITUATIONS)
    assert {s.target for s in SITUATIONS} == {"scattered", "outgoing"}


def test_m_is_the_same_for_all_outcomes():
    for situation in SITUATIONS:
        found = expectations("spatial", CONTRACT_RULES, situation)
        assert len(found) == 1


def test_control_m_that_depends_on_the_sample():
    h = BY_NAME["reused-nulls-not-counted"]
    found = [expectations("spatial", h.rules, s) for s in SITUATIONS]
    assert max(map(len, found)) > 1
    assert np.isfinite([M for one in found for M in one]).all()


def test_a_combination_has_the_changes_of_all():
    chosen = [BY_NAME["target-always-outgoing"], BY_NAME["luminance-of-rec-601"]]
    rules = combined(chosen)
    assert rules.target.kind == "outgoing"
    assert rules.target.light is chosen[1].rules.target.light
    assert not compatible([BY_NAME["never-capped"], BY_NAME["capped-on-arrival"]])
    assert not compatible([BY_NAME["balance"], BY_NAME["balance-without-jacobian"]])
