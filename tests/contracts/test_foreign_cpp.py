"""The C++ backend of the documentation: right in two ways of rounding, wrong in many.

It has every pass, was written from the contract's page, and shares no line with the
kernels.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from restir_gi.reference.oracle.backends.command import ProgramBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.ladder import scene_probes
from restir_gi.reference.oracle.parts import parts
from tests.contracts.foreign import (
    NAMED,
    all_probes,
    assert_named,
    passed_the_whole_ladder,
    short_ladder,
)

FURTHER = {
    "source-point-of-now": {"sources-of-this-frame"},
    "pixel-corner": {"pixel-corner"},
    "distance-for-depth": {"distance-for-depth"},
    "place-rounded": {"place-rounded"},
    "own-pixel-tested": {"own-pixel-tested"},
    "darker-alone": {"validation-of-darker-alone"},
    "null-cleared": {"validation-asks-nulls"},
    "boiling-mean-over-all": {"boiling-mean-over-all"},
    "filter-keeps-m": {"validation-keeps-m", "boiling-keeps-m"},
    "checkerboard-frozen": {"checkerboard-stands-still"},
    "roulette-not-divided": {"roulette-not-divided"},
    "roulette-by-pixels": {"roulette-by-pixels"},
    "half-overflows": {"pack-halves-overflow"},
    "half-cut-off": {"pack-halves-toward-0"},
    "sign-of-zero": {"sign-of-0-is-0"},
    "normal-code-unmasked": {"pack-sign-runs-over"},
    "upper-half-first": {"halves-from-above"},
    "normal-code-unsigned": {"unpack-without-sign"},
    "reuse-jacobian-omitted": {
        "reuse-jacobian-left-out",
        "pair-reuse-jacobian-left-out",
    },
    "reuse-maker-without-jacobian": {
        "reuse-made-without-jacobian",
        "pair-reuse-made-without-jacobian",
    },
    "reuse-pairs-exchanged": {
        "reuse-pairs-exchanged",
        "light-reuse-pairs-exchanged",
        "pair-reuse-pairs-exchanged",
    },
    "reuse-empty-slots-counted": {
        "reuse-empty-slots-counted",
        "light-reuse-empty-slots-counted",
        "pair-reuse-empty-slots-counted",
    },
    "alpha-for-roughness": {"alpha-for-roughness"},
    "path-jacobian-inverted": {"path-jacobian-inverted"},
    "path-jacobian-of-solid-angles": {"path-jacobian-densities-omitted"},
    "earlier-joint-accepted": {"earlier-joints-accepted"},
    "hidden-joint-accepted": {"hidden-joint-accepted"},
    "base-throughput": {"bases-throughput"},
    "base-distance": {"distance-from-the-base"},
    "insertion-lost": {"cell-insert-of-winners-alone"},
    "checksum-missing": {"cell-insert-without-checksum", "cell-find-without-checksum"},
    "scan-inclusive": {"cell-scan-inclusive"},
    "eye-of-now": {"cell-level-by-this-eye"},
    "inner-jacobian-missing": {"pair-inner-jacobian-left-out"},
    "second-not-turned": {"pair-second-sign-not-turned"},
    "luminance-of-the-sum": {"pair-target-of-the-sum"},
    "candidates-halved": {"pair-candidates-halved"},
    "step-not-turned": {"inner-shift-step-not-turned"},
    "offset-carried": {"outer-shift-offset-carried"},
    "edges-where-normals-agree": {"edge-normals-above"},
    "edge-depth-of-the-first": {"edge-depth-of-the-first"},
    "first-pixels-alone": {"search-first-pixels-compared"},
    "motion-of-the-first": {"motion-with-the-first"},
    "primal-with-emission": {"primal-with-emission"},
    "pair-differences-not-turned": {"differences-sign-of-pairs"},
    "alpha-not-squared": {"poisson-alpha-not-squared"},
    "poisson-wraps-around": {"poisson-periodic"},
    "divergence-sign": {"poisson-divergence-sign"},
    "squares-for-absolute-values": {"poisson-squares-for-absolute-values"},
}
"""Mistakes in the passes that the shader does not have, and what they are called."""

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
    options = ["-O2", "-std=c++17", "-pthread", *warnings, *ROUNDINGS[request.param]]
    subprocess.run([compiler, *options, "-o", path, SOURCE], check=True)
    return path


@pytest.fixture(scope="module")
def probes():
    return all_probes()


@pytest.fixture(scope="module")
def further_probes():
    """Of all passes but those from random to shade."""
    scene = scene_probes("cornell-box", "float32")
    found = [probe for probe in scene if probe.case.pass_name == "fused"]
    for part in parts():
        names = frozenset(one.name for one in part.passes)
        found += [*part.probes("float32"), *part.frames("float32", names)]
    return found


def test_it_passes(program):
    backend = ProgramBackend(f"{program} {{directory}}", Limits())
    assert passed_the_whole_ladder(backend) == []


def test_its_list_of_mistakes_is_complete(program):
    listed = subprocess.run(
        [program, "--list-plants"], check=True, capture_output=True, text=True
    )
    assert listed.stdout.split() == [*NAMED, *FURTHER]


@pytest.mark.parametrize("program", ["unfused"], indirect=True)
@pytest.mark.parametrize("plant", NAMED)
@pytest.mark.few(3)
def test_a_planted_mistake_is_told_by_its_name(program, probes, plant):
    told_by_its_name(program, probes, plant)


@pytest.mark.parametrize("program", ["unfused"], indirect=True)
@pytest.mark.parametrize("plant", FURTHER)
@pytest.mark.few(3)
def test_a_mistake_in_a_further_pass_is_told(program, further_probes, plant):
    further_told(program, further_probes, plant)


@pytest.mark.slow
@pytest.mark.parametrize("program", ["fused"], indirect=True)
@pytest.mark.parametrize("plant", list(NAMED)[::5])
def test_a_mistake_is_told_whatever_the_rounding(program, probes, plant):
    told_by_its_name(program, probes, plant)


@pytest.mark.slow
@pytest.mark.parametrize("program", ["fused"], indirect=True)
@pytest.mark.parametrize("plant", list(FURTHER)[::5])
def test_a_further_mistake_is_told_whatever_the_rounding(
    program, further_probes, plant
):
    further_told(program, further_probes, plant)


def verdict_on(program, probes, plant):
    template = f"{program} {{directory}} --plant {plant}"
    return short_ladder(ProgramBackend(template, Limits()), probes)


def told_by_its_name(program, probes, plant):
    assert_named(verdict_on(program, probes, plant), plant)


def further_told(program, probes, plant):
    """The passes that are wrong have these names, and no other."""
    verdict = verdict_on(program, probes, plant)
    names = [{h.name for h in one.matches} for one in verdict.diagnoses]
    assert verdict.status == "FAIL"
    assert all(names)
    assert set().union(*names) == FURTHER[plant]


def test_what_it_cannot_read_is_told(program, tmp_path):
    found = subprocess.run(
        [program, tmp_path], capture_output=True, text=True, check=False
    )
    assert found.returncode == 2
    assert found.stderr == f"restir_backend: no cases.txt in {tmp_path}\n"
