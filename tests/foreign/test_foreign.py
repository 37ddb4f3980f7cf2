"""The verdict on backends in the manner of others: true of the right and the wrong."""

from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.oracle.checking import judge, told
from restir_gi.reference.oracle.diagnosis.diagnose import known_mistakes
from restir_gi.reference.oracle.diagnosis.hypothesis import combined
from restir_gi.reference.oracle.diagnosis.subsets import explained, whole
from restir_gi.reference.oracle.levels.rows import row_probes
from tests.foreign.backends import DECLARED, EXTREMES, RIGHT, WRONG, Only
from tests.foreign.combined import (
    ONCE_ACCUSED,
    called,
    composed,
    passes_of,
    sample,
    sets_of,
)

BUDGET = 300.0
"""Seconds that no verdict takes."""

QUICK = {
    "own first, cap on arrival: RTXDI temporal",
    "J refused both ways, 1/Z asks too",
    "only kernels",
}
"""Verdicts by default: each takes seconds, and the others are slow together."""

SILENT = {
    "the contract as it stands",
    "at most, where there is a weight",
    "W = 1 / pdf of nulls",
    "only kernels",
    "a service that outlives the call",
}
"""Right ones whose answers are the contract's: there is no departure to be named."""


def verdict_on(foreign):
    """Verdict without whole runs."""
    return judge(foreign.backend, budget=BUDGET, statistics=False)


def named(backends):
    """Parameters of a test, most of them slow."""
    quick = [one for one in backends if one.name in QUICK or one in WRONG[:1]]
    return [
        pytest.param(one, id=one.name, marks=() if one in quick else pytest.mark.slow)
        for one in backends
    ]


@pytest.mark.parametrize("foreign", named(RIGHT))
def test_the_right_pass(foreign):
    verdict = verdict_on(foreign)
    assert verdict.status == "PASS", told(verdict)
    assert verdict.at_extremes == []
    assert (foreign.name in SILENT) == (verdict.departures == [])


@pytest.mark.parametrize("foreign", named(WRONG))
def test_the_wrong_fail(foreign):
    assert verdict_on(foreign).status == "FAIL"


@pytest.mark.slow
@pytest.mark.parametrize("foreign", EXTREMES, ids=lambda one: one.name)
def test_extremes_are_told_and_pass(foreign):
    verdict = verdict_on(foreign)
    assert verdict.status == "PASS", told(verdict)
    assert verdict.at_extremes


@pytest.mark.slow
@pytest.mark.parametrize("foreign", DECLARED, ids=lambda one: one.name)
def test_what_nobody_declared_fails(foreign):
    assert verdict_on(foreign).status == "FAIL"


@pytest.mark.slow
def test_a_service_that_nobody_ends_passes_and_is_ended():
    place = Path(__file__).with_name("service.py")
    verdict = judge(f"{place}:STAYS", budget=BUDGET, statistics=False)
    assert verdict.status == "PASS", told(verdict)
    assert verdict.left_running == 1


def not_accused(options):
    """That departures together pass."""
    backend = Only(composed(options), passes_of(options))
    verdict = judge(backend, budget=BUDGET, statistics=False)
    assert verdict.status == "PASS", told(verdict)


@pytest.mark.slow
@pytest.mark.parametrize("options", ONCE_ACCUSED, ids=called)
def test_what_was_accused_wrongly_is_not(options):
    not_accused(options)


SETS = [*sets_of(1), *sample(2, 40, 11), *sample(3, 40, 12)]


@pytest.mark.campaign
@pytest.mark.parametrize("options", SETS, ids=called)
def test_departures_are_accused_neither_alone_nor_together(options):
    not_accused(options)


@pytest.mark.parametrize("seed", [49, 502, 521])
def test_an_open_decision_in_a_chain_leaves_what_follows_open(seed):
    # Once accused: slot 1 of a chain of 32 was kept or not, at the last number below 1.
    names = ("capped-everywhere-on-arrival", "target-always-outgoing")
    names += ("chained-balance", "own-first-turned-in-place")
    rules = combined(h for h in known_mistakes() if h.name in names)
    (like_bevy,) = (one for one in RIGHT if one.name == "a renderer like Bevy")
    for probe in row_probes("float32", seed):
        case = probe.case
        if case.pass_name != "spatial" or case.settings["mis"] == "1/M":
            continue
        answer = like_bevy.backend.spatial(**case.inputs, **case.settings)
        assert explained(whole(case, answer), rules, "float32"), case.name
        # Control: where nothing is open another choice is none that may be.
        wrong = {n: np.roll(a, 1, axis=0) for n, a in answer.items()}
        assert not explained(whole(case, wrong), rules, "float32")
