"""ReSTIR GI against Mitsuba's own renders of the same scene files.

Evidence: statistics, and an independent renderer.  One-bounce indirect light is
Mitsuba's picture of at most three segments less that of at most two.  Mitsuba spreads
its samples over each pixel, so every run of ours has its visible points at random
places of theirs.
The image mean must agree within 0.5 %, and no 8 x 8 tile may leave its band.  A correct
estimator fails the tiles of one scene with probability 1e-4, and the image mean with
probability 2 Φ(-0.5 % / error), which is printed.  The control brightens the truth by
2 %, which the image mean must notice.

All light of a textured lamp and a spot, path traced, is held against Mitsuba in the
same way, to 1.5 %: Mitsuba draws points all over the lamp, and its pictures are noisy.
There the truth is brightened by 4 %, and a lamp in the mean colour of its texture is a
control, too.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.textures import mean_color
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.transport.path_tracer import camera_radiance, first_hits
from restir_gi.reference.transport.world import World
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


def rendered(
    path: Path, width: int, height: int, samples: int, depths: tuple[int, ...] = (3, 2)
) -> Means:
    """One-bounce indirect light by Mitsuba, in independent batches.

    The first picture less the others: paths of so many segments at most.
    """
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
        for depth in depths:
            options = {"type": "path", "max_depth": depth, "rr_depth": 1000}
            integrator = mitsuba.load_dict(options)
            seed = 2 * batch + depth
            picture = mitsuba.render(
                scene, sensor=sensor, integrator=integrator, seed=seed, spp=samples
            )
            pictures.append(np.array(picture, np.float64)[..., :3].reshape(-1, 3))
        rows.append(pictures[0] - sum(pictures[1:]))
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


LAMPS = """<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="45"/>
 <transform name="to_world"><lookat origin="1.4,1.2,3" target="0,0.4,0" up="0,1,0"/>
 </transform><film type="hdrfilm"><rfilter type="box"/></film></sensor>
<bsdf type="twosided" id="wall"><bsdf type="diffuse">
 <rgb name="reflectance" value="0.7,0.6,0.5"/></bsdf></bsdf>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/>
 <scale value="3"/></transform><ref id="wall"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/>
 <translate z="-1.5"/></transform><ref id="wall"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.3"/>
 <translate x="-0.5" y="0.3"/></transform><ref id="wall"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.6"/>
 <rotate x="1" angle="110"/><translate x="0.2" y="1.3" z="-0.4"/></transform>
 <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
 <emitter type="area"><texture name="radiance" type="bitmap">
  <string name="filename" value="lamp.exr"/><boolean name="raw" value="true"/>
  <string name="filter_type" value="FILTER"/></texture></emitter></shape>
<emitter type="spot"><rgb name="intensity" value="3,4,5"/>
 <float name="cutoff_angle" value="25"/><float name="beam_width" value="15"/>
 <transform name="to_world"><lookat origin="-1,1.8,1.5" target="0.4,0,0.4" up="0,0,1"/>
 </transform></emitter>
</scene>"""


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
@pytest.mark.parametrize("kind", ["nearest", "bilinear"])
def test_a_textured_lamp_and_a_spot(tmp_path: Path, kind: str) -> None:
    """Of the lamp a quarter shines, away from us; the spot's edge is on the floor."""
    path, size, limit = tmp_path / "lamps.xml", (32, 24), 0.015
    path.write_text(LAMPS.replace("FILTER", kind))
    pixels = np.zeros((8, 8, 3), np.float32)
    pixels[1, 2:], pixels[5:, 5], pixels[6, :4] = (9, 6, 3), (2, 8, 2), (4, 4, 9)
    write_exr(tmp_path / "lamp.exr", Image({"color": pixels}))
    scene = load_scene(path)
    ours = pictures_of(small_world(scene, *size), 24)
    theirs = rendered(path, *size, samples=24, depths=(3,))
    nothing = Means(np.zeros_like(ours.values))
    bias, error, t = judge(ours, nothing, theirs)
    print(f"{kind}: bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f}")
    bound = threshold(len(ours.mean) - 1, FAMILY, BATCHES)
    assert 2 * stats.norm.sf(limit / error) < 1e-4
    assert t <= bound
    assert abs(bias) <= limit
    planted, _, _ = judge(ours, nothing, Means(theirs.values * 1.04))
    assert abs(planted) > limit
    even = tuple(
        replace(mesh, emission=tuple(mean_color(mesh.emission)))
        for mesh in scene.meshes
    )
    plain = pictures_of(small_world(replace(scene, meshes=even), *size), 4)
    assert judge(plain, nothing, theirs)[2] > bound


@pytest.mark.slow
def test_rough_glass_and_beckmann_in_one_room():
    """All light of paths of up to four bounces, by the plain path tracer.

    Without reuse there is nothing else to bring a bias.  Lights are reached through
    glass by light sampling and as emitter hits; metal, lacquer and a ball of glass are
    Beckmann's.
    """
    path = Path(__file__).with_name("frosted.xml")
    width, height, copies, rounds = 32, 24, 16, 40
    world = small_world(load_scene(path), width, height)
    rng = np.random.default_rng(11)
    column, row = (g.ravel() for g in np.meshgrid(range(width), range(height)))
    pixels = width * height * copies
    rows = []
    for sample in range(rounds):
        x = np.tile(column, copies) + rng.random(pixels)
        y = np.tile(row, copies) + rng.random(pixels)
        seen = first_hits(world, x, y)
        key = np.arange(pixels, dtype=np.uint32)
        u = KeyedUniforms(key, sample, 0, Stream.PATH)
        light = camera_radiance(world, seen, "full", 4, u)
        rows.append(light.reshape(copies, -1, 3).mean(axis=0))
    ours = means(rows, width)
    mitsuba.set_variant("scalar_rgb")
    scene = mitsuba.load_file(str(path))
    options = {"type": "path", "max_depth": 6, "rr_depth": 1000}
    integrator = mitsuba.load_dict(options)
    pictures = [
        mitsuba.render(scene, integrator=integrator, seed=batch, spp=48)
        for batch in range(BATCHES)
    ]
    theirs = means(
        [np.array(p, np.float64)[..., :3].reshape(-1, 3) for p in pictures], width
    )
    nothing = Means(np.zeros_like(ours.values))
    bias, error, t = judge(nothing, ours, theirs)
    print(f"frosted: bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f}")
    assert t <= threshold(len(ours.mean) - 1, FAMILY, BATCHES)
    assert abs(bias) <= LIMIT
    planted, _, _ = judge(nothing, ours, Means(theirs.values * 1.02))
    assert abs(planted) > LIMIT


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
