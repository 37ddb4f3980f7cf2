"""Mistakes in passes that other packages bring are found, and called by name."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import pytest

from restir_gi.extensions.oracle.reuse.part import PART as REUSE
from restir_gi.extensions.oracle.shifts.part import PART as SHIFTS
from restir_gi.gradient_domain.oracle.part import PART as GRADIENTS
from restir_gi.hashgrid.oracle.part import PART as HASH_GRID
from restir_gi.reference.oracle.parts import Part
from tests.mutants import hash_grid, pairs, reuse
from tests.mutants.catalogue import BY_NAME
from tests.mutants.further import FURTHER_MUTANTS
from tests.mutants.harness import kill
from tests.mutants.plant import source_of
from tests.mutants.shifts import SHIFT_MUTANTS


@dataclass(frozen=True)
class Planting:
    """Mistakes planted into the passes of a part, and where they are looked for."""

    part: Part
    rungs: tuple[str, ...]
    mutants: Sequence
    equivalent: Sequence
    quick: frozenset[str]
    """Whose death takes seconds."""

    @cached_property
    def biases(self):
        """Those that change what comes out."""
        return [m for m in self.mutants if m.kind == "bias"]


PLANTINGS = (
    Planting(
        REUSE,
        ("L0", "L1"),
        reuse.REUSE_MUTANTS,
        reuse.EQUIVALENT,
        frozenset(
            {
                "a shifted sample has no Jacobian",
                "Z counts who could not have made the sample",
                "weights in pairs are divided by the sum of confidences",
                "the value of another slot is kept",
                *(m.name for m in reuse.EQUIVALENT),
            }
        ),
    ),
    Planting(
        SHIFTS,
        ("L0", "L3"),
        SHIFT_MUTANTS,
        [m for m in SHIFT_MUTANTS if m.kind == "equivalent"],
        frozenset(
            {
                "alpha is taken for the perceptual roughness",
                "a hidden joint is accepted",
                "no throughput up to the joint",
                "a source's paths are shifted to the source",
            }
        ),
    ),
    Planting(
        HASH_GRID,
        ("L0", "L1"),
        hash_grid.HASH_GRID_MUTANTS,
        hash_grid.EQUIVALENT,
        frozenset(m.name for m in hash_grid.HASH_GRID_MUTANTS),
    ),
    Planting(
        GRADIENTS,
        ("L0", "L1"),
        pairs.PAIR_MUTANTS,
        pairs.EQUIVALENT,
        frozenset(
            {
                "samples without offset path say nothing",
                "candidates count one half each",
                "outer Jacobians have that of the offset path",
                "pairs that are no edge are found",
                "alpha weighs squares",
                "nobody asks whether the pivot was anywhere",
            }
        ),
    ),
)


def each(mutants, patient=True):
    """A case a mutant; those that take long are slow where they are to be killed."""
    return pytest.mark.parametrize(
        ("planting", "mutant"),
        [
            pytest.param(
                p,
                m,
                id=m.name,
                marks=() if patient or m.name in p.quick else pytest.mark.slow,
            )
            for p in PLANTINGS
            for m in mutants(p)
        ],
    )


each_mutant = each(lambda p: p.mutants)
each_bias = each(lambda p: p.biases, patient=False)
each_equivalent = each(lambda p: p.equivalent, patient=False)
each_part = pytest.mark.parametrize("planting", PLANTINGS, ids=lambda p: p.part.title)


@cache
def killed(part, rungs, mutant):
    """What the steps of a part say of a mutant."""
    return kill(mutant, rungs, titles=(part.title,))


def judged(planting, mutant):
    return killed(planting.part, planting.rungs, mutant)


@each_mutant
def test_every_edit_has_its_place(planting, mutant):
    for module, old, _ in mutant.edits:
        assert source_of(module).count(old) == 1


@each_part
def test_names_are_different(planting):
    others = {*BY_NAME, *(m.name for m in FURTHER_MUTANTS)}
    names = [mutant.name for mutant in planting.mutants]
    assert len({*names, *others}) == len(names) + len(others)


@each_mutant
def test_what_is_expected_is_known(planting, mutant):
    assert set(mutant.expected) <= {h.name for h in planting.part.hypotheses}


@each_part
def test_without_a_mistake_nothing_is_seen(planting):
    assert judged(planting, None).first == ""


@each_bias
@pytest.mark.few(12)
def test_a_mutant_dies(planting, mutant):
    assert judged(planting, mutant).killed


@each_bias
@pytest.mark.few(12)
def test_it_is_named_as_expected_or_not_at_all(planting, mutant):
    named = "right" if mutant.expected else "none"
    assert judged(planting, mutant).named == named


@each_equivalent
def test_what_is_equivalent_passes(planting, mutant):
    assert not judged(planting, mutant).killed


@pytest.mark.slow
def test_the_lattice_alone_sees_most_mistakes_in_reuse():
    """Whatever the weights are divided by: what comes out must be the measure."""
    planting, *_ = PLANTINGS
    seen = [m for m in planting.biases if judged(planting, m).seen["L1"]]
    assert len(seen) >= 0.7 * len(planting.biases)


def test_seven_in_ten_mistakes_in_shifts_have_a_name():
    _, planting, *_ = PLANTINGS
    named = [m for m in planting.biases if m.expected]
    assert len(named) >= 0.7 * len(planting.biases)
