"""A part of the contract that another package registers: asked, judged and named."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from restir_gi.reference.oracle import parts as module
from restir_gi.reference.oracle import steps
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.contract.fields import Pass, real
from restir_gi.reference.oracle.declaration.choices import catalogue
from restir_gi.reference.oracle.declaration.schema import declaration_schema
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake
from restir_gi.reference.oracle.golden import expected
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import Part, parts, whole_contract
from restir_gi.reference.oracle.replay.bounded import constant, exact, rounding_of
from restir_gi.reference.oracle.replay.judgement import Judgement, beside
from restir_gi.reference.system.errors import UsageError

DOUBLED = Pass(
    name="doubled",
    summary="Twice a number",
    formula="y = 2 x",
    inputs=(real("x", "any"),),
    outputs=(real("y", "twice as much"),),
)


def judge_doubled(case, outputs, rules, precision):
    x = exact(case.inputs["x"], rounding_of(precision))
    factor = 2.0 if rules.part is None else rules.part
    return Judgement((beside("y", outputs["y"], x * constant(factor, x)),))


def probes(precision, seed=1):
    x = {"x": np.arange(1, 9).astype(precision)}
    return [
        replayed(level, Case(f"doubled-{level}", "doubled", {}, x))
        for level in ["L0", "L3"]
    ]


PART = Part(
    title="doubling",
    passes=(DOUBLED,),
    judges={"doubled": judge_doubled},
    own={"doubled": lambda precision, x: {"y": x * x.dtype.type(2)}},
    probes=probes,
    hypotheses=(
        mistake(
            "tripled", "three for two", "y = 3 x", "y = 2 x", ("doubled",), part=3.0
        ),
    ),
)


def forget_parts():
    """What was read of the parts is read again: all that is kept of their mistakes."""
    for kept in (parts, catalogue, declaration_schema):
        kept.cache_clear()


def register(monkeypatch, *found):
    points = [
        SimpleNamespace(name=f"p{i}", load=lambda part=part: part)
        for i, part in enumerate(found)
    ]
    monkeypatch.setattr(module, "entry_points", lambda group: points)
    forget_parts()


@pytest.fixture
def registered(monkeypatch):
    register(monkeypatch, PART)
    yield
    forget_parts()


@pytest.fixture(autouse=True)
def _afterwards():
    yield
    forget_parts()


def doubling(factor):
    backend = SimpleNamespace(doubled=lambda x: {"y": x * np.float32(factor)})
    return judge(InsideBackend(backend), 60.0, statistics=False)


def asked(verdict):
    return [
        (timed.step.level, timed.step.title)
        for timed in verdict.steps
        if any(a.probe.case.pass_name == "doubled" for a in timed.step.answers)
    ]


@pytest.mark.usefixtures("registered")
def test_it_is_asked_on_its_rungs_and_passes():
    verdict = doubling(2)
    assert verdict.status == "PASS"
    assert asked(verdict) == [("L0", "doubling"), ("L3", "doubling")]
    assert "doubled" not in verdict.absent
    assert "gbuffer" in verdict.absent


@pytest.mark.usefixtures("registered")
def test_its_mistakes_are_named():
    verdict = doubling(3)
    assert verdict.status == "FAIL"
    (found,) = verdict.diagnoses
    assert [h.name for h in found.matches] == ["tripled"]


@pytest.mark.usefixtures("registered")
def test_what_is_no_known_mistake_has_no_name():
    (found,) = doubling(4).diagnoses
    assert found.matches == ()


@pytest.mark.usefixtures("registered")
def test_it_is_in_the_contract():
    assert list(whole_contract())[-1] == "doubled"


def test_two_parts_cannot_have_the_same_pass(monkeypatch):
    register(monkeypatch, PART, replace(PART, title="again"))
    with pytest.raises(UsageError, match="several parts have a pass doubled"):
        parts()


def test_the_core_is_not_replaced(monkeypatch):
    register(monkeypatch, replace(PART, passes=(replace(DOUBLED, name="merge"),)))
    with pytest.raises(UsageError, match="several parts have a pass merge"):
        parts()


def test_what_is_no_part_is_refused(monkeypatch):
    register(monkeypatch, "no part")
    with pytest.raises(UsageError, match=r"p0 of restir\.passes is str"):
        parts()


def test_golden_outputs_of_the_further_passes_are_those_of_the_backend():
    for part in parts():
        for probe in part.probes("float64"):
            case = probe.case
            own = getattr(FLOAT32, case.pass_name)
            assert set(expected(case, "float64")) == set(
                own(**case.inputs, **case.settings)
            )


class Scribbler:
    """Right, and careless with what it was given."""

    precision = "float32"

    def __getattr__(self, pass_name):
        if pass_name not in whole_contract():
            raise AttributeError(pass_name)

        def answer(**given):
            outputs = dict(getattr(FLOAT32, pass_name)(**given))
            outputs = {name: np.array(array) for name, array in outputs.items()}
            for value in given.values():
                if isinstance(value, np.ndarray):
                    value.fill(0)
            return outputs

        return answer


def test_what_a_backend_writes_into_its_inputs_is_nobody_elses():
    probes = kernel_probes("float32")
    before = [{k: a.copy() for k, a in p.case.inputs.items()} for p in probes]
    backend = InsideBackend(Scribbler())
    answers = steps.asked("L0", "all", whole_contract(), backend, probes).answers
    assert all(one.finding.passed for one in answers)
    for probe, inputs in zip(probes, before, strict=True):
        for name, array in inputs.items():
            np.testing.assert_array_equal(probe.case.inputs[name], array)
