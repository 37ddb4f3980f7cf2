"""Mistakes around the resampling of a frame are found, and called by name."""

from functools import cache

import pytest

from restir_gi.reference.oracle.diagnosis.further import FURTHER_MISTAKES
from tests.mutants.catalogue import BY_NAME
from tests.mutants.further import FURTHER_MUTANTS
from tests.mutants.harness import kill
from tests.mutants.plant import source_of

KNOWN = {h.name for h in FURTHER_MISTAKES}

SURVIVORS = {
    # The depth test refuses what has no depth above 0.
    "points behind the camera have a place in the image",
}

each_mutant = pytest.mark.parametrize("mutant", FURTHER_MUTANTS, ids=lambda m: m.name)


@cache
def killed(mutant):
    """What level L0 says of a mutant."""
    return kill(mutant, ("L0",))


@each_mutant
def test_every_edit_has_its_place(mutant):
    for module, old, _ in mutant.edits:
        assert source_of(module).count(old) == 1


def test_names_are_different():
    names = [mutant.name for mutant in FURTHER_MUTANTS]
    assert len({*names, *BY_NAME}) == len(names) + len(BY_NAME)


@each_mutant
def test_what_is_expected_is_known(mutant):
    assert set(mutant.expected) <= KNOWN


@each_mutant
def test_a_mutant_dies(mutant):
    assert killed(mutant).killed == (mutant.name not in SURVIVORS)


@each_mutant
def test_no_wrong_name_stands_alone(mutant):
    assert killed(mutant).named != "WRONG"


def test_nine_in_ten_are_named():
    dead = [k for k in map(killed, FURTHER_MUTANTS) if k.killed]
    named = [k for k in dead if k.named in ("right", "several")]
    assert len(named) >= 0.9 * len(dead)
