"""Mistakes in the reuse of whole samples are found, and called by name."""

from functools import cache

import pytest

from extensions.oracle.reuse.part import PART
from tests.mutants.catalogue import BY_NAME
from tests.mutants.further import FURTHER_MUTANTS
from tests.mutants.harness import kill
from tests.mutants.plant import source_of
from tests.mutants.reuse import EQUIVALENT, REUSE_MUTANTS

KNOWN = {h.name for h in PART.hypotheses}
BIASES = [m for m in REUSE_MUTANTS if m.kind == "bias"]

each_mutant = pytest.mark.parametrize("mutant", REUSE_MUTANTS, ids=lambda m: m.name)
QUICK = {
    "a shifted sample has no Jacobian",
    "Z counts who could not have made the sample",
    "weights in pairs are divided by the sum of confidences",
    "the value of another slot is kept",
}

each_bias = pytest.mark.parametrize(
    "mutant",
    [
        pytest.param(m, id=m.name, marks=() if m.name in QUICK else (pytest.mark.slow,))
        for m in BIASES
    ],
)


@cache
def killed(mutant):
    """What the steps of this pass say of a mutant."""
    return kill(mutant, ("L0", "L1"), titles=(PART.title,))


@each_mutant
def test_every_edit_has_its_place(mutant):
    for module, old, _ in mutant.edits:
        assert source_of(module).count(old) == 1


def test_names_are_different():
    others = {*BY_NAME, *(m.name for m in FURTHER_MUTANTS)}
    names = [mutant.name for mutant in REUSE_MUTANTS]
    assert len({*names, *others}) == len(names) + len(others)


@each_mutant
def test_what_is_expected_is_known(mutant):
    assert set(mutant.expected) <= KNOWN


def test_without_a_mistake_nothing_is_seen():
    assert killed(None).first == ""


@each_bias
def test_a_mutant_dies(mutant):
    assert killed(mutant).killed


@each_bias
def test_it_is_named_as_expected_or_not_at_all(mutant):
    assert killed(mutant).named == ("right" if mutant.expected else "none")


@pytest.mark.parametrize("mutant", EQUIVALENT, ids=lambda m: m.name)
def test_what_is_equivalent_passes(mutant):
    assert not killed(mutant).killed


@pytest.mark.slow
def test_the_lattice_alone_sees_most_of_them():
    """Whatever the weights are divided by: what comes out must be the measure."""
    seen = [m for m in BIASES if killed(m).seen["L1"]]
    assert len(seen) >= 0.7 * len(BIASES)
