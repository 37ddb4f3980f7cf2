"""The array backend of the documentation: right on three libraries, wrong in 19.

`array-api-strict` has nothing but the standard: what runs on it needs nothing that CuPy
or JAX may lack.
"""

from importlib.util import find_spec, module_from_spec, spec_from_file_location

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.host_arrays import host_array
from tests.contracts.foreign import (
    EXAMPLES,
    FURTHER,
    all_probes,
    assert_named,
    passed_the_whole_ladder,
    planted_copy,
    short_ladder,
)

FOLDER = EXAMPLES / "arrays"
BACKEND = str(FOLDER / "backend.py")

LIBRARIES = {"numpy": "numpy", "strict": "array_api_strict", "torch": "torch"}
"""Modules that have to be there."""

COSINE = "return xp.where(counts, cosine,"
J = "xp.clip(cosines * distances * distances, max=LARGEST)"

PLANTED = {
    "jacobian-divided": (J, f"quotient(xp.ones_like(cosines), {J})"),
    "jacobian-omitted": (J, "xp.ones_like(cosines)"),
    "jacobian-unsquared": (J, "cosines * distances"),
    "jacobian-clamped": (J, "xp.clip(cosines * distances**2, min=1 / 3, max=3.0)"),
    "cosine-omitted": (COSINE, "return xp.where(counts, xp.ones_like(cosine),"),
    "cosine-twice": (COSINE, "return xp.where(counts, cosine**2,"),
    "one-over-m": ('if mis == "1/M"', "if True"),
    "nulls-not-counted": (
        "quotient(p_hat, pdf[:, None]), xp.ones_like(p_hat)",
        "quotient(p_hat, pdf[:, None]), xp.astype(p_hat > 0, xp.float32)",
    ),
    "cap-missing": ("xp.clip(M, max=float(cap))", "M"),
    "confidence-missing": ("p_hat * W * M, M)", "p_hat * W, M)"),
    "visibility-ignored-in-z": (
        "return bits_of(sees, bit[:, None]) & ",
        "return ",
    ),
    "visibility-ignored-in-weight": ("xp.where(seen, w, xp.zeros_like(w))", "w"),
    "accept-old-sum": ("u * sums < w", "u * (sums - w) < w"),
    "wrong-pdf": ("1 / (2 * math.pi)", "1 / math.pi"),
    "random-reused": (
        "u_neighbors), axis=1)",
        "0 * u_neighbors + u_neighbors[:, :1]), axis=1)",
    ),
    "depth-relative-to-own": ("xp.maximum(z_a, z_b)", "z_a"),
    "radius-not-halved": ("xp.where(usable, reach, halved)", "reach"),
    "albedo-missing": ("f = x.albedo * y.radiance", "f = y.radiance"),
    "cap-before-weight": (
        "kept.p_hat), Z)",
        "kept.p_hat), xp.clip(Z, max=float(cap)))",
    ),
}
"""Lines that read otherwise, by the name of the mistake that this is."""


@pytest.fixture
def library(request, monkeypatch):
    """Choose a library; PyTorch may be gigabytes, and .ci/run alone installs it."""
    if request.param == "torch" and find_spec("torch") is None:
        pytest.skip("pip install torch to test the array backend on it; .ci/run does")
    monkeypatch.setenv("RESTIR_ARRAYS", request.param)
    monkeypatch.delenv("RESTIR_DEVICE", raising=False)
    return request.param


@pytest.fixture(scope="module")
def probes():
    return all_probes()


@pytest.mark.parametrize("library", LIBRARIES, indirect=True)
def test_its_passes_are_right(library, probes):
    verdict = short_ladder(PythonBackend(BACKEND, Limits()), probes)
    assert [text for timed in verdict.steps for text in timed.step.faults] == []
    assert verdict.status == "PASS"


@pytest.mark.slow
@pytest.mark.parametrize("library", LIBRARIES, indirect=True)
def test_it_passes(library):
    assert passed_the_whole_ladder(PythonBackend(BACKEND, Limits())) == FURTHER


@pytest.mark.parametrize("library", ["numpy"], indirect=True)
@pytest.mark.parametrize("plant", PLANTED)
@pytest.mark.few(2)
def test_a_planted_mistake_is_told_by_its_name(library, probes, tmp_path, plant):
    told_by_its_name(probes, tmp_path, plant)


@pytest.mark.slow
@pytest.mark.parametrize("library", ["strict", "torch"], indirect=True)
@pytest.mark.parametrize("plant", list(PLANTED)[::4])
def test_a_mistake_is_told_whatever_the_library(library, probes, tmp_path, plant):
    told_by_its_name(probes, tmp_path, plant)


def told_by_its_name(probes, folder, plant):
    path = planted_copy(FOLDER, folder, *PLANTED[plant])
    assert_named(short_ladder(PythonBackend(str(path), Limits()), probes), plant)


@pytest.mark.parametrize("library", LIBRARIES, indirect=True)
def test_it_returns_arrays_of_the_library(library):
    spec = spec_from_file_location("arrays_example", BACKEND)
    example = module_from_spec(spec)
    spec.loader.exec_module(example)
    one = np.ones(2, np.float32)
    found = example.BACKEND.finalize(w=one, p_hat=2 * one, Z=0 * one)["W"]
    module = type(found).__module__.partition(".")[0]
    assert module == LIBRARIES[library]
    assert host_array(found).tolist() == [0, 0]


def test_an_unknown_library_is_told_in_a_line(monkeypatch):
    monkeypatch.setenv("RESTIR_ARRAYS", "nunpy")
    with pytest.raises(Exception, match="RESTIR_ARRAYS is 'nunpy'; numpy, torch"):
        PythonBackend(BACKEND, Limits())
