"""Planted mistakes that the slow tests alone run have their place in the code, once."""

import pytest

from tests.mutants import gradients, grid, held_out
from tests.mutants.plant import source_of

COLLECTIONS = {
    "gradients": (*gradients.GRADIENT_MUTANTS, *gradients.IMAGE_MUTANTS),
    "grid": (*grid.GRID_MUTANTS, *grid.LIGHT_MUTANTS, *grid.PATH_MUTANTS),
    "held out": held_out.HELD_OUT,
}


def misplaced(mutants):
    """Edits whose text does not occur exactly once."""
    return [
        (mutant.name, module)
        for mutant in mutants
        for module, old, _ in mutant.edits
        if source_of(module).count(old) != 1
    ]


@pytest.mark.parametrize("name", COLLECTIONS)
def test_every_edit_has_its_place(name):
    assert COLLECTIONS[name]
    assert misplaced(COLLECTIONS[name]) == []


def test_control_a_line_that_has_changed_is_seen():
    first, *_ = held_out.HELD_OUT
    moved = type(first)(first.name, first.ids, first.module, "gone", first.new)
    assert misplaced([moved]) == [(first.name, first.module)]
