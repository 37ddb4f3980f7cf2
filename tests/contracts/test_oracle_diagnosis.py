"""Diagnosis: what reproduces all answers is named, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.numerics.arrays import normalize
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.diagnosis.diagnose import HYPOTHESES, diagnose
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import Answer, Finding, examined
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.oracle.replay.bounded import exact, rounding_of
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.scene.catalogue.registry import find_scene

CONTRACT = whole_contract()

WITHOUT_CHOICE = (
    "jacobian",
    "target",
    "finalize",
    "merge",
    "direction",
    "initial",
    "shade",
)
"""Passes whose outputs a hypothesis gives outright."""


@pytest.fixture(scope="module")
def probes():
    found = [p for p in kernel_probes("float32") if "extremes" not in p.case.name]
    for scene in ("cornell-box", "door-ajar"):
        at = prepare_frame(find_scene(scene), 24, 1)
        found += [replayed("L3", case) for case in frame_cases(at, "float32")]
    return found


def right(case):
    return dict(getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings))


def answered(probes, pass_name, answer):
    chosen = [p for p in probes if p.case.pass_name == pass_name]
    return [examined(CONTRACT, "float32", p, answer(p.case)) for p in chosen]


def directions(case, rules):
    """Directions about any normal, drawn as the rules have it."""
    u = exact(case.inputs["u"], rounding_of("float32"))
    source, n = case.settings["source"], case.inputs["visible_normal"].astype(float)
    cosine = rules.drawn_cosine(source, u[:, 0])
    phi = rules.turn * u.value[:, rules.azimuth_number]
    away = np.where(np.abs(n[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    t = normalize(np.cross(away, n))
    sine = np.sqrt(np.maximum(1 - cosine.value**2, 0))
    flat = np.cos(phi)[:, None] * t + np.sin(phi)[:, None] * np.cross(n, t)
    up = (-cosine.value if rules.inward else cosine.value)[:, None] * n
    return {
        "direction": (sine[:, None] * flat + up).astype(np.float32),
        "pdf": rules.density(source, cosine).value.astype(np.float32),
    }


def under(hypothesis):
    """Answers of a backend that makes the mistake: what its own replay expects."""

    def answer(case):
        if case.pass_name == "direction":
            return directions(case, hypothesis.rules)
        out = right(case)
        judgement = JUDGES[case.pass_name](case, out, hypothesis.rules, "float32")
        for one in judgement.compared:
            if one.name in out:
                wanted = np.clip(one.expected, -3e38, 3e38)
                out[one.name] = wanted.astype(out[one.name].dtype)
        return out

    return answer


PAIRS = [
    (h, name)
    for h in HYPOTHESES
    if h.only is None  # those of declared surfaces show in no case here
    for name in h.passes
    if name in WITHOUT_CHOICE
]


@pytest.mark.parametrize(
    ("hypothesis", "pass_name"), PAIRS, ids=[f"{h.name}-{name}" for h, name in PAIRS]
)
def test_a_planted_mistake_is_named(probes, hypothesis, pass_name):
    answers = answered(probes, pass_name, under(hypothesis))
    found = diagnose(pass_name, answers, "float32")
    shows = any(not a.finding.passed for a in answers)
    if shows:
        assert hypothesis in found.matches
        assert len(found.matches) <= 2, [h.name for h in found.matches]
    else:
        assert found.matches == ()


HIDDEN = {
    ("jacobian-receiver-cosine", "jacobian"),  # which is given no such normal
    # A path that was traced meets the lit side, above the horizon.
    ("back-left-to-the-jacobian", "initial"),
    ("light-below-the-horizon", "initial"),
    ("outgoing-without-horizon", "initial"),
    ("pure-colours-are-null", "initial"),  # and these scenes have none
    ("weight-cut-at-10", "initial"),  # nor so large a weight
    # Nor has any sample so small a target.
    ("divisor-at-least-1e-06", "initial"),
    ("target-at-least-1e-06", "initial"),
    ("scattered-at-least-1e-06", "initial"),
}


def test_every_other_mistake_shows(probes):
    """Else the test above would prove nothing."""
    hidden = {
        (h.name, name)
        for h, name in PAIRS
        if all(a.finding.passed for a in answered(probes, name, under(h)))
    }
    assert hidden == HIDDEN


@pytest.mark.parametrize("pass_name", sorted(CONTRACT))
def test_nothing_is_named_where_nothing_is_wrong(probes, pass_name):
    answers = answered(probes, pass_name, right)
    assert diagnose(pass_name, answers, "float32").matches == ()


@pytest.mark.parametrize("pass_name", WITHOUT_CHOICE)
def test_what_nobody_has_done_before_is_not_named(probes, pass_name):
    """An odd factor on the last output is no known mistake."""

    def odd(case):
        out = right(case)
        name = next(n for n, a in reversed(out.items()) if a.dtype.kind == "f")
        out[name] = out[name] * np.float32(0.8765)
        return out

    answers = answered(probes, pass_name, odd)
    assert any(not a.finding.passed for a in answers)
    assert diagnose(pass_name, answers, "float32").matches == ()


def test_two_mistakes_at_once_are_not_one_of_them(probes):
    by_name = {h.name: h for h in HYPOTHESES}
    pi = under(by_name["shade-without-pi"])

    def both(case):
        return {"color": pi(case)["color"] * case.inputs["albedo"]}

    answers = answered(probes, "shade", both)
    assert diagnose("shade", answers, "float32").matches == ()


@pytest.mark.parametrize("pass_name", ["jacobian", "temporal", "spatial"])
def test_what_the_contract_explains_has_no_name(probes, pass_name):
    """Right answers beside a fault of another kind, as NaN in another case."""
    fault = Finding(False, "crashed")
    answers = [replace(a, finding=fault) for a in answered(probes, pass_name, right)]
    assert diagnose(pass_name, answers, "float32").matches == ()


def test_without_answers_there_is_no_name():
    assert diagnose("shade", [], "float32").matches == ()
    nobody = [Answer(kernel_probes("float32")[0], None, None)]
    assert diagnose("random", nobody, "float32").matches == ()
