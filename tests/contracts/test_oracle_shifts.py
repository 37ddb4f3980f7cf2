"""The passes of path shifts: who is right passes, and mistakes are found and named."""

import re
from collections import Counter
from dataclasses import replace
from functools import cache, partial
from types import SimpleNamespace

import numpy as np
import pytest

from restir_gi.extensions.oracle.shifts import part as module
from restir_gi.extensions.oracle.shifts.cases import PLACES, shift_case
from restir_gi.extensions.oracle.shifts.part import PART
from restir_gi.extensions.oracle.shifts.scenes import frame_of
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Failure, refused
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.contract.fields import dtype_of
from restir_gi.reference.oracle.diagnosis.diagnose import diagnose
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.parts import parts
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from tests.contracts.path_shifts import OTHERS, PLANTED, length

PASSES = {p.name: p for p in PART.passes}


both_precisions = pytest.mark.parametrize("precision", ["float32", "float64"])
every_pass = pytest.mark.parametrize("name", PASSES)


@cache
def probes(precision):
    """All questions."""
    return [*PART.probes(precision), *PART.frames(precision, frozenset(PASSES))]


def of_pass(precision, name):
    return [p for p in probes(precision) if p.case.pass_name == name]


def answers(precision, name, backend):
    """What a backend gives, and what is found in it."""
    found = []
    for probe in of_pass(precision, name):
        with np.errstate(all="ignore"):
            out = backend(**probe.case.inputs, **probe.case.settings)
        found.append(examined(PASSES, precision, probe, out))
    return found


QUICK = {"earlier", "length", "old share"}


def slow_unless(quick, *values):
    marks = () if quick else (pytest.mark.slow,)
    return pytest.param(*values, marks=marks, id="-".join(values[-1]))


MISTAKES = [
    slow_unless(n != "shift" or m in QUICK, n, m, known, (n, m))
    for n, all in PLANTED.items()
    for m, known in all.items()
]
PAIRS = [
    slow_unless(name != "shift", h, name, (h.name, name))
    for h in PART.hypotheses
    for name in h.passes
]


def other(precision, name, mistake=None):
    """The other backend, perhaps with a mistake."""
    real = {"float32": np.float32, "float64": np.float64}[precision]
    return partial(OTHERS[name], real, mistake)


# ------------------------------------------------ tests


@both_precisions
@every_pass
def test_the_production_code_passes(precision, name):
    found = answers(precision, name, getattr(BuiltIn(precision), name))
    assert found
    assert [a.finding.text for a in found if not a.finding.passed] == []


@both_precisions
@every_pass
def test_another_order_of_operations_passes(precision, name):
    found = answers(precision, name, other(precision, name))
    assert [a.finding.text for a in found if not a.finding.passed] == []


@both_precisions
def test_no_row_of_a_scene_is_open(precision):
    """Else mistakes could hide there."""
    found = answers(precision, "shift", other(precision, "shift"))
    assert sum(a.finding.judgement.decisions.expected for a in found) == 0


def test_just_beside_its_thresholds_nothing_is_open():
    """A third of the rows is on a threshold."""
    (found,) = (
        a.finding.judgement
        for a in answers("float32", "joinable", other("float32", "joinable"))
        if a.probe.case.name == "joinable-thresholds"
    )
    given = found.terms["exact"]
    assert found.decisions.expected < 0.45 * len(given)
    assert 0.2 < given.mean() < 0.8


@pytest.mark.parametrize(("name", "mistake", "known", "_"), MISTAKES)
def test_a_planted_mistake_is_found_and_named(name, mistake, known, _):
    found = answers("float32", name, other("float32", name, mistake))
    assert not all(a.finding.passed for a in found)
    if known:
        matches = [h.name for h in diagnose(name, found, "float32").matches]
        assert matches == [known]


@both_precisions
@pytest.mark.parametrize(
    ("beside", "allowed"), [(-(2.0**-12), (1,)), (0.0, (0, 1)), (2.0**-12, (0,))]
)
def test_at_a_threshold_a_path_may_exist_or_not(precision, beside, allowed):
    """The least distance is that of a joint, or just beside it."""
    case = of_pass(precision, "shift")[1].case
    out = other(precision, "shift")(**case.inputs, **case.settings)
    row = np.flatnonzero((out["why"] == "joined") & (case.inputs["joint"] == 2))[:1]
    inputs = {name: array[row] for name, array in case.inputs.items()}
    way = (inputs["joint_position"] - inputs["position"][:, 0]).astype(float)
    least = float(length(way) * (1 + beside)) / case.settings["extent"]
    at = replace(
        case, inputs=inputs, settings=case.settings | {"least_distance": least}
    )
    for exists in (0, 1):
        told = {n: out[n][row] * exists for n in ("value", "jacobian")}
        found = PART.judges["shift"](at, told, CONTRACT_RULES, precision)
        assert found.passed == (exists in allowed)


def test_everything_happens():
    why = Counter()
    for probe in of_pass("float64", "shift"):
        found = other("float64", "shift")(**probe.case.inputs, **probe.case.settings)
        joint, end = probe.case.inputs["joint"], probe.case.inputs["end"]
        technique, words = probe.case.inputs["technique"], found["why"]
        for row in zip(words, joint, joint == end, technique, strict=True):
            why[row[0]] += 1
            why[row] += 1
    reasons = ("earlier", "before", "later", "length", "hidden", "horizon")
    assert all(why[reason] >= 10 for reason in (*reasons, "black", "no replays"))
    for joint in (2, 3, 4):
        assert why["joined", joint, True, 1] >= 3
    assert why["joined", 2, True, 2] >= 10
    assert why["joined", 2, False, 1] >= 10
    assert why["replayed", 0, False, 1] >= 10
    assert why["replayed", 0, False, 2] >= 10


@every_pass
def test_the_cases_have_what_the_contract_asks_for(name):
    wanted = PASSES[name]
    for precision in ("float32", "float64"):
        for probe in of_pass(precision, name):
            case = probe.case
            assert list(case.settings) == [s.name for s in wanted.settings]
            assert list(case.inputs) == [f.name for f in wanted.inputs]
            assert re.fullmatch(r"[a-z0-9-]+", case.name)
            slots = int(case.settings.get("bounces", 0)) + 1
            for field in wanted.inputs:
                array = case.inputs[field.name]
                columns = [slots if c == "V" else c for c in field.columns]
                assert array.shape == (case.rows, *columns)
                assert array.dtype == dtype_of(field.kind, precision)
                assert array.dtype.kind != "f" or np.isfinite(array).all()


@every_pass
def test_wrong_shapes_and_types_are_told(name):
    probe = of_pass("float32", name)[-1]
    right = getattr(BuiltIn("float32"), name)(
        **probe.case.inputs, **probe.case.settings
    )
    assert refused(PASSES, probe.case, "float32", right) is None
    for field, array in right.items():
        for wrong in (array[:-1], array.astype(np.float64), np.stack([array] * 2)):
            bad = refused(PASSES, probe.case, "float32", right | {field: wrong})
            assert isinstance(bad, Failure)
            assert field in bad.reason
        without = {n: a for n, a in right.items() if n != field}
        assert "missing" in refused(PASSES, probe.case, "float32", without).reason


def test_the_cases_are_always_the_same():
    place, again = PLACES[2], shift_case.__wrapped__
    first = shift_case(place, "float32")
    frame_of.cache_clear()
    second = again(place, "float32")
    assert first.settings == second.settings
    for name, array in first.inputs.items():
        assert array.tobytes() == second.inputs[name].tobytes()


@pytest.mark.parametrize(("h", "name", "_"), PAIRS)
def test_a_hypothesis_is_no_other_name_for_the_contract(h, name, _):
    """What it expects is refused by the contract, and by itself is not."""
    judge_pass, told = PART.judges[name], []
    for probe in of_pass("float32", name):
        case = probe.case
        nothing = getattr(BuiltIn("float32"), name)(**case.inputs, **case.settings)
        expected = judge_pass(case, nothing, h.rules, "float32").compared
        out = {c.name: c.expected.astype(nothing[c.name].dtype) for c in expected}
        told.append(
            [
                judge_pass(case, out, rules, "float32").passed
                for rules in (CONTRACT_RULES, h.rules)
            ]
        )
    by_contract, by_itself = zip(*told, strict=True)
    assert not all(by_contract)
    assert all(by_itself)


def test_a_backend_without_these_passes_is_not_waited_for(monkeypatch):
    """No frame is made for it."""

    def never(place, precision):
        raise AssertionError

    monkeypatch.setattr(module, "shift_case", never)
    backend = SimpleNamespace(
        checkerboard=lambda **inputs: {"draws": inputs["has_history"]}
    )
    verdict = judge(InsideBackend(backend), 60.0, statistics=False)
    assert {"joinable", "path_jacobian", "shift"} <= set(verdict.absent)


def test_it_is_registered():
    assert PART in parts()
