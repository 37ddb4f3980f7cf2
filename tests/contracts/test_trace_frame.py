"""A page an algorithm: few files are entered by whoever follows one."""

import numpy as np
import pytest

from restir_gi.hashgrid.grid import edges
from tests.benchmarks.trace_frame import Tracer, entered, profiled, views

FILES = {
    "restir-pt": 4,
    "world-reservoirs": 4,
    "regir-gi": 7,
    "world-reservoirs/hashgrid.grid:insert": 1,
    "world-reservoirs/hashgrid.grid:look_up": 1,
    "regir-gi/extensions.shifting:Shift.__call__": 1,
}
"""Of the upper packages, which are read with the paper open."""


@pytest.mark.parametrize("name", FILES)
def test_an_algorithm_is_followed_in_few_files(name):
    files = {module for module, _, _ in views(entered(name))["own"]}
    assert 0 < len(files) <= FILES[name], files


@pytest.mark.parametrize(
    ("within", "names"), [(None, {"edges"}), ("edges", {"edges"}), ("levels", set())]
)
def test_control_what_is_called_is_entered_and_nothing_else(within, names):
    tracer = Tracer(("hashgrid.grid", within) if within else None)
    with profiled(tracer):
        edges(np.zeros(1, np.int64))
    assert {name for _, name, _ in tracer.entered} == names
