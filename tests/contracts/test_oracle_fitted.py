"""Cases as a backend has its pass: any number of neighbours, and no past."""

from functools import partial

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.checking import judge, told
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.ladder import run_of
from restir_gi.reference.oracle.levels.enumeration import enumerations_around
from restir_gi.reference.oracle.levels.fitted import with_neighbors
from restir_gi.reference.oracle.levels.lattice import enumerations_for
from restir_gi.reference.oracle.levels.means import replicates
from restir_gi.reference.oracle.levels.rows import (
    neighbor_row_probes,
    row_probes,
    size_of,
)
from restir_gi.reference.oracle.loop import Run

LOOP = frozenset({"direction", "temporal", "spatial", "shade"})
SPATIAL = Selection(only=frozenset({"spatial"}))


class NeighborsListener:
    """A backend that remembers how many neighbours it was asked for, and which past.

    Attributes
    ----------
    wrong : int; its W is too large where there are so many
    """

    precision = "float32"

    def __init__(self, wrong=0):
        self.counts, self.with_past, self.wrong = set(), False, wrong

    def __getattr__(self, name):
        """A pass."""
        own = getattr(FLOAT32, name)

        def call(**given):
            out = own(**given)
            if name == "spatial":
                count = given["neighbors"].shape[1]
                self.counts.add(count)
                self.with_past |= bool((given["past_M"] != 0).any())
                if count == self.wrong:
                    out["W"] = out["W"] * np.float32(1.01)
            return out

        return call


def verdict_on(backend, selection=SPATIAL, **has):
    table = {"schema": "restir-declaration 1", "has": has}
    about = {"statistics": False, "declaration": table, "selection": selection}
    return judge(backend, 300, **about)


def selection_of(**has):
    table = {"schema": "restir-declaration 1", "has": has}
    return read_declaration(table).selection


def test_every_run_has_one_neighbour_and_as_many_as_there_may_be():
    backend = NeighborsListener()
    verdict = verdict_on(backend)
    assert verdict.status == "PASS", told(verdict)
    assert {1, 9, 30} <= backend.counts
    assert backend.with_past


@pytest.mark.parametrize("count", [1, 9])
def test_what_is_wrong_with_one_number_alone_fails(count):
    backend = NeighborsListener(wrong=count)
    counts = Selection().designed_neighbors
    failed = set()
    for probe in neighbor_row_probes("float32", 1, counts):
        case = probe.case
        if case.pass_name != "spatial":
            continue
        out = backend.spatial(**case.inputs, **case.settings)
        if not probe.examine(case, out, "float32").passed:
            failed.add(case.inputs["neighbors"].shape[1])
    assert failed == {count}


@pytest.mark.parametrize("counts", [[1], pytest.param([12, 4], marks=pytest.mark.slow)])
def test_nobody_is_asked_for_another_number_of_neighbours(counts):
    backend = NeighborsListener()
    verdict = verdict_on(backend, Selection(only=LOOP), neighbors=counts)
    assert verdict.status == "PASS", told(verdict)
    assert backend.counts == set(counts)
    levels = {t.step.level for t in verdict.steps if t.step.answers or t.step.findings}
    assert {"L1", "L2", "L3"} <= levels


def test_without_history_no_past_is_ever_given():
    backend = NeighborsListener()
    verdict = verdict_on(backend, Selection(only=LOOP), history=False, neighbors=[1])
    assert verdict.status == "PASS", told(verdict)
    assert not backend.with_past
    assert verdict.departures == []


def test_whole_runs_have_the_neighbours_and_the_past_that_there_are():
    run = run_of(selection_of(neighbors=[1], history=False))
    backend = NeighborsListener()

    def ask(case):
        return getattr(backend, case.pass_name)(**case.inputs, **case.settings)

    replicates(ask, "float32", 1, run)
    assert backend.counts == {1}
    assert not backend.with_past
    replicates(ask, "float32", 1, Run())
    assert backend.counts == {1, 3}
    assert backend.with_past


def test_the_mean_without_history_and_with_one_neighbour_is_right():
    """Summed over all outcomes: see `test_lattices_pass_what_is_right` for others."""
    for e in enumerations_for(selection_of(neighbors=[1], history=False)):
        if e.pass_name == "spatial":
            assert e.name.endswith("-1-neighbor-no-past")
            assert all(len(s.pixels) == 3 and s.M[0] == 0 for s in e.setups)
    names = {e.name for e in enumerations_around(1)}
    assert "lattice-spatial-1-neighbor" in names


@pytest.mark.parametrize("count", [1, 2, 5, 29])
def test_neighbours_that_are_none_change_nothing(count):
    (case,) = (
        p.case
        for p in neighbor_row_probes("float32", 5, (count,))
        if (p.case.pass_name, p.case.settings["mis"]) == ("spatial", "1/Z")
    )
    call = partial(FLOAT32.spatial, **case.settings)
    more = with_neighbors("spatial", case.inputs, count + 1)
    assert more["visible"].dtype == np.uint32
    right = call(**case.inputs)
    found = call(**more)
    for name, array in right.items():
        np.testing.assert_array_equal(found[name], array)
    fewer = with_neighbors("spatial", more, count)
    for name, array in case.inputs.items():
        kept = fewer[name]
        if name == "visible":
            array = array & np.uint32((1 << (count + 2)) - 1)
        np.testing.assert_array_equal(kept, array)


def test_neighbours_that_are_left_out_are_as_if_they_were_none():
    case = next(p.case for p in row_probes("float32") if p.case.pass_name == "spatial")
    around = case.inputs["neighbors"].copy()
    around[:, 1:] = -1
    call = partial(FLOAT32.spatial, **case.settings)
    right = call(**{**case.inputs, "neighbors": around})
    found = call(**with_neighbors("spatial", case.inputs, 1))
    for name, array in right.items():
        np.testing.assert_array_equal(found[name], array)


def test_confidences_are_together_within_a_byte():
    for count in (1, 3, 9, 30):
        size = size_of(count)
        assert (count + 1) * size.trust <= 255
        assert size.rows % size.cluster == 0
