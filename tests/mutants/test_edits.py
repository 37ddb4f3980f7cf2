"""Planted mistakes that the slow tests alone run have their place in the code, once."""

from functools import cache

import pytest

from restir_gi.reference.oracle.cases import pass_of
from restir_gi.reference.oracle.ladder import scene_probes
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import parts
from tests.mutants import (
    blind,
    catalogue,
    further,
    gradients,
    grid,
    held_out,
    reuse,
    shifts,
)
from tests.mutants.blind_port import Port
from tests.mutants.harness import CONTRACT, Planted
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


# ------------------------------------------------ edits that do not run

IN_PASSES = (
    *catalogue.MUTANTS,
    *further.FURTHER_MUTANTS,
    *held_out.HELD_OUT,
    *reuse.REUSE_MUTANTS,
    *shifts.SHIFT_MUTANTS,
)


@cache
def short_cases():
    """The shortest case of each pass, for each word that its settings may be."""
    probes = [*kernel_probes("float32"), *row_probes("float32")]
    probes += scene_probes("cornell-box", "float32")
    for part in parts():
        probes += part.probes("float32")
    shortest = {}
    for case in sorted((p.case for p in probes), key=lambda case: -case.rows):
        words = [v for v in case.settings.values() if isinstance(v, str)]
        shortest[(case.pass_name, *words)] = case
    return list(shortest.values())


@pytest.mark.parametrize("mutant", IN_PASSES, ids=lambda m: m.name)
def test_every_edit_runs(mutant):
    """Names that nobody knows kill what was never planted: the harness raises."""
    assert len(Planted(mutant).run(CONTRACT, short_cases())) == len(short_cases())


def test_control_an_edit_that_does_not_run_is_seen():
    first, *_ = held_out.HELD_OUT
    broken = type(first)(first.name, first.ids, first.module, first.old, "nobody.knows")
    with pytest.raises(NameError, match="nobody"):
        Planted(broken).run(CONTRACT, short_cases())


@pytest.mark.parametrize("mistake", blind.MISTAKES)
def test_every_mistake_of_the_port_runs(mistake):
    """It answers what the port without it answers."""
    for case in short_cases():
        if hasattr(Port, case.pass_name):
            out = getattr(mistake(), case.pass_name)(**case.inputs, **case.settings)
            assert {f.name for f in pass_of(CONTRACT, case).outputs} <= set(out)
