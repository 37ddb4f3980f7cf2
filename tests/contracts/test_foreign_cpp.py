"""The C++ backend of the documentation: right in two ways of rounding, wrong in 24.

It was written from the contract's page and shares no line with the kernels.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from restir_gi.reference.oracle.backends.command import ProgramBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.ladder import ladder
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.verdict import run_ladder
from tests.contracts.foreign import NAMED, all_probes, assert_named, short_ladder

CONTRACT = whole_contract()

SOURCE = Path(__file__).parents[2] / "docs" / "examples" / "cpp" / "restir_backend.cpp"
ROUNDINGS = {"unfused": ["-ffp-contract=off"], "fused": ["-mfma", "-ffp-contract=fast"]}


def has_fused_multiply_add():
    """Whether this processor can run what -mfma makes."""
    info = Path("/proc/cpuinfo")
    return not info.exists() or " fma " in info.read_text()


@pytest.fixture(scope="module", params=ROUNDINGS)
def program(request, tmp_path_factory):
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None and not os.environ.get("RESTIR_NO_SKIP"):
        pytest.skip("install a C++ compiler to test the C++ backend")
    if request.param == "fused" and not has_fused_multiply_add():
        pytest.skip("this processor has no fused multiply-add")
    path = tmp_path_factory.mktemp(request.param) / "restir_backend"
    warnings = ["-Wall", "-Wextra", "-pedantic", "-Werror"]
    options = ["-O2", "-std=c++17", *warnings, *ROUNDINGS[request.param]]
    subprocess.run([compiler, *options, "-o", path, SOURCE], check=True)
    return path


@pytest.fixture(scope="module")
def probes():
    return all_probes()


def test_it_passes(program):
    backend = ProgramBackend(f"{program} {{directory}}", Limits())
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


def test_its_list_of_mistakes_is_complete(program):
    listed = subprocess.run(
        [program, "--list-plants"], check=True, capture_output=True, text=True
    )
    assert listed.stdout.split() == list(NAMED)


@pytest.mark.parametrize("program", ["unfused"], indirect=True)
@pytest.mark.parametrize("plant", NAMED)
@pytest.mark.few(3)
def test_a_planted_mistake_is_told_by_its_name(program, probes, plant):
    told_by_its_name(program, probes, plant)


@pytest.mark.slow
@pytest.mark.parametrize("program", ["fused"], indirect=True)
@pytest.mark.parametrize("plant", list(NAMED)[::5])
def test_a_mistake_is_told_whatever_the_rounding(program, probes, plant):
    told_by_its_name(program, probes, plant)


def told_by_its_name(program, probes, plant):
    template = f"{program} {{directory}} --plant {plant}"
    verdict = short_ladder(ProgramBackend(template, Limits()), probes)
    assert_named(verdict, plant)


def test_what_it_cannot_read_is_told(program, tmp_path):
    found = subprocess.run(
        [program, tmp_path], capture_output=True, text=True, check=False
    )
    assert found.returncode == 2
    assert found.stderr == f"restir_backend: no cases.txt in {tmp_path}\n"
