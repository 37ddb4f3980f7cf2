"""Targets as data: who takes them as they are passes, who does not fails."""

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32, FLOAT64
from restir_gi.reference.oracle.checking import judge, told
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.levels.given_targets import given_target_probes
from restir_gi.reference.oracle.levels.lattice import enumerations_for
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.thresholds import own_expectation
from restir_gi.reference.oracle.parts import whole_contract
from tests.foreign import kernels as k
from tests.foreign.kernels import F
from tests.foreign.renderer import ForeignRenderer

CONTRACT = whole_contract()
EVERY = ["1/M", "1/Z", "balance", "pairwise", "defensive"]
PASSES = ("initial", "temporal", "moved", "spatial", "fused")


class GivenTargets(ForeignRenderer):
    """A renderer of its own that takes its targets from a buffer.

    It asks for all targets of a row at once: (N, C) at the receiver, and (N, C, C) with
    a row for each sample and a column for each source.
    """

    def moved(self, p_hat_given, **given):
        """The past's sample is the first candidate, and its point the first source."""
        p = p_hat_given[:, :, ::-1]
        self.here, self.there = p[:, 0], np.stack([p[:, 1], p[:, 0]], axis=2)
        return super().moved(**given)

    def spatial(self, p_hat_given, **given):
        """The past, the pixel's own, the neighbours."""
        p = np.concatenate([p_hat_given[:, :, -1:], p_hat_given[:, :, :-1]], axis=2)
        self.here = p[:, 0]
        self.there = np.concatenate([p[:, :1], p], axis=1).transpose(0, 2, 1)
        return super().spatial(**given)

    def _target(self, asked, x, y):
        if y.position.ndim == 2:
            return np.ones(len(y.position), F)  # nobody looks at it
        return self.there if y.position.ndim == 4 else self.here


class Calculated(GivenTargets):
    """The target at the receiver is calculated, as if the surface were diffuse."""

    def _target(self, asked, x, y):
        found = super()._target(asked, x, y)
        if y.position.ndim != 3:
            return found
        above, facing = k.cosines(x, y, self.options.normalize)
        return np.where((above > 0) & (facing > 0), k.LUMINANCES["709"](y.radiance), 0)


class ReceiversTargets(GivenTargets):
    """Sources are asked for the target of the receiver."""

    def _target(self, asked, x, y):
        found = super()._target(asked, x, y)
        return (
            np.repeat(self.here[:, :, None], found.shape[2], 2)
            if (found.ndim == 3)
            else found
        )


class Exchanged(GivenTargets):
    """Points and samples are exchanged in the buffer."""

    def moved(self, p_hat_given, **given):
        """The buffer is read the other way round."""
        return super().moved(p_hat_given.transpose(0, 2, 1), **given)


def found_by(backend, pass_name, precision="float32"):
    """Findings of all cases of a pass."""
    found = []
    for probe in given_target_probes(precision):
        case = probe.case
        if case.pass_name == pass_name:
            out = getattr(backend, pass_name)(**case.inputs, **case.settings)
            found.append(examined(CONTRACT, precision, probe, out).finding)
    return found


@pytest.mark.parametrize("pass_name", PASSES)
@pytest.mark.parametrize("backend", [FLOAT32, FLOAT64], ids=["float32", "float64"])
def test_the_built_in_passes_are_right(backend, pass_name):
    found = found_by(backend, pass_name, backend.precision)
    assert found
    assert [f.text for f in found if not f.passed] == []


@pytest.mark.parametrize("pass_name", ["moved", "spatial"])
def test_a_foreign_renderer_is_right(pass_name):
    found = found_by(GivenTargets(), pass_name)
    assert [f.text for f in found if not f.passed] == []


@pytest.mark.parametrize("mistake", [Calculated, ReceiversTargets])
@pytest.mark.parametrize("pass_name", ["moved", "spatial"])
def test_a_mistake_is_found(mistake, pass_name):
    assert not all(f.passed for f in found_by(mistake(), pass_name))


def test_points_and_samples_are_not_exchanged():
    assert not all(f.passed for f in found_by(Exchanged(), "moved"))


@pytest.mark.parametrize(
    "has",
    [
        pytest.param({"neighbors": [1]}, marks=pytest.mark.slow),
        pytest.param({}, marks=pytest.mark.slow),
    ],
)
def test_who_has_no_other_target_is_asked_on_all_levels(has):
    """Lattices, frames and whole runs, whose targets are the contract's, given."""
    loop = ("direction", *PASSES, "shade")
    table = {
        "schema": "restir-declaration 1",
        "has": {"passes": list(loop), "target": ["data"], **has},
    }
    verdict = judge("float32", 300, statistics=False, declaration=table)
    assert verdict.status == "PASS", told(verdict)
    answers = [a for t in verdict.steps for a in t.step.answers if a.outputs]
    levels = {a.probe.level for a in answers if a.probe.case.pass_name == "spatial"}
    assert levels == {"L1", "L3"}
    words = [a.probe.case.settings.get("target", "data") for a in answers]
    assert set(words) == {"data"}
    asked = {name for t in verdict.steps for f in t.step.findings for name in f.asked}
    assert {"temporal", "spatial"} <= asked


def test_the_mean_is_right_with_targets_as_data():
    """Summed over all outcomes and the backend's own decisions."""
    has = {"target": ["data"], "neighbors": [1], "mis": ["1/Z"]}
    table = {"schema": "restir-declaration 1", "has": has}
    for e in enumerations_for(read_declaration(table).selection):
        if e.settings.get("mis") == "1/M":
            continue
        found = integrated(own_expectation(e, "float64"))
        assert found.passed, found.text


def integrated(search):
    """What a search finds of the built-in passes, which are given all targets."""
    sent = None
    while True:
        try:
            case = search.send(sent)
        except StopIteration as end:
            return end.value
        assert "p_hat_given" in case.inputs
        sent = getattr(FLOAT64, case.pass_name)(**case.inputs, **case.settings)


class OnlyMoved:
    """Pass moved of a renderer, and no other."""

    precision = "float32"

    def __init__(self, renderer):
        self.moved = renderer.moved


def verdict_on(renderer):
    has = {"target": ["data"], "mis": EVERY}
    table = {"schema": "restir-declaration 1", "has": has}
    only = Selection(only=frozenset({"moved"}))
    return judge(
        OnlyMoved(renderer), 300, statistics=False, declaration=table, selection=only
    )


def test_the_verdict_of_who_has_no_other_target():
    verdict = verdict_on(GivenTargets())
    assert verdict.status == "PASS", told(verdict)
    asked = {
        a.probe.case.settings["target"]
        for t in verdict.steps
        for a in t.step.answers
        if a.outputs is not None
    }
    assert asked == {"data"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mistake", "text"),
    [(ReceiversTargets, "receivers-target-in-z"), (Calculated, "first wrong term")],
)
def test_the_verdict_names_a_mistake_or_its_term(mistake, text):
    verdict = verdict_on(mistake())
    assert verdict.status == "FAIL"
    assert text in verdict.diagnoses[0].text
