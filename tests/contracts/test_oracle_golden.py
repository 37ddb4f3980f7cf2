"""Golden folders: whole, read by a program of ten lines, and judged."""

import json
import shutil
import struct

import numpy as np
import OpenEXR
import pytest

from reference.errors import UsageError
from reference.oracle.backends.files import FilesBackend
from reference.oracle.exr_frames import write_frames
from reference.oracle.frames import frame_cases
from reference.oracle.golden import expected, read_golden, write_golden
from reference.oracle.ladder import golden_rungs
from reference.oracle.parts import whole_contract
from reference.oracle.raw import read_cases
from reference.oracle.rungs.kernels import kernel_probes
from reference.oracle.rungs.lattice import lattice_probes
from reference.oracle.rungs.replayed import replayed
from reference.oracle.stage import stage
from reference.oracle.verdict import climb
from reference.scene.catalogue.registry import find_scene

CONTRACT = whole_contract()

SIZE = 12


def write(folder, precision="float32"):
    at = stage(find_scene("cornell-box"), SIZE, 3)
    probes = [*kernel_probes(precision), *lattice_probes(precision)]
    probes += [replayed("L3", case) for case in frame_cases(at, precision)]
    about = {"scene": "cornell-box", "size": SIZE, "seed": 3}
    write_golden(folder, CONTRACT, precision, probes, about, lambda *told: None)
    return folder


@pytest.fixture(scope="module")
def golden(tmp_path_factory):
    return write(tmp_path_factory.mktemp("golden") / "data")


@pytest.fixture
def copy(golden, tmp_path):
    return shutil.copytree(golden, tmp_path / "copy")


def verdict(folder):
    precision, probes = read_golden(folder)
    backend = FilesBackend(folder, precision)
    rungs = golden_rungs(CONTRACT, backend, probes)
    return climb(CONTRACT, precision, rungs, 60, lambda: 0.0, lambda title: None)


def answer_all(folder):
    """Put the expected outputs where a backend would put its own."""
    for case in (path for path in folder.iterdir() if path.is_dir()):
        shutil.copytree(case / "expected", case / "out", dirs_exist_ok=True)


def test_without_outputs_nothing_is_decided(golden):
    assert verdict(golden).status == "UNDECIDED"


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_expected_outputs_pass(precision, tmp_path):
    folder = write(tmp_path / "data", precision)
    answer_all(folder)
    assert verdict(folder).status == "PASS"


def test_a_changed_output_fails(copy):
    answer_all(copy)
    path = copy / "shade-cornell-box" / "out" / "color.raw"
    color = np.fromfile(path, "<f4") * np.float32(1.01)
    color.tofile(path)
    found = verdict(copy)
    assert found.status == "FAIL"
    assert [d.pass_name for d in found.diagnoses] == ["shade"]


def test_the_index_is_read_by_a_few_lines_of_anything(golden):
    """As C would: words, then bytes."""
    lines = [line.split() for line in (golden / "cases.txt").read_text().splitlines()]
    assert lines[0] == ["restir-cases", "1"]
    read = 0
    for words in lines:
        if words[0] != "in" or words[2] != "float32":
            continue
        shape = [int(n) for n in words[4:-1]]
        assert len(shape) == int(words[3])
        count = int(np.prod(shape))
        contents = (golden / words[-1]).read_bytes()
        numbers = struct.unpack(f"<{count}f", contents)
        assert np.isfinite(numbers).all()
        read += 1
    assert read > 100


def test_all_forms_hold_the_same_numbers(golden):
    _, cases = read_cases(golden)
    case = next(c for c in cases if c.name == "spatial-1Z-scattered-cornell-box")
    packed = np.load(golden / case.name / "in.npz")
    frame = {
        p.name(): p.channels
        for p in OpenEXR.File(str(golden / case.name / "frame.exr")).parts
    }
    wanted = expected(case, "float32")
    for name in ("visible_position", "W", "neighbors", "visible"):
        array = case.inputs[name]
        assert (packed[name] == array).all()
    pixels = frame["in.visible_position"]["RGB"].pixels.reshape(-1, 3)
    assert (pixels == case.inputs["visible_position"]).all()
    W = frame["expected.W"]["Y"].pixels.reshape(-1)
    assert (wanted["W"] == W).all()
    raw = np.fromfile(golden / case.name / "expected" / "W.raw", "<f4")
    assert (raw == wanted["W"]).all()


def test_outputs_may_come_as_npz_or_exr(copy):
    answer_all(copy)
    _, cases = read_cases(copy)
    by_name = {case.name: case for case in cases}
    for name, form in (
        ("shade-cornell-box", "npz"),
        ("temporal-cornell-box", "exr"),
        ("neighbors-cornell-box", "exr"),
    ):
        out = copy / name / "out"
        shutil.rmtree(out)
        out.mkdir()
        outputs = expected(by_name[name], "float32")
        if form == "npz":
            np.savez(out / "out.npz", allow_pickle=False, **outputs)
        else:
            write_frames(out / "out.exr", SIZE, outputs)
    assert verdict(copy).status == "PASS"


def test_a_corrupt_file_is_a_fault_and_not_the_end(copy):
    answer_all(copy)
    (copy / "shade-cornell-box" / "out" / "out.npz").write_bytes(b"PK\x03\x04 no zip")
    out = copy / "temporal-cornell-box" / "out"
    (out / "out.exr").write_bytes(b"\x76\x2f\x31\x01 nothing")
    found = verdict(copy)
    text = " ".join(line for timed in found.steps for line in timed.step.faults)
    assert found.status == "FAIL"
    assert "out.npz cannot be read" in text
    assert "out.exr" in text


def test_a_folder_with_something_else_is_not_replaced(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(UsageError, match="something else"):
        write(tmp_path)
    assert (tmp_path / "thesis.tex").exists()


def test_a_golden_folder_is_replaced_whole(copy):
    (copy / "shade-cornell-box" / "out" / "color.raw").write_bytes(b"old")
    write(copy)
    assert not (copy / "shade-cornell-box" / "out" / "color.raw").exists()
    assert [p.name for p in copy.parent.iterdir()] == [copy.name]


@pytest.mark.parametrize("contents", ["", "[]", '{"form": "other", "cases": []}'])
def test_what_is_no_manifest_is_told(copy, contents):
    (copy / "manifest.json").write_text(contents)
    with pytest.raises(UsageError, match="is not the manifest"):
        read_golden(copy)


def test_the_manifest_names_every_case(golden):
    manifest = json.loads((golden / "manifest.json").read_text())
    _, cases = read_cases(golden)
    assert [c.name for c in cases] == [entry["name"] for entry in manifest["cases"]]
