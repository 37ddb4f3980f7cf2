"""The shaders of the documentation, WGSL and HLSL: right here, and wrong in 25 ways."""

import importlib.util
import os
from pathlib import Path

import pytest

from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from tests.contracts.foreign import (
    EXAMPLES,
    FURTHER,
    NAMED,
    all_probes,
    assert_named,
    passed_the_whole_ladder,
    short_ladder,
)

NUMBERED = {
    "wgsl": ("restir.wgsl", "const {} = {}u;"),
    "slang": ("restir.hlsl", "static const uint {} = {};"),
}
"""Shader of each example, and how it gives a mistake its number."""


@pytest.fixture(scope="module", params=NUMBERED)
def example(request):
    """An example as a module; skipped without a device, unless all must be there."""
    path = EXAMPLES / request.param / "backend.py"
    found = importlib.util.spec_from_file_location(f"{request.param}_example", path)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    try:
        module.best_adapter()
        if request.param == "slang":
            module.compiler()
    except (ImportError, RuntimeError) as error:
        if os.environ.get("RESTIR_NO_SKIP"):
            raise
        pytest.skip(f"shaders cannot run here: {error}")
    return module


@pytest.fixture(scope="module")
def probes():
    return all_probes()


def test_it_passes(example):
    absent = passed_the_whole_ladder(PythonBackend(example.__file__, Limits()))
    assert absent == FURTHER


def test_its_list_of_mistakes_is_complete(example):
    assert list(example.PLANTS) == list(NAMED)


def test_the_shader_numbers_them_in_that_order(example):
    path = Path(example.__file__)
    shader, line = NUMBERED[path.parent.name]
    source = path.with_name(shader).read_text(encoding="utf-8")
    for number, plant in enumerate(example.PLANTS, start=1):
        constant = plant.upper().replace("-", "_")
        assert line.format(constant, number) in source


@pytest.mark.parametrize("example", ["slang"], indirect=True)
def test_what_slang_refuses_is_told_with_its_line(example, tmp_path):
    path = tmp_path / "wrong.hlsl"
    path.write_text("[numthreads(1, 1, 1)]\nvoid pass_target() { missing = 1; }\n")
    with pytest.raises(ValueError, match=r"wrong\.hlsl.*:?2"):
        example.as_wgsl(path, "pass_target")


@pytest.mark.parametrize("plant", NAMED)
@pytest.mark.few(6)
def test_a_planted_mistake_is_told_by_its_name(example, probes, monkeypatch, plant):
    monkeypatch.setenv("RESTIR_PLANT", plant)
    verdict = short_ladder(PythonBackend(example.__file__, Limits()), probes)
    assert_named(verdict, plant)
