"""Renderers in the manner of others, judged against what they declare."""

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.checking import judge, told
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.ladder import golden_levels
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import run_ladder
from tests.foreign.backends import DECLARED, RIGHT, WRONG, Only
from tests.foreign.declared import declaration_of
from tests.foreign.mistakes import (
    ClampedJacobian,
    OneNumber,
    PairwiseWithoutM,
    PairwiseWithoutOwn,
    RefusedThenClamped,
)
from tests.foreign.renderer import FIRST, ForeignRenderer

CONTRACT = whole_contract()
BUDGET = 300.0

QUICK = {"own first, cap on arrival: RTXDI temporal"}

OF_RENDERERS = [one for one in RIGHT if type(one.renderer) is ForeignRenderer]


def named(backends, quick):
    """Parameters of a test, most of them slow."""
    return [
        pytest.param(one, id=one.name, marks=() if quick(one) else pytest.mark.slow)
        for one in backends
    ]


def verdict_on(foreign, declaration):
    """Verdict without whole runs."""
    about = {"statistics": False, "declaration": declaration}
    return judge(foreign.backend, BUDGET, **about)


@pytest.mark.parametrize("foreign", named(OF_RENDERERS, lambda f: f.name in QUICK))
def test_what_is_declared_is_followed(foreign):
    verdict = verdict_on(foreign, declaration_of(foreign.renderer))
    assert verdict.status == "PASS", told(verdict)
    assert {one.state for one in verdict.followed} <= {"followed", "not shown"}
    assert [one.undeclared for one in verdict.followed if one.undeclared] == []
    declared = {one.pass_name for one in verdict.followed}
    assert {d.pass_name for d in verdict.departures} <= declared
    assert verdict.biases == []


@pytest.mark.slow
def test_visibility_in_the_shading_is_followed():
    (foreign,) = DECLARED
    declared = declaration_of(foreign.renderer, visibility="shading")
    verdict = verdict_on(foreign, declared)
    assert verdict.status == "PASS", told(verdict)
    assert {one.state for one in verdict.followed} == {"followed"}


OWN = {"schema": "restir-declaration 1", "choices": {"mis": "own"}}


class PowerHeuristic(ForeignRenderer):
    """MIS weights that the project has no name for, and that sum to 1."""

    @staticmethod
    def _squares(M, p, there):
        mine = (M * np.diagonal(p, axis1=1, axis2=2)).astype(float) ** 2
        every = ((M[:, None] * p).astype(float) ** 2).sum(axis=2)
        return np.divide(mine, every, out=mine * 0, where=every > 0).astype(np.float32)

    def __init__(self):
        super().__init__(mis="power")
        self.first = FIRST | {"power": self._squares}


def test_weights_that_nobody_knows_are_judged_by_their_mean():
    backend = Only(PowerHeuristic(), ("moved",))
    verdict = judge(backend, BUDGET, statistics=False, declaration=OWN)
    assert verdict.status == "PASS", told(verdict)
    assert [one.state for one in verdict.followed] == ["followed"]


@pytest.mark.slow
def test_control_weights_that_nobody_knows_and_nobody_declares_fail():
    backend = Only(PowerHeuristic(), ("moved",))
    assert judge(backend, BUDGET, statistics=False).status == "FAIL"


@pytest.mark.slow
def test_weights_that_nobody_knows_want_level_one():
    """Golden cases have none, and what they leave open is told."""
    cases = [p for p in row_probes("float32") if p.case.pass_name == "moved"]
    backend = InsideBackend(Only(PowerHeuristic(), ("moved",)))
    levels = golden_levels(CONTRACT, backend, cases)
    said = read_declaration(OWN)
    about = {"clock": lambda: 0.0, "tell": lambda title: None, "declaration": said}
    verdict = run_ladder(CONTRACT, "float32", levels, BUDGET, **about)
    assert verdict.status == "FAIL"
    assert "level L1 alone can judge: it was not asked" in told(verdict)


@pytest.mark.slow
@pytest.mark.parametrize("mistake", [PairwiseWithoutM, PairwiseWithoutOwn, OneNumber])
def test_weights_that_nobody_knows_hide_no_bias(mistake):
    backend = Only(mistake(mis="pairwise"), ("moved", "spatial"))
    verdict = judge(backend, BUDGET, statistics=False, declaration=OWN)
    assert verdict.status == "FAIL"


RTXDI = next(one for one in RIGHT if one.name.endswith("RTXDI temporal"))


def test_other_choices_without_a_bias_are_told_and_pass():
    verdict = verdict_on(RTXDI, declaration_of(RTXDI.renderer, cap="both"))
    assert verdict.status == "PASS"
    (one,) = (f for f in verdict.followed if f.pass_name == "moved")
    assert one.state == "otherwise"
    assert "moved declares own-first, capped-twice, but its rows" in one.text
    assert "they are those of" in one.text


def test_what_nobody_does_is_told_and_passes():
    plain = next(one for one in RIGHT if one.name == "only kernels")
    declared = declaration_of(plain.renderer, target={"luminance": "rec601"})
    verdict = verdict_on(plain, declared)
    assert verdict.status == "PASS"
    (one,) = verdict.followed
    assert one.text.endswith("they are those of the contract")


INNOCENT = {"order": "own-first", "cap": "past on arrival"}


@pytest.mark.parametrize("foreign", named(WRONG, lambda one: one is WRONG[0]))
def test_the_wrong_fail_whatever_innocence_they_declare(foreign):
    options = getattr(foreign.renderer, "options", None)
    own = declaration_of(foreign.renderer)["choices"] if options else {}
    declared = {"schema": "restir-declaration 1", "choices": INNOCENT | own}
    verdict = verdict_on(foreign, declared)
    assert verdict.status == "FAIL"
    assert verdict.biases == []


CLAMPED = Only(ClampedJacobian(), ("jacobian", "moved"))


def clamp(most, *accept):
    """The declaration of a clamp to [1 / most, most]."""
    choices = {"jacobian": {"clamped": [f"1/{most}", most]}}
    schema = "restir-declaration 1"
    return {"schema": schema, "accept": list(accept), "choices": choices}


def judged(declaration):
    """Verdict on the renderer that clamps J to [1/3, 3]."""
    return judge(CLAMPED, BUDGET, statistics=False, declaration=declaration)


def test_a_clamp_passes_where_it_is_accepted_alone():
    verdict = judged(clamp(3))
    assert verdict.status == "FAIL"
    assert not verdict.wrong
    assert "biased by design" in told(verdict)
    assert 'accept = ["jacobian-clamped-to-3"]' in told(verdict)
    verdict = judged(clamp(3, "jacobian-clamped"))
    assert verdict.status == "PASS", told(verdict)
    assert {one.pass_name for one in verdict.biases} == set(vars(CLAMPED))
    assert all(one.accepted for one in verdict.biases)


@pytest.mark.parametrize("most", [2, 4])
def test_another_clamp_than_the_declared_one_fails(most):
    verdict = judged(clamp(most, "jacobian-clamped"))
    assert verdict.status == "FAIL"
    assert verdict.wrong
    assert verdict.biases == []


@pytest.mark.slow
def test_refused_and_clamped_as_declared_passes():
    backend = Only(RefusedThenClamped(), ("moved", "spatial"))
    limits = {"refused": [0.1, 10], "clamped": ["1/3", 3]}
    accept = ["jacobian-rejected-beyond-10", "jacobian-clamped"]
    declared = declaration_of(ForeignRenderer(), accept, jacobian=limits)
    verdict = judge(backend, BUDGET, statistics=False, declaration=declared)
    assert verdict.status == "PASS", told(verdict)
