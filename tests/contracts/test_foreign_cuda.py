"""The CUDA backend of the documentation: right on the host, wrong in 19.

Nothing here needs a device; where there is one, and nvcc, it runs there.
"""

import os
import shutil
import subprocess

import pytest

from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from tests.contracts.foreign import (
    EXAMPLES,
    FURTHER,
    all_probes,
    assert_named,
    passed_the_whole_ladder,
    planted_copy,
    short_ladder,
)

FOLDER = EXAMPLES / "cuda"

COSINE = "return fmaxf(dot(x.normal, direction), 0.0f);"
J = "limited(quotient(cosine_to, cosine_from) * distances * distances)"

PLANTED = {
    "jacobian-divided": (J, f"quotient(1.0f, {J})"),
    "jacobian-omitted": (J, "1.0f"),
    "jacobian-unsquared": (J, "quotient(cosine_to, cosine_from) * distances"),
    "jacobian-clamped": (J, f"fminf(fmaxf({J}, 1.0f / 3.0f), 3.0f)"),
    "cosine-omitted": (COSINE, "return dot(x.normal, direction) > 0.0f;"),
    "cosine-twice": (
        COSINE,
        "return powf(fmaxf(dot(x.normal, direction), 0.0f), 2.0f);",
    ),
    "one-over-m": ('given.get("mis") == "1/Z"', "False"),
    "nulls-not-counted": ("{y, p_hat, w, 1.0f, 0}", "{y, p_hat, w, float(w > 0), 0}"),
    "cap-missing": ("fminf(s.M, p.set.cap)", "s.M"),
    "confidence-missing": ("limited(p_hat * r.W) * r.M", "limited(p_hat * r.W)"),
    "visibility-ignored-in-z": ("return seen && target_at", "return target_at"),
    "visibility-ignored-in-weight": ("if (!(sees >> bit & 1u)) c.w = 0.0f;", ""),
    "accept-old-sum": ("u * (w_before + w) < w", "u * w_before < w"),
    "wrong-pdf": ("1.0f / (2.0f * PI)", "1.0f / PI"),
    "random-reused": ("sees[0]), u[k])", "sees[0]), u[0])"),
    "depth-relative-to-own": ("fmaxf(z_a, z_b)", "z_a"),
    "radius-not-halved": ("if (!usable) radius =", "if (false) radius ="),
    "albedo-missing": ("f = x.albedo * y.radiance", "f = y.radiance"),
    "cap-before-weight": ("s.kept.p_hat), Z)", "s.kept.p_hat), fminf(Z, p.set.cap))"),
}
"""Lines that read otherwise, by the name of the mistake that this is."""


@pytest.fixture(scope="module", autouse=True)
def _compiler():
    if not (shutil.which("g++") or shutil.which("clang++") or shutil.which("c++")):
        if os.environ.get("RESTIR_NO_SKIP"):
            pytest.fail("there is no C++ compiler")
        pytest.skip("install a C++ compiler to test the CUDA backend")


@pytest.fixture(scope="module")
def probes():
    return all_probes()


def test_it_passes():
    backend = PythonBackend(str(FOLDER / "backend.py"), Limits())
    assert passed_the_whole_ladder(backend) == FURTHER


@pytest.mark.parametrize("plant", PLANTED)
@pytest.mark.few(2)
def test_a_planted_mistake_is_told_by_its_name(probes, tmp_path, plant):
    path = planted_copy(FOLDER, tmp_path, *PLANTED[plant])
    assert_named(short_ladder(PythonBackend(str(path), Limits()), probes), plant)


def test_no_compiler_warns(tmp_path):
    compiler = shutil.which("g++") or shutil.which("clang++") or shutil.which("c++")
    warnings = ["-Wall", "-Wextra", "-pedantic", "-Werror"]
    source = ["-x", "c++", FOLDER / "restir.cu"]
    options = ["-std=c++17", *warnings, "-fsyntax-only", *source]
    subprocess.run([compiler, *options], check=True)


@pytest.mark.slow
def test_the_compiler_of_cuda_takes_it(tmp_path):
    if not shutil.which("nvcc"):
        pytest.skip("nvcc is not on the PATH; elsewhere the grid is a loop")
    options = ["-std=c++17", "-Werror", "all-warnings", "-cubin"]
    cubin = ["-o", tmp_path / "restir.cubin", FOLDER / "restir.cu"]
    subprocess.run(["nvcc", *options, *cubin], check=True)


def test_what_is_missing_is_told_in_a_line(monkeypatch):
    monkeypatch.setenv("RESTIR_COMPILER", "no-such-compiler")
    told = r"no compiler \(no-such-compiler\) on the PATH; install g\+\+$"
    with pytest.raises(Exception, match=told):
        PythonBackend(str(FOLDER / "backend.py"), Limits())


def test_what_does_not_compile_is_told_in_a_line(tmp_path):
    path = planted_copy(FOLDER, tmp_path, "constexpr float PI", "constexpr flat PI")
    with pytest.raises(Exception, match=r"cannot build restir\.cu: .*flat"):
        PythonBackend(str(path), Limits())
