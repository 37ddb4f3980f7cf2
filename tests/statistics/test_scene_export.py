"""Exported scenes, rendered by Mitsuba itself, against the built-in ones.

Evidence: statistics, and an independent renderer that reads the files without a line of
ours.  Of each scene that Mitsuba XML can say, all light of two bounces is compared: the
mean of the picture and each of 4 x 4 tiles in each channel.  Both renderers spread
their samples over each pixel.  A correct export fails in any of the scenes with
probability ``FAMILY`` in all.  The control brightens Mitsuba's picture by 3 %, which
must be found: a scale of lengths, an angle of view, a reflectance or a light that is as
far off would be.

Four scenes are looked at in another way.  Moving ones are exported in a frame in which
something has moved, since in frame 0 they are the Cornell box.  In the shaft the eye
stands before the spot that the shaft lights: where it is otherwise, light comes in one
of thousands of paths.  At the night market 30,000 lamps hang, of which each place sees
a few: neither renderer finds these to 3 %, so the eye looks into one lamp, without what
it lights; that all lamps have their power is a matter of `test_scene_export.py` in the
contracts.  Within the sphere furnace, every point of which is a lamp, Mitsuba's light
sampling is 0.7 % too bright, since in single precision half of these points seem to lie
outside of the sphere, and their density is taken for that of a cone; there its lights
are found by scattering alone, up to one bounce.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.exporters.export import built_in_scene, exported
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.transport.accumulate import path_samples
from tests.statistics.replicates import Means, means, small_world, threshold

mitsuba = pytest.importorskip("mitsuba", reason="Mitsuba renders the exported scenes")

FAMILY = 1e-4
PLANTED = 1.03
SIZE = 32  # pixels: 4 x 4 tiles of 8 x 8
BATCHES = 32
BOUNCES = 2

BY_SCATTERING = {"type": "direct", "bsdf_samples": 1, "emitter_samples": 0}
EMISSION = {"type": "path", "max_depth": 1}


def paths() -> dict[str, Any]:
    return {"type": "path", "max_depth": BOUNCES + 2, "rr_depth": 1000}


@dataclass(frozen=True)
class Case:
    """A scene, and how it is looked at.

    ``ours`` and ``theirs`` are samples a pixel in a batch, enough for an error of the
    mean of some thousandths.
    """

    name: str
    ours: int
    theirs: int
    frame: int = 0
    eye: tuple[tuple[float, float, float], ...] = ()
    integrator: dict[str, Any] = field(default_factory=paths)
    bounces: int = BOUNCES


CASES = (
    Case("cornell-box", 64, 64),
    Case("door-ajar", 400, 400),
    Case("sunlit-wall", 4, 8),
    Case("glossy-floor", 8, 16),
    Case("grazing-light", 16, 24),
    Case("sphere-furnace", 1, 8, integrator=BY_SCATTERING, bounces=0),
    Case("parallel-plates", 8, 16),
    Case("checker", 4, 8),
    Case("many-lights", 80, 80),
    Case("night-market", 4, 8, integrator=EMISSION, bounces=0),
    Case("shaft", 32, 32, eye=((1.2, 1.6, 1.2), (0.0, 0.0, 0.0))),
    Case("specular-floor", 48, 64),
    Case("mirror-floor", 200, 200),
    Case("glass-floor", 48, 32),
    Case("moving-camera", 64, 64, frame=24),
    Case("moving-block", 64, 64, frame=20),
    Case("moving-light", 64, 64, frame=12),
    Case("light-switch", 64, 64, frame=15),
    Case("sunlight-turns", 16, 24, frame=16),
)
COLUMNS = 1 + 16 * 3


def scene_of(case: Case) -> Scene:
    scene = built_in_scene(case.name, case.frame)
    camera = replace(scene.camera, width=SIZE, height=SIZE)
    if case.eye:
        camera = replace(camera, position=case.eye[0], target=case.eye[1])
    if case.integrator is EMISSION:
        lamps = next(mesh for mesh in scene.meshes if any(mesh.emission))
        center = world_corners(lamps)[0].mean(axis=0)
        below = center - [0.0, 0.5, 0.0]
        camera = replace(camera, position=tuple(below), target=tuple(center), fov=3.0)
        camera = replace(camera, up=(0.0, 0.0, 1.0))
    return replace(scene, camera=camera)


def by_us(case: Case, scene: Scene) -> Means:
    if case.integrator is EMISSION:
        black = Lambertian((0.0, 0.0, 0.0))
        meshes = tuple(replace(mesh, material=black) for mesh in scene.meshes)
        scene = replace(scene, meshes=meshes)
    world = small_world(scene, SIZE, SIZE)
    rows = []
    for batch in range(BATCHES):
        samples = path_samples(
            world,
            Schedule(),
            light="full",
            bounces=case.bounces,
            seed=batch,
            pixel="box",
        )
        every = slice(0, samples.rows)
        total = sum(samples.radiance(every, number) for number in range(case.ours))
        rows.append(total / case.ours)
    return means(rows, SIZE)


def by_mitsuba(case: Case, scene: Scene, folder: Any) -> Means:
    for name, contents in exported(scene).files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(contents)
    mitsuba.set_variant("scalar_rgb")
    loaded = mitsuba.load_file(str(folder / f"{scene.name}.xml"))
    integrator = mitsuba.load_dict(case.integrator)
    pictures = [
        mitsuba.render(loaded, integrator=integrator, seed=batch, spp=case.theirs)
        for batch in range(BATCHES)
    ]
    rows = [np.array(p, np.float64)[..., :3].reshape(-1, 3) for p in pictures]
    return means(rows, SIZE)


def departures(ours: Means, theirs: Means) -> np.ndarray:
    """|t| of the mean and of each tile and channel.

    What neither renderer sees to vary is held to single precision.
    """
    rounding = 2.0**-20 * np.abs(theirs.mean)
    error = np.sqrt(ours.error**2 + theirs.error**2 + rounding**2).clip(1e-300)
    return np.abs(ours.mean - theirs.mean) / error


def test_all_scenes_that_mitsuba_can_read_are_judged():
    from restir_gi.reference.scene.catalogue.registry import CATALOGUE

    told = [name for name in CATALOGUE if "Mitsuba XML" in refusals(name)]
    assert [case.name for case in CASES] == [n for n in CATALOGUE if n not in told]


def refusals(name: str) -> dict[str, str]:
    return exported(built_in_scene(name, 0)).refused


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_mitsuba_sees_the_scene_that_was_exported(case, tmp_path):
    scene = scene_of(case)
    ours, theirs = by_us(case, scene), by_mitsuba(case, scene, tmp_path)
    assert theirs.mean.shape == (COLUMNS,)
    # The fewer degrees of freedom of two groups of so many batches.
    bound = threshold(COLUMNS * len(CASES), FAMILY, BATCHES)
    found = departures(ours, theirs)
    planted = departures(ours, Means(theirs.values * PLANTED))
    ratio = ours.mean[0] / theirs.mean[0] - 1
    error = np.hypot(ours.error[0], theirs.error[0]) / theirs.mean[0]
    print(
        f"{case.name}: mean {ratio:+.3%} +- {error:.3%}; largest |t|"
        f" {found.max():.2f} of {bound:.2f}, with 3 % planted {planted.max():.2f}"
    )
    assert found.max() <= bound
    assert planted.max() > bound
