"""Declared MIS weights: who is right passes, who is not is told in what."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.checking import judge, told
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.diagnosis.declared_weights import DECLARED_WEIGHTS
from restir_gi.reference.oracle.diagnosis.diagnose import diagnose
from restir_gi.reference.oracle.ladder import run_of
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.levels.spheres import furnace, half_lit
from restir_gi.reference.oracle.levels.weights import weight_row_probes
from restir_gi.reference.oracle.loop import Run
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.resampling import pairwise as reuse_pairwise
from tests.foreign import kernels as k
from tests.foreign.backends import Only
from tests.foreign.kernels import F, Point
from tests.foreign.mistakes import HalfJacobians, PairwiseWithoutOwn
from tests.foreign.renderer import FIRST, OWN, ForeignRenderer, pairwise
from tests.mutants import reuse_by_hand as by_hand

CONTRACT = whole_contract()
REUSE = ("temporal", "moved", "spatial")
EVERY = ["1/M", "1/Z", *MIS.more]


def has(*words, **more):
    """A declaration of weights."""
    return {"schema": "restir-declaration 1", "has": {"mis": list(words)} | more}


def verdict_on(backend, words=EVERY, passes=("moved",), **about):
    """Verdict without whole runs."""
    only = Selection(only=frozenset(passes))
    return judge(
        backend, 300, statistics=False, declaration=has(*words), selection=only, **about
    )


class WeightsListener:
    """A right backend that remembers which weights it was asked for."""

    precision = "float32"

    def __init__(self):
        self.asked = set()

    def __getattr__(self, name):
        """A pass."""
        own = getattr(FLOAT32, name)

        def call(**given):
            self.asked.add((name, given.get("mis", "")))
            return own(**given)

        return call


# ---------------------------------------------------------------- who is right


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        pytest.param(
            ["1/M"], {("moved", "1/M"), ("temporal", "")}, marks=pytest.mark.slow
        ),
        (["balance"], {("moved", "balance"), ("temporal", "")}),
        (["defensive"], {("moved", "defensive"), ("temporal", "defensive")}),
        pytest.param(
            ["pairwise", "defensive"],
            {("moved", "pairwise"), ("moved", "defensive"), ("temporal", "")}
            | {("temporal", "defensive")},
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_is_declared_is_asked_and_nothing_else(words, wanted):
    """Where nothing moves 1/M, balance and pairwise are 1/Z, asked without a word."""
    backend = WeightsListener()
    said = has(*words)
    only = Selection(only=frozenset({"moved", "temporal"}))
    about = {"statistics": False, "declaration": said, "selection": only}
    verdict = judge(backend, 300, **about, accept=["one-over-m"] * (words == ["1/M"]))
    assert backend.asked == wanted
    assert verdict.status == "PASS", told(verdict)
    assert verdict.departures == []


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["float32", "float64", "foreign"])
def test_a_right_backend_of_all_weights_passes(backend):
    foreign = Only(ForeignRenderer(), REUSE)
    verdict = verdict_on(foreign if backend == "foreign" else backend, passes=REUSE)
    assert verdict.status == "PASS", told(verdict)
    assert verdict.departures == []


def test_a_foreign_renderer_of_all_weights_passes():
    verdict = verdict_on(Only(ForeignRenderer(), ("moved",)))
    assert verdict.status == "PASS", told(verdict)
    assert verdict.departures == []


# ---------------------------------------------------------------- other weights


@cache
def probes(pass_name):
    found = (*row_probes("float32"), *weight_row_probes("float32"))
    return [
        p
        for p in found
        if p.case.pass_name == pass_name and "surface" not in p.case.settings
    ]


def done_by_hand(hypothesis):
    """What is done in place of what is asked for, of those that are written by hand."""
    asked = hypothesis.only[1][0]
    done = getattr(hypothesis.rules, f"{asked}_as")
    return asked, done


BY_HAND = [h for h in DECLARED_WEIGHTS if "-where-" in h.name]


def answers_with(asked, done, pass_name):
    """Answers of a pass by hand that takes one weight for another."""

    def answered(case):
        mis = case.settings.get("mis", "1/Z")
        mis = done if mis == asked else mis
        return by_hand.reuse(replace(case, settings={**case.settings, "mis": mis}))

    return [
        examined(CONTRACT, "float32", p, answered(p.case)) for p in probes(pass_name)
    ]


def check_that_it_is_named(hypothesis, pass_name):
    answers = answers_with(*done_by_hand(hypothesis), pass_name)
    assert any(not a.finding.passed for a in answers)
    found = diagnose(pass_name, answers, "float32")
    assert hypothesis in found.matches
    assert all(e.innocent == bool(hypothesis.departure) for e in found.explanations)


@pytest.mark.parametrize(
    "pass_name", ["moved", pytest.param("temporal", marks=pytest.mark.slow)]
)
def test_control_the_hand_is_right(pass_name):
    assert all(a.finding.passed for a in answers_with("", "", pass_name))


IN_MOVED = [h for h in BY_HAND if "moved" in h.passes]
SOON_IN_MOVED = ("balance-in-weights-where-balance", "one-over-m-where-pairwise")


@pytest.mark.parametrize(
    "hypothesis",
    [
        pytest.param(
            h, id=h.name, marks=() if h.name in SOON_IN_MOVED else pytest.mark.slow
        )
        for h in IN_MOVED
    ],
)
def test_weights_that_are_taken_for_others_are_named(hypothesis):
    check_that_it_is_named(hypothesis, "moved")


@pytest.mark.slow
@pytest.mark.parametrize("hypothesis", BY_HAND, ids=lambda h: h.name)
def test_weights_that_are_taken_for_others_are_named_in_all_passes(hypothesis):
    for pass_name in set(hypothesis.passes) - {"moved"}:
        check_that_it_is_named(hypothesis, pass_name)


# ---------------------------------------------------------------- mistakes


class Uneven(ForeignRenderer):
    """Densities each in its own solid angle."""

    def _there(self, p_hat, J, sees):
        return k.product(p_hat, J > 0, sees)


class ReceiverAsked(ForeignRenderer):
    """Sources are asked for the target of the receiver."""

    def _densities(self, x, s, asked, p_hat):
        y = s.y.map(lambda a: a[:, :, None])
        at = Point(*(a[:, None] for a in s.at))
        J = self._shift(x.position[:, :, None], at.position, y)
        here = self._target(asked.target, Point(*(a[:, :, None] for a in x)), y)
        return np.where(s.shifted, self._there(here, J, s.sees), p_hat[:, :, None])


class DensitiesAlone(ForeignRenderer):
    """The balance heuristic leaves out M, which the weights have."""

    def _confidence(self, M):
        return np.ones_like(M)

    def _divisor(self, rule, M, p, kept, asked):
        M = self._confidence(M) if rule == "balance" else M
        return super()._divisor(rule, M, p, kept, asked)


class DensitiesUnlessEmpty(DensitiesAlone):
    """The same, but that those who have nothing are left out."""

    def _confidence(self, M):
        return (M > 0).astype(F)


def without_share(M, p, there):
    """Defensive weights that lack what they give to the receiver's own."""
    m = pairwise(M, p, there, defensive=True)
    own = np.arange(M.shape[1]) == OWN
    has_others = (M * ~own).sum(axis=1, keepdims=True) > 0
    return m - k.quotient(M, M.sum(axis=1, keepdims=True)) * (own & has_others)


def defensive_without_own(M, p, there):
    others = np.arange(M.shape[1]) != OWN
    return np.where(others, pairwise(M, p, there, defensive=True), F(1))


class WithoutShare(ForeignRenderer):
    """The defensive weight of the canonical sample is that of its pairs."""

    first = FIRST | {"defensive": without_share}


class DefensiveWithoutOwn(ForeignRenderer):
    """Defensive weights in which the receiver's own is 1."""

    first = FIRST | {"defensive": defensive_without_own}


MISTAKES = {
    "receivers-target-in-z": ReceiverAsked,
    "balance-without-confidence": DensitiesAlone,
    "balance-without-confidence-unless-empty": DensitiesUnlessEmpty,
    "defensive-without-share": WithoutShare,
    "pairwise-own-whole": PairwiseWithoutOwn,
    "defensive-own-whole": DefensiveWithoutOwn,
    "mis-weights-without-jacobian": Uneven,
}
SOON = ("balance-without-confidence", "mis-weights-without-jacobian")


def test_every_hypothesis_is_planted_here():
    planted = {h.name for h in BY_HAND} | MISTAKES.keys()
    assert {h.name for h in DECLARED_WEIGHTS} <= planted


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in SOON else pytest.mark.slow) for n in MISTAKES],
)
def test_a_mistake_is_named(name):
    """Without the Jacobian the weights still sum to 1: another choice, and no bias."""
    right = name == "mis-weights-without-jacobian"
    verdict = verdict_on(Only(MISTAKES[name](), ("moved",)))
    assert verdict.status == ("PASS" if right else "FAIL"), told(verdict)
    assert [h.name for d in verdict.diagnoses for h in d.matches] == [name]


# What bits say of neighbours that there are not is nobody's.
IN_SPATIAL = [name for name in MISTAKES if name != "balance-without-confidence"]


@pytest.mark.slow
@pytest.mark.parametrize("name", IN_SPATIAL)
def test_a_mistake_is_named_in_pass_spatial(name):
    right = name == "mis-weights-without-jacobian"
    verdict = verdict_on(Only(MISTAKES[name](), ("spatial",)), passes=("spatial",))
    assert verdict.status == ("PASS" if right else "FAIL"), told(verdict)
    assert [h.name for d in verdict.diagnoses for h in d.matches] == [name]


@pytest.mark.slow
def test_a_jacobian_that_the_maker_alone_has_fails_with_its_term():
    """Shares no longer sum to 1."""
    verdict = verdict_on(Only(HalfJacobians(), ("moved",)), ["balance"])
    assert verdict.status == "FAIL"
    assert "the first wrong term is W" in verdict.diagnoses[0].text


# ---------------------------------------------------------------- whole runs


def runs_of(*words):
    """Weights of whole runs of those who have these."""
    run = run_of(read_declaration(has(*words)).selection)
    return run.mis, run.temporal_mis


def test_whole_runs_have_weights_that_the_backend_has():
    assert runs_of(*EVERY) == ("1/Z", "")
    assert runs_of("1/M") == ("1/M", "")
    assert runs_of("1/M", "pairwise") == ("pairwise", "")
    assert runs_of("defensive") == ("defensive", "defensive")


def ask(case):
    """The built-in passes."""
    return getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings)


@pytest.mark.parametrize("mis", MIS.more)
def test_inside_a_sphere_declared_weights_are_those_of_the_confidences(mis):
    """All but the defensive one: it counts the pixel's own samples more than once."""
    run = Run(mis=mis, temporal_mis="defensive" if mis == "defensive" else "")
    assert furnace(ask, "float32", run).passed
    assert half_lit(ask, "float32", run).passed == run.counts == (mis != "defensive")


def test_control_a_share_that_is_wrong_is_seen_in_a_sphere(monkeypatch):
    right = reuse_pairwise._share
    monkeypatch.setattr(
        reuse_pairwise,
        "_share",
        lambda M_a, p_a, M_b, p_b: right(M_a, p_a, M_b * np.float32(0.99), p_b),
    )
    assert not furnace(ask, "float32", Run(mis="pairwise")).passed


@pytest.mark.parametrize(
    "mis", ["defensive", pytest.param("balance", marks=pytest.mark.slow)]
)
def test_whole_runs_ask_for_the_weights_that_there_are(mis):
    backend = WeightsListener()
    only = Selection(only=frozenset({"direction", "temporal", "spatial", "shade"}))
    verdict = judge(
        backend, 300, statistics=False, declaration=has(mis), selection=only
    )
    assert verdict.status == "PASS", told(verdict)
    assert {m for name, m in backend.asked if name == "spatial"} == {mis}
    titles = [t.step.title for t in verdict.steps if t.step.findings]
    assert "spheres" in titles
    assert ("half-lit sphere of 40 frames" in titles) == (mis == "balance")
