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
it lights; that all lamps have their power is a matter of the contracts.  In the sphere
furnace every point is a lamp, and Mitsuba is 0.7 % too bright: it samples the sphere
evenly from its own surface, but weights these samples by another density.  There light
is found by scattering alone, of up to one bounce.

Our glossy floor has the base that Mitsuba makes of the file.  Both take what a rough
coat keeps inside as a mean over a table, and with Mitsuba's the base is 0.7 % brighter;
`as_mitsuba_integrates` asks Mitsuba's BSDF, without its reflection, for that.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.catalogue.registry import CATALOGUE
from restir_gi.reference.scene.exporters.export import built_in_scene, exported
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.materials.coat import (
    internal_reflectance,
    transmittance,
    transmittance_table,
)
from restir_gi.reference.scene.materials.kinds import Coated, Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh
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
class Sight:
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
    Sight("cornell-box", 64, 64),
    Sight("door-ajar", 300, 300),
    Sight("sunlit-wall", 4, 8),
    Sight("glossy-floor", 8, 16),
    Sight("grazing-light", 16, 24),
    Sight("sphere-furnace", 1, 8, integrator=BY_SCATTERING, bounces=0),
    Sight("parallel-plates", 8, 16),
    Sight("checker", 4, 8),
    Sight("many-lights", 80, 80),
    Sight("night-market", 4, 8, integrator=EMISSION, bounces=0),
    Sight("shaft", 32, 32, eye=((1.2, 1.6, 1.2), (0.0, 0.0, 0.0))),
    Sight("specular-floor", 48, 64),
    Sight("mirror-floor", 200, 200),
    Sight("glass-floor", 48, 32),
    Sight("moving-camera", 64, 64, frame=24),
    Sight("moving-block", 64, 64, frame=20),
    Sight("moving-light", 64, 64, frame=12),
    Sight("light-switch", 64, 64, frame=15),
    Sight("sunlight-turns", 16, 24, frame=16),
)
COLUMNS = 1 + 16 * 3


def scene_of(case: Sight) -> Scene:
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


def by_us(case: Sight, scene: Scene) -> Means:
    if case.integrator is EMISSION:
        black = Lambertian((0.0, 0.0, 0.0))
        meshes = tuple(replace(mesh, material=black) for mesh in scene.meshes)
        scene = replace(scene, meshes=meshes)
    scene = replace(scene, meshes=tuple(map(as_mitsuba_wears, scene.meshes)))
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


def by_mitsuba(case: Sight, scene: Scene, folder: Any) -> Means:
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


def as_mitsuba_integrates(coat: Coated) -> Coated:
    """The coat whose base is as bright as Mitsuba makes that of a rough plastic."""
    cosine, gray = 0.9, 0.5
    plastic = {
        "type": "roughplastic",
        "distribution": coat.distribution,
        "alpha": coat.alpha,
        "int_ior": coat.ior,
        "ext_ior": 1.0,
        "diffuse_reflectance": {"type": "rgb", "value": gray},
        "specular_reflectance": {"type": "rgb", "value": 0.0},
    }
    mitsuba.set_variant("scalar_rgb")
    bsdf, seen = mitsuba.load_dict(plastic), mitsuba.SurfaceInteraction3f()
    sine = np.sqrt(1 - cosine**2)
    seen.wi = mitsuba.Vector3f(sine, 0, cosine)
    light = mitsuba.Vector3f(-sine, 0, cosine)
    value = np.array(bsdf.eval(mitsuba.BSDFContext(), seen, light))[0]
    width = coat.alpha, coat.ior, coat.distribution
    table = np.array(transmittance_table(*width))
    passed = transmittance(np.array([cosine]), table)[0] ** 2 / coat.ior**2
    ours = gray / (1 - internal_reflectance(*width)) * passed * cosine / np.pi
    ratio = value / ours
    assert abs(ratio - 1) < 0.01
    return replace(coat, reflectance=tuple(ratio * np.array(coat.reflectance)))


def as_mitsuba_wears(mesh: Mesh) -> Mesh:
    if isinstance(mesh.material, Coated) and mesh.material.alpha > 0:
        return replace(mesh, material=as_mitsuba_integrates(mesh.material))
    return mesh


def departures(ours: Means, theirs: Means) -> np.ndarray:
    """|t| of the mean and of each tile and channel.

    What neither renderer sees to vary is held to single precision.
    """
    rounding = 2.0**-20 * np.abs(theirs.mean)
    error = np.sqrt(ours.error**2 + theirs.error**2 + rounding**2).clip(1e-300)
    return np.abs(ours.mean - theirs.mean) / error


def test_all_scenes_that_mitsuba_can_read_are_judged():
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
    # Welch's degrees of freedom are at least those of one group of batches.
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
