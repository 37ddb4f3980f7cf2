"""The shaders of the documentation, WGSL and HLSL: right here, and wrong in 25 ways."""

import importlib.util
import os
from pathlib import Path

import pytest

from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.ladder import ladder
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.verdict import run_ladder
from tests.contracts.foreign import NAMED, all_probes, assert_named, short_ladder

CONTRACT = whole_contract()

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
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
    backend = PythonBackend(example.__file__, Limits())
    levels = ladder(CONTRACT, backend)
    try:
        found = run_ladder(
            CONTRACT, "float32", levels, 60, lambda: 0.0, lambda title: None
        )
    finally:
        backend.close()
    assert [text for timed in found.steps for text in timed.step.faults] == []
    assert found.status == "PASS"
    further = [one.name for part in parts() for one in part.passes]
    assert found.absent == ["fused", *further]


def test_its_list_of_mistakes_is_complete(example):
    assert list(example.PLANTS) == list(NAMED)


def test_the_shader_numbers_them_in_that_order(example):
    path = Path(example.__file__)
    shader, line = NUMBERED[path.parent.name]
    source = path.with_name(shader).read_text(encoding="utf-8")
    for number, plant in enumerate(example.PLANTS, start=1):
        constant = plant.upper().replace("-", "_")
        assert line.format(constant, number) in source


def test_what_slang_refuses_is_told_with_its_line(example, tmp_path):
    if not hasattr(example, "as_wgsl"):
        pytest.skip("the WGSL example compiles nothing")
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
