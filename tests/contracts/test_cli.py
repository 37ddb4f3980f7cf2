"""The command line as other programs see it: files, JSON, headers, exit codes."""

import json
import re
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Literal

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods import (
    Method,
    Progress,
    method_named,
    method_names,
)
from restir_gi.reference.methods.metadata import header
from restir_gi.reference.methods.setting_values import as_text, known, with_values
from restir_gi.reference.scene.animation import still, with_change
from restir_gi.reference.scene.camera import view_depth
from restir_gi.reference.scene.catalogue.registry import CATALOGUE, find_scene
from restir_gi.reference.scene.origins import STEP
from restir_gi.reference.system import plugins
from restir_gi.reference.system.json_text import json_text

ROOT = Path(__file__).parents[2]
COMMANDS = ("scenes", "render", "reference", "compare", "demo")
BUILT_IN = ("path", "restir-gi-biased", "restir-gi-unbiased")

ROOM = ("cornell-box", "--size", "12x8")


@pytest.fixture
def restir(capsys):
    """Run a command in this process; it must succeed.  Returns what is on stdout."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert (code, err) == (0, "")
        return out

    return run


@pytest.fixture
def render(restir, tmp_path):
    """Render the room and read the picture."""

    def run(method, *arguments, scene=ROOM):
        out = tmp_path / "x.exr"
        restir("render", *scene, "--method", method, "--out", out, *arguments)
        return read_exr(out)

    return run


def few(method):
    """Options that make a method quick."""
    if method == "path":
        return ("--spp", 3)
    return ("--frames", 3, "--spp", 2)


# ---------------------------------------------------------------- the program


def test_it_runs_as_a_module():
    command = [sys.executable, "-m", "restir_gi.reference", "--version"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0
    assert re.fullmatch(r"restir-gi-oracle \S.*\n", result.stdout)
    assert result.stderr == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(restir, command):
    text = restir(command, "--help")
    assert text.startswith(f"usage: restir {command} ")
    assert "--json" in text


def test_the_help_lists_every_command(restir):
    text = restir("--help")
    assert all(
        re.search(rf"^ +{command}\b", text, re.MULTILINE) for command in COMMANDS
    )


def test_nobody_reads_the_output():
    """A pipe that is closed at once: no traceback, and the exit code of `yes`."""
    command = f"{sys.executable} -m restir_gi.reference scenes"
    script = f"{command} | true; exit ${{PIPESTATUS[0]}}"
    result = subprocess.run(
        ["bash", "-c", script], cwd=ROOT, capture_output=True, text=True
    )
    assert (result.returncode, result.stderr) == (141, "")


# ---------------------------------------------------------------- scenes


def test_scenes_lists_the_catalogue(restir):
    text = restir("scenes")
    assert all(name in text for name in CATALOGUE)
    assert text.count("animated:") == 5


def test_scenes_for_a_program(restir):
    scenes = json.loads(restir("scenes", "--json"))["scenes"]
    assert [scene["name"] for scene in scenes] == list(CATALOGUE)
    for scene in scenes:
        assert scene["summary"]
        assert scene["animated"] == (CATALOGUE[scene["name"]].animate is not None)
        assert all(need["name"] and need["why"] for need in scene["requires"])


# ---------------------------------------------------------------- render


def test_the_built_in_methods_are_known():
    assert set(BUILT_IN) <= set(method_names())


@pytest.mark.parametrize("method", BUILT_IN)
def test_a_picture_says_where_it_comes_from(render, method):
    image = render(method, *few(method), "--seed", 7, "--bounces", 2)
    expected = {
        "scene": "cornell-box",
        "method": method,
        "light": "indirect",
        "bounces": "2",
        "seed": "7",
        "frame": "0",
        few(method)[0].lstrip("-"): "3",
    }
    assert expected.items() <= image.metadata.items()
    assert {
        "version",
        "seconds",
        "rays.primary",
        "rays.shadow",
    } <= image.metadata.keys()
    assert float(image.metadata["seconds"]) > 0
    assert int(image.metadata["rays.primary"]) == 12 * 8
    setting = "pixel" if method == "path" else "temporal_cap"
    assert f"settings.{setting}" in image.metadata
    assert (image.width, image.height) == (12, 8)
    assert np.isfinite(image.color).all()
    assert image.color.any()


@pytest.mark.parametrize("method", BUILT_IN)
@pytest.mark.parametrize("light", ["indirect", "full"])
def test_bands_and_threads_change_no_bit(render, method, light):
    aovs = ("--light", light, "--aov", "direct,indirect,depth", *few(method))
    first = render(method, *aovs, "--threads", 1, "--band", 10_000)
    for schedule in (("--threads", 1, "--band", 7), ("--threads", 3, "--band", 10), ()):
        other = render(method, *aovs, *schedule)
        assert first.layers.keys() == other.layers.keys()
        for name, layer in first.layers.items():
            np.testing.assert_array_equal(layer, other.layers[name], strict=True)


@pytest.mark.parametrize("method", BUILT_IN)
def test_seeds_change_the_picture(render, method):
    a, b = (render(method, *few(method), "--seed", seed) for seed in (0, 1))
    assert (a.color != b.color).any()


@pytest.mark.parametrize("method", BUILT_IN)
def test_direct_and_indirect_add_up(render, method):
    """Of path tracing up to the rounding of sums of a few float64, and of float32."""
    image = render(method, *few(method), "--light", "full", "--aov", "direct,indirect")
    total = image.layers["direct"] + image.layers["indirect"]
    np.testing.assert_allclose(image.color, total, rtol=4 * 2.0**-24, atol=1e-12)
    for light in ("direct", "indirect"):
        alone = render(method, *few(method), "--light", light)
        np.testing.assert_array_equal(alone.color, image.layers[light])


@pytest.mark.parametrize("method", BUILT_IN)
def test_without_a_bounce_there_is_no_indirect_light(render, method):
    assert not render(method, *few(method), "--bounces", 0).color.any()
    full = render(method, *few(method), "--bounces", 0, "--light", "full")
    direct = render(method, *few(method), "--bounces", 0, "--light", "direct")
    np.testing.assert_array_equal(full.color, direct.color)


def test_the_header_names_what_biases_the_picture(render):
    image = render("restir-gi-biased", "--frames", 2)
    assert image.metadata["biases"].startswith("mis=1/M: ")
    assert "biases" not in render("restir-gi-unbiased", "--frames", 2).metadata
    light = render("restir-gi-biased", "--light", "direct", "--spp", 1)
    assert "biases" not in light.metadata


def test_layers_of_the_reservoirs(render):
    names = "M,W,radiance,sample_position,sample_normal,mean"
    image = render("restir-gi-unbiased", "--frames", 3, "--aov", names)
    assert image.layers.keys() == {"color", *names.split(",")}
    M, W = image.layers["M"], image.layers["W"]
    assert M.shape == (8, 12, 1)
    assert (M >= 1).any()
    assert (M <= 500).all()
    full = W[..., 0] > 0
    np.testing.assert_allclose(
        np.linalg.norm(image.layers["sample_normal"][full], axis=-1), 1, rtol=1e-6
    )
    # A kept sample lies in the room, 2 m wide, and sends light.
    assert (np.abs(image.layers["sample_position"]) < 2.01).all()
    assert (image.layers["radiance"][full].max(axis=-1) > 0).all()
    assert not image.layers["radiance"][~full].any()


def test_layers_of_what_is_seen(render):
    """Depth is that of the position, which rays leave up to two steps before it."""
    image = render("path", "--spp", 1, "--aov", "depth,normal,albedo,position")
    assert image.layers["depth"].shape == (8, 12, 1)
    norms = np.linalg.norm(image.layers["normal"], axis=-1)
    seen = image.layers["depth"][..., 0] > 0
    assert seen.any()
    np.testing.assert_allclose(norms[seen], 1, rtol=1e-6)
    np.testing.assert_array_equal(norms[~seen], 0)
    position, depth = image.layers["position"], image.layers["depth"][..., 0]
    camera = find_scene("cornell-box").camera
    expected = view_depth(camera, position[seen].astype(float))
    float32 = 8 * 2.0**-24  # of coordinates up to 4
    np.testing.assert_allclose(depth[seen], expected, atol=2 * 2 * STEP + float32)
    assert 0 <= image.layers["albedo"].min() < image.layers["albedo"].max() <= 1


def test_the_mean_of_all_frames(render):
    """The layer, the setting, and the frames themselves agree."""
    frames = [
        render("restir-gi-unbiased", "--frames", frame).color.astype(float)
        for frame in (1, 2, 3)
    ]
    by_setting = render("restir-gi-unbiased", "--frames", 3, "--set", "image=mean")
    by_layer = render("restir-gi-unbiased", "--frames", 3, "--aov", "mean")
    np.testing.assert_array_equal(by_setting.color, by_layer.layers["mean"])
    np.testing.assert_array_equal(by_layer.color, frames[-1])
    np.testing.assert_allclose(by_setting.color, np.mean(frames, axis=0), rtol=1e-6)


def test_standard_error_of_path_tracing(render):
    image = render("path", "--spp", 8, "--aov", "standard_error")
    assert image.layers["standard_error"].shape == (8, 12, 3)
    assert image.layers["standard_error"].any()


def test_rays_anywhere_in_the_pixel(render):
    """What is seen differs from sample to sample; edges show it in direct light."""
    arguments = ("--spp", 4, "--light", "direct")
    center = render("path", *arguments)
    box = render("path", *arguments, "--set", "pixel=box")
    assert box.metadata["settings.pixel"] == "box"
    assert (center.color != box.color).any()
    assert int(box.metadata["rays.primary"]) == 4 * int(center.metadata["rays.primary"])


def test_render_for_a_program(restir, tmp_path):
    out = tmp_path / "x.exr"
    text = restir(
        "render", *ROOM, "--method", "path", "--spp", 1, "--out", out, "--png",
        "--json", "--aov", "depth",
    )  # fmt: skip
    results = json.loads(text)
    assert results["out"] == str(out)
    assert results["layers"] == ["color", "depth"]
    assert results["black"] is None
    assert header(results["metadata"]) == dict(read_exr(out).metadata)
    assert results["metadata"]["spp"] == 1
    assert results["metadata"]["settings.pixel"] == "center"
    assert Path(results["png"]).read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.exr", "x.png"]


BALL = {
    "name": "ball",
    "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "fov_deg": 45},
    "materials": {"m": {"type": "diffuse", "reflectance": 0.8, "twosided": True}},
    "shapes": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"}],
    "environment": 1,
}
ONE_SIDED = {"m": {"type": "diffuse", "reflectance": 0.8}}
LAMP = {"type": "point", "position": [0, 0, 5], "intensity": 1}


def eye(z, target):
    return {"camera": {"origin": [0, 0, z], "target": target, "fov_deg": 45}}


BLACK = {
    "one convex object": ({}, (), "a second time.*--light full"),
    "in the shade": (
        {"environment": 0, "lights": [LAMP]} | eye(-4, [0, 0, 0]),
        ("--light", "direct"),
        "no light was found",
    ),
    "looking away": (eye(4, [0, 0, 8]), (), "sees no surface"),
    "seen from behind": (
        {
            "materials": ONE_SIDED,
            "shapes": [{**BALL["shapes"][0], "inward": True}],
            "environment": 0,
            "lights": [LAMP],
        },
        ("--light", "full"),
        "backs of one-sided materials",
    ),
}


@pytest.mark.parametrize("method", ["path", "restir-gi-unbiased"])
@pytest.mark.parametrize("case", BLACK)
def test_a_black_picture_says_why(restir, tmp_path, method, case):
    changes, arguments, reason = BLACK[case]
    scene, out = tmp_path / "ball.json", tmp_path / "x.exr"
    scene.write_text(json.dumps(BALL | changes))
    command = ("render", scene, "--method", method, "--size", "8x8", *arguments)
    command = (*command, "--out", out)
    text = restir(*command)
    assert not read_exr(out).color.any()
    (line,) = [s for s in text.splitlines() if s.startswith("Every pixel is black: ")]
    assert re.search(reason, line)
    told = json.loads(restir(*command, "--json"))["black"]
    assert line == f"Every pixel is black: {told}"


def test_a_light_that_has_gone_out_is_why(restir, tmp_path):
    text = restir(
        "render", "light-switch", "--frame", "40", "--method", "path", "--size", "8x8",
        "--out", tmp_path / "x.exr",
    )  # fmt: skip
    assert "Every pixel is black: nothing emits light in frame 40" in text


def test_a_demo_of_a_black_picture_says_so(restir, tmp_path):
    scene = tmp_path / "ball.json"
    scene.write_text(json.dumps(BALL))
    quick = ("--spp", 4, "--frames", 2, "--runs", 2, "--size", "8x8", "--json")
    results = json.loads(restir("demo", scene, "--out", tmp_path / "d", *quick))
    assert "a second time" in results["black"]
    assert "a second time" in (tmp_path / "d" / "index.html").read_text()


def test_a_scene_from_a_file(restir, tmp_path):
    path = tmp_path / "tent.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n")
    out = tmp_path / "x.exr"
    code = main(
        ["render", str(path), "--method", "path", "--spp", "1", "--out", str(out),
         "--size", "8x8", "--lenient"]
    )  # fmt: skip
    assert code == 0
    assert read_exr(out).width == 8


# ---------------------------------------------------------------- animated scenes

SMALL = ("--size", "12x8")
RESTIR = BUILT_IN[1:]


@pytest.mark.parametrize("method", RESTIR)
def test_the_picture_is_of_the_last_frame(render, method):
    """What is seen through the pixels; so the truth is that of frame T + F - 1."""
    scene = ("moving-camera", *SMALL)
    aovs = ("--aov", "depth,normal,albedo,position")
    for light in ("indirect", "direct"):
        arguments = ("--frame", 5, "--frames", 3, "--spp", 1, "--light", light, *aovs)
        image = render(method, *arguments, scene=scene)
        path = render("path", "--spp", 1, "--frame", 7, *aovs, scene=scene)
        for name in ("depth", "normal", "albedo", "position"):
            np.testing.assert_array_equal(image.layers[name], path.layers[name])
    assert image.metadata["frame"] == "5"
    assert path.metadata["frame"] == "7"
    early = render("path", "--spp", 1, "--frame", 5, *aovs, scene=scene)
    assert (path.layers["depth"] != early.layers["depth"]).any()


@pytest.mark.parametrize("name", ["moving-light", "moving-block", "light-switch"])
def test_direct_light_is_that_of_the_last_frame(render, name):
    scene, direct = (name, *SMALL), ("--spp", 4, "--light", "direct")
    method = "restir-gi-unbiased"
    last = render(method, "--frame", 16, "--frames", 1, *direct, scene=scene)
    moved = render(method, "--frame", 14, "--frames", 3, *direct, scene=scene)
    np.testing.assert_array_equal(moved.color, last.color)
    full = ("--spp", 4, "--light", "full", "--aov", "direct")
    whole = render(method, "--frame", 14, "--frames", 3, *full, scene=scene)
    np.testing.assert_array_equal(whole.layers["direct"], last.color)
    first = render(method, "--frame", 14, "--frames", 1, *direct, scene=scene)
    assert (first.color != last.color).any()


@pytest.mark.parametrize("method", RESTIR)
def test_the_frames_of_a_run_are_those_of_the_animation(render, method):
    """Where the light goes out: light of the past is what only the biased one keeps."""
    scene, full = ("light-switch", *SMALL), ("--light", "full", "--spp", 2)
    frames = ("--frame", 14, "--frames")
    assert render(method, *frames, 2, *full, scene=scene).color.any()
    after = render(method, *frames, 3, *full, scene=scene)
    assert after.color.any() == (method == "restir-gi-biased")
    dark = render(method, "--frame", 16, "--frames", 3, *full, scene=scene)
    assert not dark.color.any()


@pytest.mark.parametrize("name", ["moving-camera", "moving-block", "moving-light"])
def test_rays_are_counted_over_all_frames(render, name):
    """A G-buffer for each, whether the geometry is rebuilt or not."""
    image = render("restir-gi-unbiased", "--frames", 3, scene=(name, *SMALL))
    assert image.metadata["rays.primary"] == str(3 * 12 * 8)


@pytest.mark.parametrize("method", BUILT_IN)
def test_a_scene_that_stands_still_is_the_same_at_every_frame(render, method):
    now, later = (render(method, *few(method), "--frame", t) for t in (0, 40))
    np.testing.assert_array_equal(now.color, later.color)
    assert later.metadata["frame"] == "40"


@pytest.mark.parametrize("method", RESTIR)
def test_a_scene_that_moves_has_other_pictures(render, method):
    scene = ("moving-block", *SMALL)
    now, later = (
        render(method, "--frames", 2, "--frame", t, scene=scene) for t in (0, 20)
    )
    assert (now.color != later.color).any()


def test_truths_of_other_frames_have_other_checkpoints(restir, tmp_path, capsys):
    """Refused for another scene, not for another name of the same one."""

    def truth(name, frame, spp):
        out = tmp_path / f"{name}.exr"
        arguments = ("--spp", spp, "--frame", frame, "--out", out, "--keep")
        return ["reference", name, *SMALL, *arguments]

    restir(*truth("moving-block", 3, 2))
    assert main([str(a) for a in truth("moving-block", 4, 3)]) == 2
    line = capsys.readouterr().err
    assert "scene" in line
    assert line.count("\n") == 1
    restir(*truth("moving-block", 3, 3))
    restir(*truth("light-switch", 3, 2))
    restir(*truth("light-switch", 4, 3))
    image = read_exr(tmp_path / "light-switch.exr")
    assert (image.metadata["frame"], image.metadata["spp"]) == ("4", "3")


def test_a_bad_frame_is_told_by_its_number(monkeypatch, tmp_path, capsys):
    def animate(scene):
        bad = replace(scene, camera=replace(scene.camera, fov=-1.0))
        return with_change(still(scene), 6, lambda _: bad)

    entry = replace(CATALOGUE["cornell-box"], animate=animate)
    monkeypatch.setitem(CATALOGUE, "cornell-box", entry)
    out = tmp_path / "x.exr"
    command = ["render", *ROOM, "--method", "restir-gi-biased", "--frames", "3"]
    assert main([*command, "--frame", "5", "--out", str(out)]) == 2
    line = capsys.readouterr().err
    assert "frame 6 of cornell-box: camera: fov is -1" in line
    assert line.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("frame", ["-1", "x", "1.5", str(2**27)])
def test_a_frame_is_a_whole_number(capsys, frame):
    command = ["render", *ROOM, "--method", "path", "--out", "x.exr"]
    assert main([*command, f"--frame={frame}"]) == 2
    line = capsys.readouterr().err
    assert "--frame" in line
    assert line.count("\n") == 1


# ---------------------------------------------------------------- methods of others


@dataclass(frozen=True, kw_only=True)
class Shade:
    """Settings of every kind that text can give."""

    level: float = 0.5
    steps: int = 1
    dark: bool = False
    name: str = "grey"
    kind: Literal["one", "two"] = "one"


def grey(job):
    """Render one value everywhere, and a ramp beside it."""
    pixels = job.world.camera.width * job.world.camera.height
    yield Progress(1, 1, "frames")
    layers = {"color": np.full((pixels, 3), job.settings.level)}
    return layers | {name: np.arange(float(pixels)) for name in job.aovs}


GREY = Method(
    name="grey",
    summary="Grey",
    counts={"frames": 3},
    settings=Shade(),
    aovs={"ramp": "number of the pixel"},
    render=grey,
)


def test_a_method_of_another_package(render, monkeypatch):
    """Announced by an entry point, it has the options of the built-in ones."""
    point = SimpleNamespace(name="grey", value="x:GREY", dist=None, load=lambda: GREY)
    monkeypatch.setattr(plugins, "entry_points", lambda **_: [point])
    assert method_names() == [*BUILT_IN, "grey"]
    image = render("grey", "--set", "level=0.25", "--aov", "ramp")
    assert (image.color == 0.25).all()
    np.testing.assert_array_equal(image.layers["ramp"].ravel(), np.arange(96))
    assert image.metadata["frames"] == "3"
    assert image.metadata["settings.level"] == "0.25"


def test_settings_are_read_by_their_types():
    text = ["level=inf", "steps=-3", "dark=Yes", "name=a=b", "kind=two", "steps=7"]
    expected = Shade(level=np.inf, steps=7, dark=True, name="a=b", kind="two")
    settings = with_values(Shade(), text)
    assert settings == expected
    # Written and read again they are the same.
    again = [f"{key}={value}" for key, value in as_text(settings).items()]
    assert with_values(Shade(), again) == expected
    assert known(Shade()) == (
        "level=NUMBER, steps=INTEGER, dark=true|false, name=TEXT, kind=one|two"
    )


@pytest.mark.parametrize("name", BUILT_IN)
def test_settings_of_a_header_make_the_method_again(name):
    method = method_named(name)
    text = [f"{key}={value}" for key, value in as_text(method.settings).items()]
    assert with_values(method.settings, text) == method.settings


# ---------------------------------------------------------------- compare


def test_compare_a_picture_with_itself(restir, render, tmp_path):
    render("path", "--spp", 2)
    x, out = tmp_path / "x.exr", tmp_path / "page"
    numbers = json.loads(restir("compare", x, x, "--out", out, "--json"))
    assert (numbers["mse"], numbers["relative_bias"]) == (0, 0)
    assert (numbers["a"], numbers["page"]) == (str(x), str(out / "index.html"))
    assert (out / "index.html").read_text().startswith("<!doctype html>")
    assert "RMSE" in restir("compare", x, x)


# ---------------------------------------------------------------- demo


def test_the_demonstration(restir, tmp_path):
    out = tmp_path / "new" / "out"
    quick = ("--size", "16x12", "--spp", 4, "--frames", 2, "--runs", 2)
    text = restir("demo", "--out", out, *quick)
    assert text.rstrip().endswith(f"{out / 'teaser.png'}.")
    files = {path.relative_to(out).as_posix() for path in out.rglob("*.*")}
    page = (out / "index.html").read_text()
    linked = set(re.findall(r'(?:href|src)="([^"]+)"', page))
    assert linked <= files
    for name in (*BUILT_IN, "truth"):
        assert {f"{name}.exr", f"{name}.png"} <= linked
        assert read_exr(out / f"{name}.exr").metadata["scene"] == "door-ajar"
    assert not [name for name in files if "checkpoint" in name]
    methods = json.loads((out / "numbers.json").read_text())["methods"]
    assert [m["name"] for m in methods] == list(BUILT_IN)


def test_the_demonstration_of_another_scene(restir, tmp_path):
    quick = ("--spp", 4, "--frames", 2, "--runs", 2, "--json")
    results = json.loads(restir("demo", *ROOM, "--out", tmp_path, *quick))
    assert results["scene"] == "cornell-box"
    assert [m["name"] for m in results["methods"]] == list(BUILT_IN)


def test_the_demonstration_of_an_animated_scene(restir, tmp_path):
    """All pictures are of the last frame."""
    quick = ("--spp", 4, "--frames", 3, "--runs", 2, "--frame", 4)
    restir("demo", "moving-camera", *SMALL, "--out", tmp_path, *quick)
    frames = {
        name: read_exr(tmp_path / f"{name}.exr").metadata["frame"]
        for name in ("truth", *BUILT_IN)
    }
    assert frames == {"truth": "6", "path": "6", **dict.fromkeys(RESTIR, "4")}
    last = tmp_path / "last.exr"
    seed = read_exr(tmp_path / "truth.exr").metadata["seed"]
    restir("reference", "moving-camera", *SMALL, "--frame", 6, "--spp", 4,
           "--seed", seed, "--out", last)  # fmt: skip
    truth = read_exr(tmp_path / "truth.exr").color
    np.testing.assert_array_equal(truth, read_exr(last).color)


def test_what_is_written_for_programs_is_json():
    """Numbers that are not finite are null, wherever they stand."""
    given = {"a": [np.inf, {"b": np.float32(0.5)}], "c": np.array([1.0, np.nan])}
    assert json.loads(json_text(given)) == {"a": [None, {"b": 0.5}], "c": [1.0, None]}
    with pytest.raises(TypeError, match="no form for object"):
        json_text({"a": object()})
