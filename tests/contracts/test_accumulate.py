"""Truth that survives Ctrl-C and kill: no sample is lost, none is counted twice."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods.metadata import header
from restir_gi.reference.numerics.moments import Moments, add_samples, no_samples
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.fingerprint import fingerprint
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.accumulate import accumulate, path_samples
from restir_gi.reference.transport.world import build_world
from restir_gi.reference.truth.checkpoint import (
    Checkpoint,
    load_checkpoint,
    save_checkpoint,
)

ROOT = Path(__file__).parents[2]
RUN = {"scene": "room", "seed": "0"}


def assert_equal(a, b):
    """Bit for bit."""
    assert a.count == b.count
    np.testing.assert_array_equal(a.mean, b.mean)
    np.testing.assert_array_equal(a.squares, b.squares)


# ---------------------------------------------------------------- moments

VALUES = np.random.default_rng(0).lognormal(0, 2, (40, 5, 3))


def value(rows, number):
    """Sample ``number`` of some rows, from a table."""
    return VALUES[number, rows]


@given(st.lists(st.integers(0, 40)), st.integers(1, 6), st.integers(1, 3))
def test_moments_do_not_know_how_they_were_cut(cuts, band, threads):
    whole = add_samples(no_samples(5), value, 40, Schedule())
    moments = no_samples(5)
    for stop in (*sorted(cuts), 40):
        moments = add_samples(moments, value, stop, Schedule(band, threads))
    assert_equal(moments, whole)


def test_moments_are_mean_and_standard_error():
    """Each of 40 steps rounds by a few eps; 40 · 8 · eps."""
    moments = add_samples(no_samples(5), value, 40, Schedule())
    rounding = {"rtol": 320 * 2.0**-52}
    np.testing.assert_allclose(moments.mean, VALUES.mean(axis=0), **rounding)
    error = VALUES.std(axis=0, ddof=1) / np.sqrt(40)
    np.testing.assert_allclose(moments.standard_error(), error, **rounding)


def test_moments_of_a_constant_have_no_error():
    moments = add_samples(no_samples(5), lambda r, n: VALUES[0, r], 9, Schedule())
    np.testing.assert_array_equal(moments.mean, VALUES[0])
    assert not moments.standard_error().any()


def test_one_sample_has_no_standard_error():
    with pytest.raises(ValueError, match="two samples"):
        add_samples(no_samples(5), value, 1, Schedule()).standard_error()


def test_each_sample_is_asked_for_once():
    asked = Counter()

    def sample(rows, number):
        asked.update((row, number) for row in range(rows.start, rows.stop))
        return value(rows, number)

    moments = no_samples(5)
    for stop in (1, 3, 3, 17, 40):
        moments = add_samples(moments, sample, stop, Schedule(band=2))
    assert asked == Counter((row, number) for row in range(5) for number in range(40))


def test_batches_end_with_the_last_sample():
    scene = find_scene("cornell-box")
    scene = replace(scene, camera=replace(scene.camera, width=6, height=5))
    world, schedule = build_world(scene), Schedule()
    samples = path_samples(world, schedule, light="indirect", bounces=1, seed=0)
    states = list(accumulate(samples, no_samples(30), 20, schedule))
    counts = [state.count for state in states]
    assert counts == sorted(set(counts))
    assert counts[-1] == 20
    middle = states[len(states) // 2]
    again = list(accumulate(samples, middle, 20, schedule))
    assert_equal((again or [middle])[-1], states[-1])


# ---------------------------------------------------------------- checkpoints


@pytest.fixture
def state():
    moments = add_samples(no_samples(5), value, 7, Schedule())
    return Checkpoint(moments, 1.5, {"bounce": 3})


def test_a_checkpoint_comes_back(tmp_path, state):
    save_checkpoint(tmp_path / "c", RUN, state)
    loaded = load_checkpoint(tmp_path / "c", RUN)
    assert_equal(loaded.moments, state.moments)
    assert (loaded.seconds, loaded.rays) == (state.seconds, state.rays)


def test_no_checkpoint_is_none(tmp_path):
    assert load_checkpoint(tmp_path / "c", RUN) is None


@pytest.mark.parametrize(
    ("run", "difference"),
    [
        ({"scene": "hall", "seed": "0"}, "scene room, not hall"),
        ({"scene": "room", "seed": "1"}, "seed 0, not 1"),
        ({"scene": "room"}, "seed 0, not None"),
        (RUN | {"pixel": "box"}, "pixel None, not box"),
    ],
)
def test_a_foreign_checkpoint_is_refused(tmp_path, state, run, difference):
    save_checkpoint(tmp_path / "c", RUN, state)
    with pytest.raises(UsageError, match=f"another run .{difference}"):
        load_checkpoint(tmp_path / "c", run)


def cut_off(contents):
    return contents[: len(contents) // 2]


def flipped(contents):
    middle = contents.index(b"mean.npy") + 200
    return contents[:middle] + bytes([contents[middle] ^ 1]) + contents[middle + 1 :]


@pytest.mark.parametrize(
    "damage", [cut_off, flipped, lambda c: b"", lambda c: b"text", lambda c: c[:-1]]
)
def test_a_damaged_checkpoint_is_refused(tmp_path, state, damage):
    path = tmp_path / "c"
    save_checkpoint(path, RUN, state)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(UsageError, match="is not a checkpoint, or is damaged"):
        load_checkpoint(path, RUN)


@pytest.mark.parametrize(
    "moments",
    [
        Moments(0, np.zeros((5, 3)), np.zeros((5, 3))),
        Moments(3, np.full((5, 3), np.nan), np.zeros((5, 3))),
        Moments(3, np.zeros((5, 3)), np.zeros((4, 3))),
        Moments(3, np.zeros(5), np.zeros(5)),
        Moments(3, np.zeros((5, 3), np.float32), np.zeros((5, 3))),
    ],
)
def test_a_checkpoint_of_nonsense_is_refused(tmp_path, state, moments):
    save_checkpoint(tmp_path / "c", RUN, replace(state, moments=moments))
    with pytest.raises(UsageError, match="damaged"):
        load_checkpoint(tmp_path / "c", RUN)


# ---------------------------------------------------------------- scenes apart


def test_fingerprints_tell_scenes_apart():
    scene = find_scene("cornell-box")
    mesh = scene.meshes[0]
    vertices = mesh.vertices.copy()
    vertices[0, 0] = np.nextafter(vertices[0, 0], 9.0)
    others = [
        replace(scene, name="another"),
        replace(scene, camera=replace(scene.camera, fov=38.1)),
        replace(scene, meshes=scene.meshes[1:]),
        replace(scene, meshes=(replace(mesh, vertices=vertices), *scene.meshes[1:])),
        replace(scene, meshes=(replace(mesh, emission=(0.0, 0.0, 1.0)),)),
    ]
    digests = {fingerprint(other) for other in (scene, *others)}
    assert len(digests) == 1 + len(others)
    assert fingerprint(find_scene("cornell-box")) == fingerprint(scene)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (1, 1.0), (1, True), (0.0, -0.0), (None, "None"), (("a", "b"), ("ab",)),
        ((1, (2,)), ((1, 2),)), ("1", 1),
        (np.zeros(2), np.zeros((2, 1))), (np.zeros(2), np.zeros(2, np.float32)),
    ],
)  # fmt: skip
def test_fingerprints_tell_values_apart(a, b):
    assert fingerprint(a) != fingerprint(b)
    assert fingerprint(a) == fingerprint(a)


def test_a_fingerprint_of_anything_else_is_refused():
    with pytest.raises(TypeError, match="no fingerprint of function"):
        fingerprint(lambda: 0)


# ---------------------------------------------------------------- the command


def command(out, spp, *more):
    """Arguments of a small truth."""
    return [
        "reference", "door-ajar", "--size", "16x12", "--spp", str(spp),
        "--out", str(out), "--threads", "2", "--band", "50", *map(str, more),
    ]  # fmt: skip


@pytest.fixture
def start():
    """Run it in a process of its own, which does not outlive the test."""
    with ExitStack() as ends:

        def start(out, spp, *more):
            process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "restir_gi.reference",
                    *command(out, spp, *more),
                ],
                cwd=ROOT,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            ends.enter_context(process)
            ends.callback(process.kill)
            return process

        yield start


def count_in(checkpoint):
    """Samples in a checkpoint file; 0 without one."""
    try:
        with np.load(checkpoint) as file:
            return json.loads(str(file["words"]))["count"]
    except FileNotFoundError:
        return 0


def wait_for(condition):
    """Wait until something is the case, for half a minute at most."""
    for _ in range(3000):
        if condition():
            return
        time.sleep(0.01)
    pytest.fail("nothing happened for half a minute")


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    """Layers of 600 samples that nobody disturbed."""
    out = tmp_path_factory.mktemp("whole") / "truth.exr"
    assert main(command(out, 600, "--band", 192)) == 0
    assert [path.name for path in out.parent.iterdir()] == ["truth.exr"]
    return read_exr(out)


def assert_same_pixels(out, image):
    """Bit for bit, in all layers."""
    other = read_exr(out)
    assert other.layers.keys() == image.layers.keys() == {"color", "standard_error"}
    for name, layer in image.layers.items():
        np.testing.assert_array_equal(other.layers[name], layer)


ENDS = {"SIGKILL": -9, "SIGINT": 130, "SIGTERM": 143}


@pytest.mark.skipif(sys.platform == "win32", reason="other signals there")
@pytest.mark.parametrize("name", ENDS)
def test_a_run_goes_on_after_its_end(tmp_path, start, name):
    """Cut off for good in the middle; the second run, of other bands, ends it."""
    out = tmp_path / "truth.exr"
    checkpoint = tmp_path / "truth.exr.checkpoint"
    # Far more samples than there is time for; that number does not bind the next run.
    process = start(out, 10**8, "--checkpoint", 0)
    wait_for(lambda: process.poll() is not None or count_in(checkpoint) > 20)
    assert process.poll() is None, process.communicate()
    process.send_signal(getattr(signal, name))
    _, err = process.communicate(timeout=60)
    assert process.returncode == ENDS[name]
    assert not out.exists()
    left = [path.name for path in tmp_path.iterdir() if path.suffix != ".part"]
    assert left == [checkpoint.name]
    kept = count_in(checkpoint)
    if name == "SIGKILL":
        assert err == ""
    else:
        assert len(err.splitlines()) == 1
        assert f"{kept} of 100000000 samples are kept in {checkpoint}" in err

    # However far the first run came, the second has something left to do.
    whole = tmp_path / "whole.exr"
    assert main(command(whole, kept + 50, "--band", 192)) == 0
    assert main(command(out, kept + 50, "--threads", 1)) == 0
    assert_same_pixels(out, read_exr(whole))
    assert not checkpoint.exists()
    assert float(read_exr(out).metadata["seconds"]) > 0


@pytest.mark.skipif(os.name != "posix", reason="other signals there")
def rays_of(image):
    """Rays by kind, as the header has them."""
    return {k: n for k, n in image.metadata.items() if k.startswith("rays.")}


def test_a_run_survives_many_kills(tmp_path, uninterrupted, start):
    """Killed at any moment, also while it writes."""
    out = tmp_path / "truth.exr"
    checkpoint = tmp_path / "truth.exr.checkpoint"
    seen = 0
    for _ in range(4):
        process = start(out, 600, "--checkpoint", 0)
        before = seen

        def is_further(before=before, process=process):
            return process.poll() is not None or count_in(checkpoint) > before

        wait_for(is_further)
        process.kill()
        process.communicate()
        if out.exists():
            break
        seen = count_in(checkpoint)
        assert seen >= before
    assert main(command(out, 600)) == 0
    assert_same_pixels(out, uninterrupted)
    assert rays_of(read_exr(out)) == rays_of(uninterrupted)


def test_a_kept_checkpoint_goes_on_to_more_samples(tmp_path, uninterrupted, capsys):
    out = tmp_path / "truth.exr"
    checkpoint = tmp_path / "truth.exr.checkpoint"
    assert main(command(out, 150, "--keep")) == 0
    assert count_in(checkpoint) == 150
    first = read_exr(out)
    # The same again traces nothing, and writes the same.
    assert main(command(out, 150, "--keep")) == 0
    assert_same_pixels(out, first)
    # Fewer cannot be had.
    capsys.readouterr()
    assert main(command(out, 100)) == 2
    assert "has 150 samples already, more than --spp 100" in capsys.readouterr().err
    assert main(command(out, 600)) == 0
    assert_same_pixels(out, uninterrupted)
    # Each ray once: also those that are traced afresh whenever the scene is opened.
    assert rays_of(read_exr(out)) == rays_of(uninterrupted)
    assert not checkpoint.exists()


@pytest.mark.parametrize(
    ("change", "difference"),
    [
        (("--seed", 1), "seed"),
        (("--bounces", 2), "bounces"),
        (("--light", "full"), "light"),
        (("--size", "12x16"), "size"),
        (("--set", "pixel=box"), "pixel"),
    ],
)
def test_the_checkpoint_of_another_run_stays_as_it_is(
    tmp_path, capsys, change, difference
):
    out = tmp_path / "truth.exr"
    checkpoint = tmp_path / "truth.exr.checkpoint"
    assert main(command(out, 2, "--keep")) == 0
    before = checkpoint.read_bytes(), out.read_bytes()
    capsys.readouterr()
    assert main(command(out, 3, *change)) == 2
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1
    assert f"is the checkpoint of another run ({difference} " in err
    assert (checkpoint.read_bytes(), out.read_bytes()) == before


def test_the_truth_for_a_program(tmp_path, capsys):
    out = tmp_path / "truth.exr"
    assert main(command(out, 4, "--json", "--png")) == 0
    stdout, stderr = capsys.readouterr()
    results = json.loads(stdout)
    assert stderr == ""
    assert results["layers"] == ["color", "standard_error"]
    assert results["metadata"]["spp"] == 4
    assert results["metadata"]["method"] == "path"
    assert Path(results["png"]).exists()
    assert header(results["metadata"]) == dict(read_exr(out).metadata)
