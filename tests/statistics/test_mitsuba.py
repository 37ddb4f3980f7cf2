"""ReSTIR GI against Mitsuba's own renders of the same scene files.

Evidence: statistics, and an independent renderer.  One-bounce indirect light is
Mitsuba's picture of at most three segments less that of at most two.  Mitsuba spreads
its samples over each pixel, so every run of ours has its visible points at random
places of theirs.
The image mean must agree within 0.5 %, and no 8 x 8 tile may leave its band.  A correct
estimator fails the tiles of one scene with probability 1e-4, and the image mean with
probability 2 Φ(-0.5 % / error), which is printed.  The control brightens the truth by
2 %, which the image mean must notice.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from reference.accumulate import path_samples
from reference.scene.loaders.load import load_scene
from reference.schedule import Schedule
from reference.settings import UNBIASED
from reference.world import World
from tests.statistics.replicates import (
    Means,
    g_buffer,
    initially_sampled,
    means,
    runs_at_once,
    small_world,
    threshold,
)

mitsuba = pytest.importorskip("mitsuba", reason="Mitsuba renders the truth")

FAMILY = 1e-4
LIMIT = 0.005
BATCHES = 32
AT_ONCE = 8


def rendered(path: Path, width: int, height: int, samples: int) -> Means:
    """One-bounce indirect light by Mitsuba, in independent batches."""
    mitsuba.set_variant("scalar_rgb")
    scene = mitsuba.load_file(str(path))
    sensor = scene.sensors()[0]
    film = mitsuba.traverse(sensor)
    film["film.size"] = [width, height]
    film["film.crop_size"] = [width, height]
    film.update()
    rows = []
    for batch in range(BATCHES):
        pictures = []
        for depth in (3, 2):
            options = {"type": "path", "max_depth": depth, "rr_depth": 1000}
            integrator = mitsuba.load_dict(options)
            seed = 2 * batch + depth
            picture = mitsuba.render(
                scene, sensor=sensor, integrator=integrator, seed=seed, spp=samples
            )
            pictures.append(np.array(picture, np.float64)[..., :3].reshape(-1, 3))
        rows.append(pictures[0] - pictures[1])
    return means(rows, width)


def judge(reuse: Means, initial: Means, theirs: Means) -> tuple[float, float, float]:
    """Relative bias of the image mean, its error, and the largest |t| of the tiles."""
    difference = initial.mean + reuse.mean - theirs.mean
    error = np.sqrt(initial.error**2 + reuse.error**2 + theirs.error**2).clip(1e-300)
    t = np.abs(difference / error)[1:].max()
    scale = theirs.mean[0]
    return float(difference[0] / scale), float(error[0] / scale), float(t)


def check(
    path: Path, width: int, height: int, runs: int, initial: int, samples: int
) -> None:
    world = small_world(load_scene(path), width, height)
    rng = np.random.default_rng(7)
    # What initial samples find, and what reuse changes of it.
    alone = initially_sampled(world, UNBIASED, initial, jitter=rng)
    pairs = []
    for first in range(0, runs, AT_ONCE):
        visible = [g_buffer(world, rng) for _ in range(min(AT_ONCE, runs - first))]
        pairs += runs_at_once(world, UNBIASED, 4, first, visible)
    reuse = means([a - b for a, b in pairs], width)
    theirs = rendered(path, width, height, samples)
    bias, error, t = judge(reuse, alone, theirs)
    false_alarm = 2 * stats.norm.sf(LIMIT / error)
    print(
        f"{path.parent.name}: bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f};"
        f" (errors of reuse {reuse.error[0] / theirs.mean[0]:.3%}, initial"
        f" {alone.error[0] / theirs.mean[0]:.3%}, Mitsuba"
        f" {theirs.error[0] / theirs.mean[0]:.3%}); a correct estimator's mean would"
        f" fail with probability {false_alarm:.0e}"
    )
    # Welch's degrees of freedom are at least those of the smallest group.
    assert t <= threshold(len(alone.mean) - 1, FAMILY, BATCHES)
    assert abs(bias) <= LIMIT
    planted, _, _ = judge(reuse, alone, Means(theirs.values * 1.02))
    assert abs(planted) > LIMIT


@pytest.mark.slow
def test_all_materials_in_one_room():
    path = Path(__file__).with_name("studio.xml")
    check(path, 64, 48, runs=850, initial=5200, samples=210)


@pytest.mark.slow
def test_a_real_room_behind_a_door(scenes_folder):
    path = scenes_folder / "veach-ajar" / "simple" / "scene.xml"
    check(path, 64, 40, runs=2400, initial=26000, samples=480)


def pictures_of(world: World, samples: int) -> Means:
    """All light of one bounce, in batches, from all over each pixel."""
    rows = []
    for batch in range(BATCHES):
        paths = path_samples(
            world, Schedule(), light="full", bounces=1, seed=batch, pixel="box"
        )
        whole = slice(0, paths.rows)
        rows.append(sum(paths.radiance(whole, n) for n in range(samples)) / samples)
    return means(rows, world.camera.width)


@pytest.mark.slow
def test_another_size_shows_what_mitsuba_shows_of_the_file_at_that_size(tmp_path):
    """Its angle spans the smaller side, and the file's image is a square.

    Tiles at a family rate of 1e-4.  The control keeps the angle of the width.
    """
    text = Path(__file__).with_name("studio.xml").read_text()
    text = text.replace(
        '<float name="fov" value="50"/>',
        '<float name="fov" value="40"/><string name="fov_axis" value="smaller"/>',
    )
    here, there = tmp_path / "square.xml", tmp_path / "oblong.xml"
    here.write_text(
        text.replace('name="height" value="48"', 'name="height" value="64"')
    )
    there.write_text(text)
    mitsuba.set_variant("scalar_rgb")
    options = {"type": "path", "max_depth": 3, "rr_depth": 1000}
    integrator, scene = mitsuba.load_dict(options), mitsuba.load_file(str(there))
    theirs = means(
        [
            np.array(
                mitsuba.render(scene, integrator=integrator, seed=batch, spp=8),
                np.float64,
            )[..., :3].reshape(-1, 3)
            for batch in range(BATCHES)
        ],
        64,
    )
    square = load_scene(here)
    ours = pictures_of(small_world(square, 64, 48), 8)
    none = Means(np.zeros_like(ours.values))
    bias, error, t = judge(none, ours, theirs)
    print(f"bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f}")
    most = threshold(len(ours.mean) - 1, FAMILY, BATCHES)
    assert t <= most
    wide = replace(square, camera=replace(square.camera, fov_axis="x"))
    _, _, planted = judge(none, pictures_of(small_world(wide, 64, 48), 2), theirs)
    assert planted > most
