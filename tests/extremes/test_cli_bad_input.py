"""Bad input: one clear line, exit code 2, no traceback, nothing half-written."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from restir_gi.reference.cli import memory
from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr, write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.methods import Method, Progress, method_names
from restir_gi.reference.settings import Settings
from restir_gi.reference.system import plugins

ROOT = Path(__file__).parents[2]
METHOD = f"{Method.__module__}.{Method.__qualname__}"
PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
{x} 0 0
1 0 0
0 1 0
"""
SCENE = {
    "camera": {"origin": [0.2, 0.2, 2], "target": [0.2, 0.2, 0], "fov_deg": 40},
    "materials": {"grey": {"type": "diffuse", "reflectance": 0.5}},
    "shapes": [{"id": "wall", "file": "wall.ply", "material": "grey"}],
    "lights": [{"type": "constant", "radiance": 1}],
}
MINIMAL = ("--method", "path", "--spp", "1", "--size", "4x4")


@pytest.fixture
def refused(capsys, monkeypatch, tmp_path):
    """Run a command in an empty folder; it must be refused.  Returns the line."""
    folder = tmp_path / "empty"
    folder.mkdir()
    monkeypatch.chdir(folder)

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert (code, out) == (2, "")
        assert err.startswith("restir: ")
        assert len(err.splitlines()) == 1
        assert err.endswith("\n")
        assert list(folder.iterdir()) == []
        return err

    return run


@pytest.fixture
def scene_file(tmp_path):
    """Write a scene of one triangle, with changes, and return its path."""

    def write(x="0", face="3 0 1 2", **changes):
        faces = PLY.format(x=x, faces=1 if face else 0) + (f"{face}\n" if face else "")
        (tmp_path / "wall.ply").write_text(faces)
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(SCENE | changes))
        return path

    return write


def with_material(**change):
    """A scene whose only material is changed."""
    return {"materials": {"grey": {"type": "diffuse", "reflectance": 0.5} | change}}


# ---------------------------------------------------------------- arguments


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("--", "the following arguments are required: COMMAND"),
        ("sing", "unknown command 'sing'; known are scenes, render,"),
        ("render", "arguments are required: SCENE, --method, --out"),
        ("render door-ajar --method path --out x.exr --loud", "unrecognized arguments"),
        (
            "render door-ajar --method path --out x.exr --fra 3",
            "unrecognized arguments",
        ),
        (
            "render door-ajar --method tea --out x.exr",
            "unknown method 'tea'; known are",
        ),
        ("render dor-ajar --method path --out x.exr", "did you mean door-ajar"),
        ("render no.glb --method path --out x.exr", "cannot read no.glb: No such file"),
        ("render . --method path --out x.exr", "not in ''"),
        ("render door-ajar --method path --out x.png", "ends in .exr"),
        ("render door-ajar --method path --out x", "ends in .exr"),
        ("render door-ajar --method path --out no/x.exr", "there is no folder no"),
        ("reference door-ajar --out no/x.exr", "there is no folder no"),
        ("render door-ajar --method path --frames 2 --out x.exr", "has no --frames"),
        ("reference door-ajar --spp 1 --out x.exr", "from 2 to 134217727"),
        ("reference door-ajar --checkpoint never --out x.exr", "number of seconds"),
        ("reference door-ajar --checkpoint nan --out x.exr", "number of seconds"),
        (
            "reference door-ajar --set pixel=big --out x.exr",
            "pixel must be center or box",
        ),
        ("demo no.glb --out d", "cannot read no.glb"),
        ("demo --bounces 0 --out d", "from 1 to 30"),
        ("demo --runs 1 --out d", "from 2 to 1000"),
        ("compare a.exr b.exr", "cannot read a.exr: No such file"),
        ("compare a.exr", "arguments are required: B.exr"),
    ],
)
def test_arguments_that_make_no_sense(refused, line, reason):
    assert reason in refused(*line.split())


@pytest.mark.parametrize(
    ("option", "value"),
    [
        *[("--size", s) for s in ("0x4", "4x0", "-4x4", "4", "4x4x4", "axb", "4.5x4")],
        *[
            ("--size", s)
            for s in ("16385x1", "1x99999999", "\u0664x4", "9" * 30 + "x1")
        ],
        *[("--spp", n) for n in ("0", "-1", "1.5", "many", str(2**32), "")],
        *[("--seed", n) for n in ("-1", str(2**27), "x")],
        *[("--bounces", n) for n in ("-1", "31", "x")],
        *[("--threads", n) for n in ("0", "x")],
        *[("--band", n) for n in ("0", "x")],
        ("--light", "dark"),
    ],
)
def test_numbers_out_of_range(refused, option, value):
    line = refused("render", "door-ajar", *MINIMAL, "--out", "x.exr", option, value)
    assert f"argument {option}: " in line
    assert "see restir render --help" in line


def test_more_pixels_than_memory(refused, monkeypatch):
    monkeypatch.setattr(memory, "available_memory", lambda: 2**30)
    size = ("--size", "2000x2000")
    line = refused("render", "door-ajar", *MINIMAL, "--out", "x.exr", *size)
    assert "3.8 GiB of memory and 1.0 GiB are free" in line
    assert "--size 1024x1024" in line


def test_the_memory_of_this_machine_is_known():
    available = memory.available_memory()
    assert available is None or 2**20 < available < 2**50


@pytest.mark.parametrize(
    ("method", "setting", "reason"),
    [
        ("path", "color=red", "unknown setting 'color'; known are pixel=center|box"),
        ("path", "pixel", "not of the form KEY=VALUE"),
        ("path", "pixel=", "pixel must be center or box"),
        ("restir-gi-biased", "target=Outgoing", "must be scattered or outgoing"),
        ("restir-gi-biased", "spatial=perhaps", "must be true or false"),
        ("restir-gi-biased", "iterations_few=1.5", "must be INTEGER"),
        ("restir-gi-biased", "iterations_many=64", "out of range: 0 to 63"),
        ("restir-gi-biased", "radius=wide", "must be NUMBER"),
        ("restir-gi-biased", "radius=-0.1", "out of range: 0 to 1"),
        ("restir-gi-biased", "max_angle=inf", "out of range: 0 to 180"),
        ("restir-gi-biased", "temporal_cap=nan", "must be NUMBER"),
        ("restir-gi-biased", "temporal_cap=0", "out of range: 1 or more"),
    ],
)
def test_settings_that_are_not_known(refused, method, setting, reason):
    out = ("--out", "x.exr", "--set", setting)
    assert reason in refused("render", "door-ajar", "--method", method, *out)


@pytest.mark.parametrize("method", ["path", "restir-gi-unbiased"])
def test_layers_that_are_not_known(refused, method):
    out = ("--out", "x.exr", "--aov", "depth,smell")
    line = refused("render", "door-ajar", "--method", method, *out)
    assert "unknown layer 'smell'" in line
    assert "known are color, direct, indirect" in line


@pytest.mark.parametrize(
    "more",
    [
        ("restir-gi-biased", "--bounces", 0, "--aov", "M"),
        ("restir-gi-biased", "--light", "direct", "--aov", "mean"),
        ("path", "--spp", 1, "--aov", "standard_error"),
    ],
)
def test_layers_that_would_be_empty(refused, more):
    line = refused("render", "door-ajar", "--size", "4x4", "--out", "x.exr",
                   "--method", *more)  # fmt: skip
    assert f"--aov {more[-1]} needs" in line


# ---------------------------------------------------------------- scenes


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj", ".ply", ".json", ".xml"])
@pytest.mark.parametrize("contents", [b"", b"\x00\xff nonsense", b"{", b"<"])
def test_scene_files_that_are_none(refused, tmp_path, suffix, contents):
    if suffix == ".xml":
        pytest.importorskip("mitsuba")
    path = tmp_path / f"broken{suffix}"
    path.write_bytes(contents)
    line = refused("render", path, *MINIMAL, "--out", "x.exr")
    assert str(path) in line


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ({"x": "nan"}, "wall"),
        ({"x": "inf"}, "wall"),
        ({"x": "1e300"}, "wall"),
        ({"face": ""}, ""),
        ({"face": "3 0 1 7"}, ""),
        ({"face": "3 0 1 1"}, "no geometry"),
        ({"lights": []}, "light"),
        ({"shapes": []}, "no geometry"),
        (with_material(reflectance=-0.1), "reflectance"),
        (with_material(reflectance=1.1), "reflectance"),
        (with_material(reflectance=float("nan")), "reflectance"),
        ({"camera": SCENE["camera"] | {"fov_deg": 180}}, "camera"),
        ({"camera": SCENE["camera"] | {"target": SCENE["camera"]["origin"]}}, "camera"),
        ({"camera": SCENE["camera"] | {"origin": [0.2, 0.2, 0]}}, "camera"),
    ],
)
def test_scenes_that_cannot_be_rendered(refused, scene_file, file, reason):
    line = refused("render", scene_file(**file), "--method", "path", "--out", "x.exr")
    assert reason in line


@pytest.mark.parametrize("width", [0, -1, 10**6])
def test_scenes_of_absurd_size(refused, scene_file, width):
    camera = SCENE["camera"] | {"width": width, "height": 4}
    line = refused(
        "render", scene_file(camera=camera), "--method", "path", "--out", "x.exr"
    )
    assert str(width) in line


def test_a_camera_inside_a_solid(refused, scene_file):
    ball = {"id": "ball", "type": "sphere", "center": [0, 0, 2], "radius": 0.5}
    shapes = [*SCENE["shapes"], ball | {"material": "grey"}]
    path = scene_file(shapes=shapes)
    line = refused("render", path, *MINIMAL, "--out", "x.exr")
    assert "camera" in line


def test_triangles_without_area_are_dropped_and_counted(scene_file, capsys, tmp_path):
    path = scene_file()
    text = (
        (tmp_path / "wall.ply").read_text().replace("element face 1", "element face 2")
    )
    (tmp_path / "wall.ply").write_text(text + "3 0 1 1\n")
    out = tmp_path / "x.exr"
    assert main(["render", str(path), *MINIMAL, "--out", str(out)]) == 0
    (note,) = capsys.readouterr().err.splitlines()
    assert "1" in note
    assert note.partition(": ")[2].partition(": ")[2] in read_exr(out).metadata[
        "scene.notes"
    ]  # fmt: skip


# ---------------------------------------------------------------- images


def picture(width):
    """Grey, all the same."""
    return Image({"color": np.ones((4, width, 3), np.float32)})


def foreign(path, kind):
    """A file that is no picture of ours."""
    if kind == "folder":
        path.mkdir()
    elif kind == "PNG":
        path.write_bytes(b"\x89PNG\r\n\x1a\n")
    elif kind == "cut off":
        write_exr(path, picture(4))
        path.write_bytes(path.read_bytes()[:-40])
    elif kind == "black hole":
        color = np.full((4, 4, 3), np.nan, np.float32)
        write_exr(path, Image({"color": color}))
    else:
        path.touch()


@pytest.mark.parametrize("kind", ["folder", "PNG", "cut off", "empty", "black hole"])
def test_pictures_that_cannot_be_compared(refused, tmp_path, kind):
    good, bad = tmp_path / "good.exr", tmp_path / "bad.exr"
    write_exr(good, picture(4))
    foreign(bad, kind)
    assert str(bad) in refused("compare", good, bad, "--out", "report")
    assert str(bad) in refused("compare", bad, good, "--out", "report")


def test_pictures_of_two_sizes(refused, tmp_path):
    a, b = tmp_path / "a.exr", tmp_path / "b.exr"
    write_exr(a, picture(4))
    write_exr(b, picture(5))
    line = refused("compare", a, b, "--out", "report")
    assert "4x4 pixels" in line
    assert "5x4" in line


# ---------------------------------------------------------------- where results go


def test_a_folder_in_the_way(refused, tmp_path):
    (tmp_path / "x.exr").mkdir()
    for command in (("render", "--method", "path"), ("reference",)):
        line = refused(
            command[0], "door-ajar", *command[1:], "--out", tmp_path / "x.exr"
        )
        assert "not a regular file" in line


def test_a_file_in_the_way_of_a_folder(refused, tmp_path):
    for name in ("a.exr", "b.exr"):
        write_exr(tmp_path / name, picture(4))
    a, b = tmp_path / "a.exr", tmp_path / "b.exr"
    assert "cannot make" in refused("compare", a, b, "--out", a)
    assert "cannot make" in refused("demo", "--out", a)


def test_a_folder_that_may_not_be_written(refused, tmp_path):
    folder = tmp_path / "closed"
    folder.mkdir()
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("permissions do not bind this user")
    line = refused("render", "door-ajar", *MINIMAL, "--out", folder / "x.exr")
    assert "may not be written" in line


LIMITED = """
import resource, sys
from restir_gi.reference.cli.main import main
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on file size there")
@pytest.mark.parametrize(
    "command",
    [
        ("render", "--method", "path", "--spp", "1", "--light", "full"),
        ("reference", "--spp", "2"),
    ],
)
def test_a_disk_that_is_full(tmp_path, command):
    """Files end after 1000 bytes: what was there stays, and nothing else is there."""
    out = tmp_path / "x.exr"
    out.write_bytes(b"old")
    arguments = (command[0], "door-ajar", "--size", "32x32", *command[1:], "--out", out)
    script = LIMITED.format(limit=1000)
    result = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert (result.returncode, result.stdout) == (2, "")
    (line,) = result.stderr.splitlines()
    assert "cannot write" in line
    assert os.strerror(errno.EFBIG) in line
    assert [path.name for path in tmp_path.iterdir()] == ["x.exr"]
    assert out.read_bytes() == b"old"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no such device")
@pytest.mark.parametrize("arguments", [("scenes",), ("scenes", "--json"), ("--help",)])
def test_results_that_cannot_be_written(arguments):
    environment = os.environ | {"PYTHONUNBUFFERED": ""}
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [sys.executable, "-m", "restir_gi.reference", *arguments],
            cwd=ROOT,
            env=environment,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert result.returncode == 2
    assert result.stderr == (
        f"restir: cannot write to stdout: {os.strerror(errno.ENOSPC)}\n"
    )


# ---------------------------------------------------------------- ended from outside


@pytest.mark.skipif(sys.platform == "win32", reason="other signals there")
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_ctrl_c(tmp_path, name, code):
    """While it renders; that a truth keeps its checkpoint, `test_accumulate` shows."""
    out = tmp_path / "x.exr"
    out.write_bytes(b"old")
    script = (
        "import sys\n"
        "from restir_gi.reference.cli import main as cli\n"
        "from restir_gi.reference.methods import method\n"
        "Progress = method.Progress\n"
        "def told(*words):\n"
        "    sys.stderr.write('on\\n' if words[0] == 1 else '')\n"
        "    sys.stderr.flush()\n"
        "    return Progress(*words)\n"
        "from restir_gi.reference.methods import path\n"
        "path.Progress = told\n"
        "sys.exit(cli.main(sys.argv[1:]))\n"
    )
    arguments = ["render", "door-ajar", "--method", "path", "--spp", "1000000"]
    with subprocess.Popen(
        [sys.executable, "-c", script, *arguments, "--out", str(out)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stderr.readline() == "on\n"
            time.sleep(0.05)
            process.send_signal(getattr(signal, name))
            stdout, stderr = process.communicate(timeout=60)
        finally:
            process.kill()
    assert (process.returncode, stdout) == (code, "")
    assert len(stderr.splitlines()) == 1
    assert "nothing half-written is left" in stderr
    assert [path.name for path in tmp_path.iterdir()] == ["x.exr"]
    assert out.read_bytes() == b"old"


# ---------------------------------------------------------------- methods of others


def nothing(job):
    """Render no picture."""
    yield Progress(1, 1, "frames")
    return {}


def too_few(job):
    """Render three pixels."""
    yield Progress(1, 1, "frames")
    return {"color": np.zeros((3, 3))}


def a_method(render, name="grey"):
    """A method that somebody else might bring along."""
    return Method(
        name=name, summary="", counts={}, settings=Settings(), aovs={}, render=render
    )


@pytest.fixture
def register(monkeypatch):
    """Announce an object as the method "grey", some number of times."""

    def register(found, times=1):
        def load():
            if isinstance(found, Exception):
                raise found
            return found

        point = SimpleNamespace(name="grey", value="grey:METHOD", dist=None, load=load)
        monkeypatch.setattr(
            plugins,
            "entry_points",
            lambda group, name="grey": [point] * times if name == "grey" else [],
        )

    return register


@pytest.mark.parametrize(
    ("found", "reason"),
    [
        (
            ImportError("no module\nnamed 'grey'"),
            "cannot be loaded (ImportError: no mod",
        ),
        (ZeroDivisionError(), "cannot be loaded (ZeroDivisionError"),
        (None, f"is None, which is not a {METHOD} of that name"),
        (a_method(nothing, "gray"), f"which is not a {METHOD} of that name"),
        (a_method(nothing), "did not return a picture"),
        (a_method(too_few), "3 rows do not make a 4x4 frame"),
    ],
)
def test_a_broken_package_is_named(refused, register, found, reason):
    register(found)
    size = ("--size", "4x4", "--out", "x.exr")
    line = refused("render", "door-ajar", "--method", "grey", *size)
    assert "method 'grey'" in line
    assert reason in line
    # It disturbs nobody else, and is known without being loaded.
    assert "grey" in method_names()
    assert "known are path," in refused(
        "render", "x", "--method", "y", "--out", "x.exr"
    )


def test_two_packages_of_one_method(refused, register):
    register(a_method(nothing), times=2)
    line = refused("render", "door-ajar", "--method", "grey", "--out", "x.exr")
    assert "registered by" in line
    assert "uninstall all but one" in line
