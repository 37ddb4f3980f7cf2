"""The WGSL backend of the documentation: right on this device, wrong in 24 ways."""

import importlib.util
import os
from pathlib import Path

import pytest

from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.parts import parts
from tests.contracts.foreign import (
    NAMED,
    all_probes,
    assert_named,
    passed_the_whole_ladder,
    short_ladder,
)

BACKEND = Path(__file__).parents[2] / "docs" / "examples" / "wgsl" / "backend.py"


@pytest.fixture(scope="module")
def example():
    """The example as a module; skipped without a device, unless all must be there."""
    found = importlib.util.spec_from_file_location("wgsl_example", BACKEND)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    try:
        module.best_adapter()
    except (ImportError, RuntimeError) as error:
        if os.environ.get("RESTIR_NO_SKIP"):
            raise
        pytest.skip(f"shaders cannot run here: {error}")
    return module


@pytest.fixture(scope="module")
def probes():
    return all_probes()


def test_it_passes(example):
    absent = passed_the_whole_ladder(PythonBackend(str(BACKEND), Limits()))
    further = [one.name for part in parts() for one in part.passes]
    assert absent == ["fused", *further]


def test_its_list_of_mistakes_is_complete(example):
    assert list(example.PLANTS) == list(NAMED)


def test_the_shader_numbers_them_in_that_order(example):
    source = BACKEND.with_name("restir.wgsl").read_text(encoding="utf-8")
    for number, plant in enumerate(example.PLANTS, start=1):
        constant = plant.upper().replace("-", "_")
        assert f"const {constant} = {number}u;" in source


@pytest.mark.parametrize("plant", NAMED)
@pytest.mark.few(3)
def test_a_planted_mistake_is_told_by_its_name(example, probes, monkeypatch, plant):
    monkeypatch.setenv("RESTIR_PLANT", plant)
    verdict = short_ladder(PythonBackend(str(BACKEND), Limits()), probes)
    assert_named(verdict, plant)
