"""ReSTIR GI against Mitsuba's own renders of the same scene files.

Evidence: statistics, and an independent renderer.  One-bounce indirect light is Mitsuba's
picture of at most three segments less that of at most two.  Mitsuba spreads its samples
over each pixel, so every run of ours has its visible points at random places of theirs.
The image mean must agree within 0.5 %, and no 8 x 8 tile may leave its band; a correct
estimator fails the tiles of one scene with probability 1e-4.  The control brightens the
truth by 2 %, which the image mean must notice.
"""

from pathlib import Path

import numpy as np
import pytest

from reference.scene.loaders.load import load_scene
from reference.settings import UNBIASED
from tests.statistics.replicates import (
    Means,
    g_buffer,
    means,
    run,
    small_world,
    threshold,
)

mitsuba = pytest.importorskip("mitsuba", reason="Mitsuba renders the truth")

FAMILY = 1e-4
LIMIT = 0.005
BATCHES = 32

STUDIO = """<scene version="3.0.0">
<sensor type="perspective">
 <float name="fov" value="50"/>
 <transform name="to_world"><lookat origin="1.6,1.7,3.4" target="0,0.5,0" up="0,1,0"/></transform>
 <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/>
 <rfilter type="box"/></film>
</sensor>
<bsdf type="twosided" id="wall"><bsdf type="diffuse"><rgb name="reflectance" value="0.7,0.6,0.5"/></bsdf></bsdf>
<bsdf type="twosided" id="tiles"><bsdf type="diffuse">
 <texture name="reflectance" type="checkerboard"><rgb name="color0" value="0.8,0.8,0.8"/><rgb name="color1" value="0.2,0.3,0.4"/>
 <transform name="to_uv"><scale x="4" y="4"/></transform></texture></bsdf></bsdf>
<bsdf type="twosided" id="metal"><bsdf type="roughconductor"><string name="distribution" value="ggx"/>
 <float name="alpha" value="0.2"/><rgb name="eta" value="0.2,0.9,1.1"/><rgb name="k" value="3.9,2.4,2.2"/></bsdf></bsdf>
<bsdf type="twosided" id="lacquer"><bsdf type="roughplastic"><string name="distribution" value="ggx"/>
 <float name="alpha" value="0.15"/><boolean name="nonlinear" value="true"/><rgb name="diffuse_reflectance" value="0.6,0.2,0.1"/></bsdf></bsdf>
<bsdf type="twosided" id="gloss"><bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.2,0.5,0.3"/></bsdf></bsdf>
<bsdf type="twosided" id="mirror"><bsdf type="conductor"><string name="material" value="Ag"/></bsdf></bsdf>
<bsdf type="dielectric" id="glass"/>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform><ref id="tiles"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-1.5"/></transform><ref id="wall"/></shape>
<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="90"/><scale value="3"/><translate x="-2"/></transform><ref id="wall"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.3"/><rotate y="1" angle="30"/><translate x="-1" y="0.3" z="0.2"/></transform><ref id="metal"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.3"/><rotate y="1" angle="10"/><translate x="-0.2" y="0.3" z="-0.5"/></transform><ref id="lacquer"/></shape>
<shape type="cube"><transform name="to_world"><scale value="0.25"/><rotate y="1" angle="-20"/><translate x="0.6" y="0.25" z="0"/></transform><ref id="gloss"/></shape>
<shape type="sphere"><point name="center" x="0.1" y="0.25" z="0.7"/><float name="radius" value="0.25"/><ref id="mirror"/></shape>
<shape type="sphere"><point name="center" x="-0.6" y="0.2" z="1.1"/><float name="radius" value="0.2"/><ref id="glass"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="120"/><translate x="0.5" y="2.6" z="1"/></transform>
 <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
 <emitter type="area"><rgb name="radiance" value="18,16,14"/></emitter></shape>
</scene>
"""


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


def restir(path: Path, width: int, height: int, runs: int, frames: int) -> Means:
    """The last frames of independent runs, each with visible points of its own."""
    world = small_world(load_scene(path), width, height)
    rng = np.random.default_rng(7)
    rows = [
        run(world, UNBIASED, frames, seed, g_buffer(world, rng))[0]
        for seed in range(runs)
    ]
    return means(rows, width)


def judge(ours: Means, theirs: Means, runs: int) -> tuple[float, float, float]:
    """Relative bias of the image mean, its error, and the largest |t| of the tiles."""
    difference = ours.mean - theirs.mean
    error = np.hypot(ours.error, theirs.error).clip(1e-300)
    t = np.abs(difference / error)[1:].max()
    scale = theirs.mean[0]
    return float(difference[0] / scale), float(error[0] / scale), float(t)


def check(path: Path, width: int, height: int, runs: int, samples: int) -> None:
    ours = restir(path, width, height, runs, frames=4)
    theirs = rendered(path, width, height, samples)
    bias, error, t = judge(ours, theirs, runs)
    print(f"{path.parent.name}: bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f}")
    # Welch's degrees of freedom are at least those of the smaller group.
    degrees = min(runs, BATCHES)
    assert t <= threshold(len(ours.mean) - 1, FAMILY, degrees)
    assert abs(bias) <= LIMIT
    brighter = Means(theirs.values * 1.02)
    planted, error, _ = judge(ours, brighter, runs)
    assert abs(planted) > LIMIT
    assert abs(planted) > 3 * error


@pytest.mark.slow
def test_all_materials_in_one_room(tmp_path):
    path = tmp_path / "studio.xml"
    path.write_text(STUDIO)
    check(path, 64, 48, runs=600, samples=256)


@pytest.mark.slow
def test_a_real_room_behind_a_door(scenes_folder):
    path = scenes_folder / "veach-ajar" / "simple" / "scene.xml"
    check(path, 64, 40, runs=1200, samples=1024)
