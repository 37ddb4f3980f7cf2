"""Level L1: expectations of a backend's own distribution, right ones and wrong ones."""

import re

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.contract.registry import CONTRACT
from restir_gi.reference.oracle.levels.enumeration import enumerations
from restir_gi.reference.oracle.levels.expectation import rounding_room
from restir_gi.reference.oracle.levels.lattice import lattice_probes, lattice_step
from restir_gi.reference.oracle.levels.patches import (
    CLOSE_NEIGHBORS,
    FAR_NEIGHBORS,
    NEAR,
    SEES,
    theory,
)
from tests.contracts.resamplers import Resampler

RIGHT = {
    "of the contract": {},
    "by the balance heuristic": {"weights": "balance"},
    "in pairs": {"weights": "pairwise"},
    "two at a time": {"weights": "chained", "order": "own first"},
    "backwards": {"order": "reversed"},
    "own first": {"order": "own first"},
    "u as 1 - u": {"turned": True},
    "with the outgoing target": {"target": "outgoing"},
    "all at once": {
        "weights": "balance",
        "order": "reversed",
        "turned": True,
        "target": "outgoing",
    },
}
LIMITS = [f"{side} {limit}" for side in ("J", "1/J", "refused") for limit in (3, 10)]
MISTAKES = ["a thousandth", "hidden", "canonical"]


class Counted(InsideBackend):
    """Counts batches, and rows of the largest case."""

    def __init__(self, target):
        super().__init__(target)
        self.batches, self.most = 0, 0

    def run(self, passes, cases):
        """Outcome of each case."""
        self.batches += 1
        self.most = max(self.most, *(case.rows for case in cases))
        return super().run(passes, cases)


def findings(backend):
    step = lattice_step(CONTRACT, InsideBackend(backend))
    return {a.probe.case.name: a.finding for a in step.answers if a.finding}


def faults(backend):
    return {name: f.text for name, f in findings(backend).items() if not f.passed}


@pytest.mark.parametrize("name", RIGHT)
@pytest.mark.few(3)
def test_right_weights_and_orders_have_the_right_expectation(name):
    """To the rounding of one contribution and of its thresholds."""
    found = findings(Resampler(**RIGHT[name]))
    assert [f.text for f in found.values() if not f.passed] == []
    errors = [
        float(re.search(r"to (\S+) of a patch$", f.text)[1])
        for f in found.values()
        if f.text
    ]
    assert all(error < 4 * rounding_room("float32") for error in errors)
    assert bool(errors) == (name != "of the contract")


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("name", RIGHT)
def test_a_bias_is_refuted_whatever_else_is_different(name, mistake):
    found = faults(Resampler(**RIGHT[name], mistake=mistake))
    passes = ["moved", "spatial"] if mistake == "hidden" else CHOOSING
    for pass_name in passes:
        text = found[f"lattice-{pass_name}"]
        assert "E[W 1(y = x)]" in text
        if mistake == "a thousandth":
            assert "(+0.1 %)" in text


CHOOSING = ["temporal", "moved", "spatial"]


@pytest.mark.parametrize("mistake", LIMITS)
@pytest.mark.parametrize("name", ["of the contract", "by the balance heuristic"])
def test_limits_of_the_jacobian_are_refuted(name, mistake):
    found = faults(Resampler(**RIGHT[name], mistake=mistake))
    for pass_name in ("moved", "spatial"):
        assert "E[W 1(y = x)]" in found[f"lattice-{pass_name}"]


def test_jacobians_span_a_hundredth_to_a_hundred():
    J = [
        theory(world).mu[0, x] / theory(world).mu[who, x]
        for world in (NEAR, FAR_NEIGHBORS, CLOSE_NEIGHBORS)
        for who in (1, 2)
        for x in np.flatnonzero(SEES[0] & SEES[who])
    ]
    assert min(J) < 0.01
    assert max(J) > 100
    for limit in (3, 10):  # on either side of the limits, and of their inverses
        assert any(1 < j < limit for j in J)
        assert any(1 / limit < j < 1 for j in J)


def test_a_chain_from_the_past_of_another_pixel_is_biased():
    """What the other pixel cannot draw then has a weight below 1: no false alarm."""
    found = faults(Resampler(weights="chained"))
    assert "E[W 1(y = x)]" in found["lattice-moved"]


def test_what_does_not_hang_on_thresholds_is_not_comparable():
    found = faults(Resampler(mistake="hashed"))
    for pass_name in CHOOSING:
        assert "not comparable" in found[f"lattice-{pass_name}"]
        assert "E[W" not in found[f"lattice-{pass_name}"]


def test_1_over_m_has_its_known_bias_and_no_other():
    """Weights of 1/Z may stand for 1/M, not the other way round."""
    found = faults(Resampler(weights="1/M"))
    assert set(found) == {
        f"lattice-{pass_name}{target}"
        for pass_name in ("moved", "spatial")
        for target in ("", "-outgoing")
    } | {f"lattice-spatial{target}-1-neighbor" for target in ("", "-outgoing")}
    wrong = faults(Resampler(weights="1/M", mistake="a thousandth"))
    assert set(wrong) > set(found)


def test_confidences_are_empty_single_and_up_to_the_cap():
    for e in enumerations():
        cap = e.settings["cap"]
        stored = {"spatial": slice(2), "fused": slice(1, None)}.get(e.pass_name)
        M = {M for s in e.setups for M in s.M[stored or slice(1)]}
        assert {0, 1, cap - 1, cap} <= M
        assert (e.weights % 1 == 0).all()


def test_calls_are_few_and_small():
    right, other = Counted(FLOAT32), Counted(Resampler(order="reversed"))
    lattice_step(CONTRACT, right)
    lattice_step(CONTRACT, other)
    assert right.batches == 1
    assert right.most < 2000
    assert other.batches <= 1 + 2 * 26
    assert other.most < 10_000


def test_without_the_backend_no_expectation_is_told():
    """As in a golden folder: rows are told that are not the contract's."""
    backend = Resampler(order="reversed", mistake="a thousandth")
    for probe in lattice_probes("float32")[1:]:
        case = probe.case
        if case.pass_name == "fused":
            continue  # which it has not
        out = getattr(backend, case.pass_name)(**case.inputs, **case.settings)
        finding = probe.examine(case, out, "float32")
        assert not finding.passed
        assert "rows are wrong" in finding.text
        assert "E[W" not in finding.text


class OutOfTime(InsideBackend):
    """Has time for the first batch alone."""

    batches = 0

    def run(self, passes, cases):
        """Outcome of each case."""
        self.batches += 1
        return super().run(passes, cases)

    def remaining_now(self):
        """Seconds."""
        return 1.0 if self.batches < 2 else 0.0


def test_without_time_nothing_is_told():
    backend = OutOfTime(Resampler(order="reversed"))
    backend.remaining = backend.remaining_now
    step = lattice_step(CONTRACT, backend)
    assert step.faults == []
    assert any("no time was left" in line for line in step.unasked)
