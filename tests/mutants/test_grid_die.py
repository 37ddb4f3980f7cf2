"""Mistakes in grids and caches are refuted by the tests of what they break."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import restir_gi.hashgrid.grid
from restir_gi.hashgrid.grid import Keys
from restir_gi.hashgrid.light_settings import LightSettings
from restir_gi.hashgrid.path_settings import CellSettings
from restir_gi.reference.numerics.schedule import Schedule
from tests.mutants.grid import GRID_MUTANTS, LIGHT_MUTANTS, PATH_MUTANTS
from tests.mutants.plant import is_refuted, planted
from tests.properties import test_hash_grid as grids
from tests.properties import test_light_points as lights
from tests.properties import test_suffixes as suffixes
from tests.statistics import test_regir_gi as regir
from tests.statistics import test_world_reservoirs as world_reservoirs
from tests.statistics.path_runs import BOUND


def collisions():
    """Cells of one bucket and one checksum."""
    with pytest.MonkeyPatch.context() as patch:
        one = np.uint64((5 << 32) | 77)
        patch.setattr(Keys, "hashes", property(lambda k: np.full(len(k), one)))
        grids.test_cells_of_one_bucket_and_checksum_are_not_mixed_up()


def lattices():
    """Frame by frame, the cells that are looked up are those of the grid."""
    asked, keys_of = [], restir_gi.hashgrid.grid.keys_of

    def spied(lattice, *rest):
        asked.append(lattice)
        return keys_of(lattice, *rest)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(restir_gi.hashgrid.grid, "keys_of", spied)
        lights.colors("moving-camera", Schedule(), LightSettings(), frames=2)
    # The first frame's grid; look-ups at two vertices; the second frame's grid.
    first, *looked_up, second = asked
    assert first != second
    assert looked_up == [first, first]


GRID_EVIDENCE = [
    partial(grids.test_it_is_the_slow_grid, 7, 0.1),
    partial(grids.test_it_is_the_slow_grid, 4096, 3.0),
    collisions,
    grids.test_cells_on_both_sides_of_zero_are_of_one_size,
    grids.test_jitter_stays_in_the_tangent_plane,
    grids.test_nobody_is_lost_or_twice_there,
    partial(grids.test_a_look_up_takes_no_vertex_twice_and_all_alike, 2, 3),
    partial(grids.test_a_look_up_takes_no_vertex_twice_and_all_alike, 7, 3),
    lights.test_those_found_are_near_and_face_alike,
    lights.test_lights_keep_their_shapes_when_others_go_out,
    lights.test_light_that_went_out_leaves_nothing,
    lights.test_samples_are_carried_into_the_list_of_the_next_frame,
    lattices,
]


def unbiased(found):
    assert found < BOUND


LIGHT_EVIDENCE = [
    lambda: unbiased(world_reservoirs.candidates("many-lights", 768)),
    lambda: unbiased(world_reservoirs.candidates("checker")),
]

CELLS = CellSettings(temporal=False, spatial=False)


def no_bias(*plan):
    assert regir.still(*plan)


PATH_EVIDENCE = [
    partial(
        suffixes.test_a_path_that_a_cell_has_ended_is_shifted_to_itself, "paint", 2, 2
    ),
    partial(
        suffixes.test_a_path_that_a_cell_has_ended_is_shifted_to_itself, "glass", 4, 0
    ),
    partial(suffixes.test_cells_hold_paths_that_can_be_joined_or_none, "glass"),
    partial(suffixes.test_no_path_is_longer_than_asked, "every-bounce"),
    lambda: unbiased(regir.candidates("mirror")),
    partial(no_bias, "paint", CELLS, 2, 40),
    partial(no_bias, "glass", replace(CELLS, query=0), 3, 60),
]


def cases(mutants, slow):
    marks = (pytest.mark.slow,) if slow else ()
    return [pytest.param(m, id=m.name, marks=marks) for m in mutants]


@pytest.mark.parametrize("mutant", cases(GRID_MUTANTS, slow=False))
def test_mistakes_in_grids_are_refuted(mutant):
    with planted(mutant):
        assert any(is_refuted(evidence) for evidence in GRID_EVIDENCE)


@pytest.mark.parametrize("mutant", cases(LIGHT_MUTANTS, slow=True))
def test_mistakes_in_light_reservoirs_are_refuted(mutant):
    with planted(mutant):
        assert any(is_refuted(evidence) for evidence in LIGHT_EVIDENCE)


@pytest.mark.parametrize("mutant", cases(PATH_MUTANTS, slow=True))
def test_mistakes_in_paths_of_cells_are_refuted(mutant):
    with planted(mutant):
        assert any(is_refuted(evidence) for evidence in PATH_EVIDENCE)


def test_control_without_a_mistake_nothing_is_refuted():
    assert not any(is_refuted(evidence) for evidence in GRID_EVIDENCE)


@pytest.mark.slow
def test_control_without_a_mistake_no_bias_is_seen():
    assert not any(is_refuted(e) for e in (*LIGHT_EVIDENCE, *PATH_EVIDENCE))
