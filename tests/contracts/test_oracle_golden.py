"""Golden folders: whole, read by a program of ten lines, and judged."""

import errno
import json
import shutil
import signal
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from restir_gi.reference.oracle.backends.files import FilesBackend
from restir_gi.reference.oracle.exr_frames import write_frames
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.golden import expected, read_golden, write_golden
from restir_gi.reference.oracle.ladder import golden_levels
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.lattice import lattice_probes
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.oracle.raw import read_cases
from restir_gi.reference.oracle.verdict import run_ladder
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.leftovers import sweep

CONTRACT = whole_contract()

SIZE = 12


def write_few(folder):
    """Golden data of the kernels alone, which are made quickly."""
    about = {"scene": "cornell-box", "size": SIZE, "seed": 3}
    probes = kernel_probes("float32")[::4]
    write_golden(folder, CONTRACT, "float32", probes, about, lambda *told: None)
    return folder


def write(folder, precision="float32"):
    at = prepare_frame(find_scene("cornell-box"), SIZE, 3)
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
    levels = golden_levels(CONTRACT, backend, probes)
    return run_ladder(CONTRACT, precision, levels, 60, lambda: 0.0, lambda title: None)


def answer_all(folder):
    """Put the expected outputs where a backend would put its own."""
    for case in (path for path in folder.iterdir() if path.is_dir()):
        shutil.copytree(case / "expected", case / "out", dirs_exist_ok=True)


def test_without_outputs_nothing_is_decided(golden):
    assert verdict(golden).status == "UNDECIDED"


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.few(1)
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


FOREIGN = {
    "nothing of ours": {"thesis.tex": "years of work"},
    "a manifest of another program": {"manifest.json": '{"name": "app"}'},
    "a manifest that is a list": {"manifest.json": "[]"},
    "a manifest nested without end": {"manifest.json": 100_000 * "["},
    "a hidden file": {".keep": ""},
    "golden data that list no files": {
        "manifest.json": '{"form": "restir-golden 1", "cases": []}'
    },
}


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


@pytest.mark.parametrize("what", FOREIGN)
def test_a_foreign_folder_is_left_alone(tmp_path, what):
    folder = tmp_path / "folder"
    for name, text in {**FOREIGN[what], "src/main.c": "int main;"}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    before = contents(folder)
    with pytest.raises(UsageError, match=r"other files|did not list") as error:
        write(folder)
    assert len(str(error.value).splitlines()) == 1
    assert contents(tmp_path / "folder") == before
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


@pytest.fixture
def few(tmp_path):
    return write_few(tmp_path / "few")


CASE = kernel_probes("float32")[0].case.name


def listed(folder):
    return json.loads((folder / "manifest.json").read_text())["files"]


def test_the_manifest_lists_every_file(golden):
    assert sorted(contents(golden)) == sorted(listed(golden))


def test_a_golden_folder_is_replaced_but_for_what_is_not_golden(few):
    """Results of a backend and whatever else somebody has put there."""
    mine = {
        f"{CASE}/out/color.raw": b"result",
        "notes.txt": b"mine",
        "gone/out/W.raw": b"a result of a case that is gone",
    }
    stale = {"gone/in/u.raw": b"old", "empty/in/u.raw": b"old"}
    for name, text in {**mine, **stale}.items():
        (few / name).parent.mkdir(parents=True, exist_ok=True)
        (few / name).write_bytes(text)
    (few / "empty" / "out").mkdir()
    (few / CASE / "in.npz").write_bytes(b"damaged")
    manifest = json.loads((few / "manifest.json").read_text())
    manifest["files"] += stale
    (few / "manifest.json").write_text(json.dumps(manifest))
    write_few(few)
    left = contents(few)
    assert {name: left.get(name) for name in mine} == mine
    assert sorted(set(left) - set(mine)) == sorted(listed(few))
    assert left[f"{CASE}/in.npz"] != b"damaged"
    assert not (few / "empty").exists()
    assert [p.name for p in few.parent.iterdir()] == [few.name]


@pytest.mark.parametrize("name", ["../precious", "/precious", "link/precious"])
def test_a_manifest_that_lists_what_lies_outside_is_not_believed(few, tmp_path, name):
    outside = tmp_path / "precious"
    outside.write_text("mine")
    (few / "link").symlink_to(tmp_path)
    manifest = json.loads((few / "manifest.json").read_text())
    manifest["files"].append(str(tmp_path / "precious") if name[0] == "/" else name)
    (few / "manifest.json").write_text(json.dumps(manifest))
    write_few(few)
    assert outside.read_text() == "mine"


def test_an_error_half_way_moves_everything_back(few, monkeypatch):
    before = contents(few)
    rename, count = Path.rename, iter(range(10**6))

    def fail(self, target):
        if next(count) == 20:
            raise OSError(errno.EIO, "input/output error")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fail)
    with pytest.raises(UsageError, match="input/output error"):
        write_few(few)
    monkeypatch.undo()
    assert contents(few) == before


def test_after_a_kill_half_way_the_next_run_goes_on(few, tmp_path):
    (few / CASE / "out" / "color.raw").write_bytes(b"result")
    script = f"""
import os, signal, sys
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
from pathlib import Path
from tests.contracts.test_oracle_golden import write_few
rename, count = Path.rename, iter(range(10**6))
def killed(self, target):
    if next(count) == 20:
        os.kill(os.getpid(), signal.SIGKILL)
    return rename(self, target)
Path.rename = killed
write_few(Path({str(few)!r}))
"""
    run = subprocess.run([sys.executable, "-c", script], check=False)
    assert run.returncode == -signal.SIGKILL
    with pytest.raises(UsageError, match="is not the manifest"):
        read_golden(few)
    sweep.cache_clear()  # this process plays the next one
    write_few(few)
    left = contents(few)
    assert left.pop(f"{CASE}/out/color.raw") == b"result"
    assert sorted(left) == sorted(listed(few))


@pytest.mark.parametrize("contents", ["", "[]", '{"form": "other", "cases": []}'])
def test_what_is_no_manifest_is_told(copy, contents):
    (copy / "manifest.json").write_text(contents)
    with pytest.raises(UsageError, match="is not the manifest"):
        read_golden(copy)


def test_the_manifest_names_every_case(golden):
    manifest = json.loads((golden / "manifest.json").read_text())
    _, cases = read_cases(golden)
    assert [c.name for c in cases] == [entry["name"] for entry in manifest["cases"]]
