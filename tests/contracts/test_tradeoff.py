"""``restir tradeoff``: runs that are kept, what is written, and other machines."""

import csv
import json
import re
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.cli import tradeoff as command
from restir_gi.reference.cli.main import main
from restir_gi.reference.methods import Job, method_named, method_names
from restir_gi.reference.methods.method import drive
from restir_gi.reference.numerics import intervals
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.numerics.records import fields_but, nbytes
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.tradeoff import knobs
from restir_gi.reference.reports.tradeoff.change import recoveries
from restir_gi.reference.reports.tradeoff.points import Design
from restir_gi.reference.reports.tradeoff.store import open_store
from restir_gi.reference.reports.tradeoff.sweep import Sweep, run_sweep
from restir_gi.reference.reports.tradeoff.trials import BEFORE, Task, opened, run_trial
from restir_gi.reference.scene.animation import still
from restir_gi.reference.scene.brightness import brightened
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.lights import LatLongEnvironment
from restir_gi.reference.scene.named import Named
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.transport.world import build_world

SMALL = Named("cornell-box", False, 16, 16)
BASE = Design("restir-gi-unbiased", ())


class Here:
    """An executor that does the work at once."""

    def __init__(self):
        self.done = []

    def submit(self, function, task):
        """Do it."""
        future = Future()
        self.done.append(task)
        future.set_result(function(task))
        return future


def sweep_of(*values, runs=3, changed=()):
    points = tuple(Design(BASE.method, v) for v in ((), *values))
    return Sweep(SMALL, 1, 4, runs, 0, points, changed)


def no_tick(done, total, unit):
    """Tell nobody."""


# ------------------------------------------------------------ one run


def job(method, **counts):
    world, animation = opened(SMALL)
    return Job(
        world=world,
        light="indirect",
        bounces=1,
        seed=3,
        counts={"frames": 3, "spp": 3, **counts},
        settings=method.settings,
        aovs=(),
        schedule=Schedule(),
        animation=None if animation.changes == "nothing" else animation,
    )


@pytest.mark.parametrize("name", [n for n in method_names() if n != "path"])
def test_frames_are_those_that_are_rendered(name):
    """The last frame is the picture, to the last bit."""
    method = method_named(name)
    asked = replace(job(method), settings=replace(method.settings, image="last"))
    picture = drive(method, asked, lambda progress: None)["color"]
    frames = method.frames(asked)
    for _ in range(3):
        shown = next(frames)
    assert np.array_equal(shown.color, picture)
    assert shown.kept > 0


def test_frames_of_path_tracing_are_its_samples():
    method = method_named("path")
    picture = drive(method, job(method), lambda progress: None)["color"]
    frames = method.frames(job(method))
    mean = np.mean([next(frames).color for _ in range(3)], axis=0)
    # Three additions and a division, in another order.
    np.testing.assert_allclose(mean, picture, rtol=8 * 2.0**-52)


def test_a_run_measures_its_second_half():
    seed = Task(SMALL, 1, 5, BASE, seed=2)
    run = run_trial(seed)
    assert seed.counted == 3
    frames = method_named(BASE.method).frames(job_like(seed))
    colors = [next(frames).color for _ in range(5)]
    assert np.array_equal(run.color, colors[-1].astype(np.float32))
    np.testing.assert_allclose(run.mean, np.mean(colors[2:], axis=0), rtol=1e-6)
    assert run.tiles.shape == (5, 4, 3)
    assert 0.5 < run.rays["bounce"] <= 1.0  # one a pixel that sees the box
    assert "primary" not in run.rays  # the camera stands still
    assert run.seconds > 0


def job_like(task):
    """The job of a task, by hand."""
    method = method_named(task.point.method)
    world, _ = opened(task.named)
    return Job(
        world=world,
        light="indirect",
        bounces=1,
        seed=task.seed,
        counts={},
        settings=method.settings,
        aovs=(),
        schedule=Schedule(),
    )


def test_lights_change_at_once():
    """A path tracer forgets at once: before, four times the light; after, the scene's.

    Powers of two scale each sample by itself.
    """
    path = Design("path", ())
    changed = run_trial(Task(SMALL, 1, 4, path, seed=1, change=2))
    left_alone = run_trial(Task(SMALL, 1, 4, path, seed=1))
    assert np.array_equal(changed.tiles[2:], left_alone.tiles[2:])
    assert np.array_equal(changed.tiles[:2], BEFORE * left_alone.tiles[:2])
    assert np.array_equal(changed.color, left_alone.color)


SKY = LatLongEnvironment(np.random.default_rng(0).random((4, 8, 3)))

LIT = {
    "a lamp": "cornell-box",
    "the sun": "sunlit-wall",
    "a sphere": "sphere-furnace",
    "a point": "half-lit-sphere",
    "an even sky": "checker",
    "a map of the sky": "checker",
}


@pytest.mark.parametrize("light", LIT)
def test_brighter_scenes_are_brighter_to_the_last_bit(light):
    scene = find_scene(LIT[light])
    scene = replace(scene, camera=replace(scene.camera, width=8, height=8))
    if light == "a map of the sky":
        scene = replace(scene, environment=SKY)
    pictures = []
    for made in (scene, brightened(scene, 0.25)):
        world = build_world(validate(made))
        about = {"light": "full", "bounces": 1, "seed": 0}
        samples = path_samples(world, Schedule(), **about)
        pictures.append(samples.radiance(slice(0, 64), 0))
    assert pictures[0].any()
    assert np.array_equal(0.25 * pictures[0], pictures[1])


def test_bytes_of_arrays_count_once():
    a = np.zeros(10)
    assert nbytes([a, {"x": a}, None, 3, (np.zeros(2, np.int32),)]) == 88
    point = Design("path", ("a=1",))
    assert fields_but(point, "values", "label") == ["path", ""]


# ------------------------------------------------------------ runs that are kept


def test_runs_take_turns_and_none_comes_twice():
    sweep = sweep_of(("mis=1/M",), ("mis=1/Z",), changed=(BASE,))
    tasks = sweep.tasks()
    assert len(set(tasks)) == len(tasks) == 3 * 2 + 3
    assert [t.seed for t in tasks] == sorted(t.seed for t in tasks)
    assert {t.frames for t in tasks if t.change} == {8}


def test_a_sweep_goes_on_where_it_was_cut(tmp_path):
    sweep = sweep_of(("mis=1/M",), changed=(BASE,))
    store = open_store(tmp_path / "whole", {"a": "1"})
    run_sweep(sweep, store, Here(), no_tick)
    cut = open_store(tmp_path / "cut", {"a": "1"})
    for task in sweep.tasks()[:4]:
        cut.put(task, run_trial(task))
    again, told = Here(), []
    cut = open_store(cut.folder, {"a": "1"})
    run_sweep(sweep, cut, again, lambda *t: told.append(t))
    assert again.done == sweep.tasks()[4:]
    assert told[0] == (4, 9, "runs")
    assert told[-1] == (9, 9, "runs")
    for task in sweep.tasks():
        for name in ("color", "mean", "tiles", "rays", "kept"):
            a, b = (getattr(s.get(task), name) for s in (store, cut))
            assert np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b
    assert len(recoveries(sweep, store, {"center": truth_like(sweep)})) == 1


def truth_like(sweep):
    flat = np.ones((sweep.named.width * sweep.named.height, 3))
    return Moments(4, flat, 0 * flat)


def test_runs_of_another_scene_are_refused(tmp_path):
    open_store(tmp_path, {"scene": "a", "size": "8x8"})
    with pytest.raises(UsageError, match="holds other runs \\(size 8x8, not 9x9\\)"):
        open_store(tmp_path, {"scene": "a", "size": "9x9"})
    (tmp_path / "identity.json").write_text("{")
    with pytest.raises(UsageError, match="is damaged"):
        open_store(tmp_path, {"scene": "a"})


@pytest.mark.parametrize("damage", ["", "PK", "half"])
def test_a_damaged_run_is_told(tmp_path, damage):
    store, task = open_store(tmp_path, {}), Task(SMALL, 1, 2, BASE, 0)
    store.put(task, run_trial(task))
    path = store.path(task)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage == "half" else damage.encode())
    with pytest.raises(
        UsageError, match=r"0\.npz is not a run, or is damaged; delete it"
    ):
        store.get(task)


# ------------------------------------------------------------ the command


@pytest.fixture
def here(monkeypatch):
    """Do the work of the command in this process."""

    @contextmanager
    def at_once(processes, scheduler):
        yield Here()

    monkeypatch.setattr(command, "workers", at_once)


QUICK = ("--size", "16x16", "--runs", "3", "--frames", "2", "--spp", "4")


def restir(capsys, *words):
    code = main(["tradeoff", *(str(w) for w in words)])
    return code, *capsys.readouterr()


def test_what_is_written(here, capsys, tmp_path, monkeypatch):
    """Of four of the knobs: the others are no different."""
    few = [k for k in knobs.KNOBS if k.name in ("mode", "radius", "storage")]
    monkeypatch.setattr(knobs, "KNOBS", tuple(few))
    monkeypatch.setattr(intervals, "DRAWS", 20)
    words = ("cornell-box", "--out", tmp_path, *QUICK, "--design", "2", "--json")
    code, printed, told = restir(capsys, *words)
    assert (code, told) == (0, "")
    numbers = json.loads(printed)
    assert numbers == json.loads((tmp_path / "numbers.json").read_text())
    points = numbers["points"]
    assert (points[0]["knob"], points[0]["label"]) == ("", "as it is")
    turned = {p["knob"] for p in points}
    assert turned == {"", "mode", "radius", "storage", "method", "several"}
    assert len([p for p in points if p["knob"] == "several"]) == 2
    for p in points:
        assert p["MSE"][0] == pytest.approx(p["bias2"][0] + p["variance"][0])
        assert p["ms"][0] > 0
    assert len(numbers["after a change of light"]) == 7
    with (tmp_path / "numbers.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(points)
    assert float(lines[1]["MSE"]) == points[1]["MSE"][0]
    page = (tmp_path / "index.html").read_text()
    assert numbers["advice"].split(" take ")[0] in page
    assert not re.search(r'(src|href)="(https?:)?//', page)
    names = ("curves", "bars", "front", "maps", "near", "change")
    for name in names:
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert page.count("data:image/png;base64,") == len(names)


def test_one_knob_of_ones_own(here, capsys, tmp_path):
    words = ("cornell-box", "--out", tmp_path, *QUICK, "--design", "0")
    code, printed, _ = restir(capsys, *words, "--sweep", "radius=0.05,0.3")
    assert code == 0
    assert "Speed against accuracy: cornell-box" in printed
    assert "take restir-gi-unbiased" in printed
    numbers = json.loads((tmp_path / "numbers.json").read_text())
    assert [p["label"] for p in numbers["points"]] == ["as it is", "0.05", "0.3"]
    assert not numbers["after a change of light"]


def test_a_moving_scene_is_seen_in_its_last_frame(here, capsys, tmp_path):
    words = ("moving-block", "--out", tmp_path, *QUICK, "--design", "0", "--method")
    code, _, told = restir(capsys, *words, "path", "--sweep", "pixel=center,box")
    assert (code, told) == (0, "")
    assert {p.name for p in tmp_path.glob("truth-*")} == {
        "truth-center.checkpoint",
        "truth-box.checkpoint",
    }


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--method", "nobody"), "unknown method 'nobody'"),
        (("--sweep", "radius"), "not of the form KEY=VALUE,VALUE"),
        (("--sweep", "colour=1,2"), "unknown setting 'colour'"),
        (("--set", "mis=9"), "mis must be"),
        (("--runs", "2"), "--runs"),
        (("--scheduler", "tcp://127.0.0.1:1"), "no Dask scheduler answers"),
    ],
)
def test_bad_input_is_one_line(capsys, tmp_path, monkeypatch, words, said):
    monkeypatch.setattr("restir_gi.reference.system.workers.CONNECT", "1s")
    code, printed, told = restir(
        capsys, "cornell-box", "--out", tmp_path, *QUICK, "--design", "0", *words
    )
    assert (code, printed) == (2, "")
    assert said in told
    assert told.count("\n") == 1


def test_scenes_of_animations_are_opened_at_their_frame():
    _, animation = opened(Named("light-switch", False, 8, 8, frame=40))
    assert animation.changes == "scene"
    assert still(animation(0))(0) is animation(0)
