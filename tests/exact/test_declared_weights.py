"""The built-in passes with declared MIS weights, integrated over all that can happen.

Every outcome of what a pass is given, in worlds with J from 1/100 to 100 and patches
that only some can draw, and every decision of the pass, between its own thresholds:
E[W 1{y = x}] must be the solid angle of patch x, by whatever weights.  Nothing is by
chance: what is left is the rounding of thresholds to multiples of 2⁻²⁴.
"""

import numpy as np
import pytest

from restir_gi.reference.options import weights
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.levels.enumeration import declared_enumerations
from restir_gi.reference.oracle.levels.thresholds import own_expectation
from restir_gi.reference.resampling import generalized, pairwise

SHIFTED_PASSES = ("moved", "spatial", "fused")
DECLARED = declared_enumerations()


def integrated(e, precision):
    """What `own_expectation` finds of the built-in pass."""
    backend, search, sent = BuiltIn(precision), own_expectation(e, precision), None
    while True:
        try:
            case = search.send(sent)
        except StopIteration as end:
            return end.value
        sent = getattr(backend, case.pass_name)(**case.inputs, **case.settings)


def named(e):
    return e.name.removeprefix("lattice-")


def test_all_weights_of_all_passes_are_integrated():
    found = {(e.pass_name, e.settings["mis"]) for e in DECLARED}
    assert found == {
        ("temporal", "defensive"),
        *((name, mis) for name in SHIFTED_PASSES for mis in MIS.more),
    }


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("e", DECLARED, ids=named)
def test_the_mean_is_right(e, precision):
    found = integrated(e, precision)
    assert found.passed, found.text


def other_share(share):
    """A part of a thousand too much for one of the two."""

    def planted(M_a, p_a, M_b, p_b):
        return share(M_a, p_a, M_b * M_b.dtype.type(0.999), p_b)

    return planted


@pytest.mark.parametrize("e", DECLARED, ids=named)
def test_control_a_thousandth_in_the_weights_is_found(monkeypatch, e):
    """In the kernel itself: shares of pairs that sum to a thousandth more, or less."""
    if e.settings["mis"] == "balance":
        right = generalized.balance_heuristic
        monkeypatch.setattr(
            generalized,
            "balance_heuristic",
            lambda M, p, made: right(M, [p[0] * 0.999, *p[1:]], made),
        )
    else:
        monkeypatch.setattr(pairwise, "_share", other_share(pairwise._share))
    assert not integrated(e, "float64").passed


SHIFTED = [e for e in DECLARED if e.pass_name != "temporal"]


@pytest.mark.parametrize("e", SHIFTED, ids=named)
def test_control_a_jacobian_that_only_the_maker_has_is_found(monkeypatch, e):
    right = weights.ShiftedSource.inverse

    def inverse(source, samples, at):
        p, J = right(source, samples, at)
        return p, np.ones_like(J)

    monkeypatch.setattr(weights.ShiftedSource, "inverse", inverse)
    assert not integrated(e, "float64").passed
