"""Real scenes load in the ways that they come, with what their makers say of them.

The scenes are no part of this repository.  They are looked for in the folder that the
environment variable RESTIR_SCENES names, else in ``shared/scenes`` beside the checkout.
"""

import json
import os
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.reports.effects import effects
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
)
from restir_gi.reference.scene.named import Named, frames_of
from restir_gi.reference.scene.textures import Bitmap, Checker
from restir_gi.reference.system.errors import UsageError

BESIDE = Path(__file__).parents[3] / "shared" / "scenes"
SCENES = Path(os.environ.get("RESTIR_SCENES", BESIDE))

pytestmark = pytest.mark.skipif(
    not (SCENES / "veach-ajar").is_dir(),
    reason="set RESTIR_SCENES to a folder with the scenes staircase2 and veach-ajar",
)
SIMPLE = "veach-ajar/simple/scene"


@pytest.fixture
def mitsuba():
    return pytest.importorskip(
        "mitsuba", reason="reads Mitsuba XML by the package mitsuba"
    )


@cache
def load(name, lenient=False):
    return load_scene(SCENES / name, lenient)


def triangles(scene):
    return {mesh.name: len(mesh.faces) for mesh in scene.meshes}


def test_the_plain_ajar_has_the_triangles_that_its_file_promises():
    scene = load(f"{SIMPLE}.json")
    promised = json.loads((SCENES / f"{SIMPLE}.json").read_text())["shapes"]
    assert triangles(scene) == {shape["id"]: shape["triangles"] for shape in promised}
    assert sum(triangles(scene).values()) == 4546
    assert scene.notes == ()


def test_the_plain_ajar_is_what_its_readme_says():
    scene = load(f"{SIMPLE}.json")
    camera = scene.camera
    assert (camera.width, camera.height, camera.fov) == (128, 72, 60)
    assert camera.position == (4.05402, 1.61647, -2.30652)
    # All materials two-sided, metals with alpha 0.25, faces flat, one lamp.
    assert all(mesh.material.two_sided for mesh in scene.meshes)
    metals = [m.material for m in scene.meshes if isinstance(m.material, Conductor)]
    assert {metal.alpha for metal in metals} == {0.25}
    assert all(mesh.normals is None for mesh in scene.meshes)
    assert [m.name for m in scene.meshes if any(m.emission)] == ["Light"]
    assert (scene.environment, scene.points, scene.suns) == (None, (), ())


def test_both_forms_of_the_plain_ajar_are_one_scene(mitsuba):
    one, other = load(f"{SIMPLE}.json"), load(f"{SIMPLE}.xml")
    assert other.notes == ()
    for a, b in zip(one.meshes, other.meshes, strict=True):
        assert_array_equal(a.vertices[a.faces], b.vertices[b.faces])
        assert a.emission == b.emission
        assert type(a.material) is type(b.material)
        assert a.material.two_sided == b.material.two_sided
        assert a.material.reflectance == b.material.reflectance
        if isinstance(a.material, Conductor):
            assert (a.material.alpha, a.material.eta) == (b.material.alpha, None)
    assert one.camera.fov == other.camera.fov
    assert one.camera.fov_axis == other.camera.fov_axis
    assert_allclose(one.camera.axes, other.camera.axes, atol=1e-6)  # printed digits


def test_the_whole_ajar_is_refused_for_what_it_lacks(mitsuba):
    with pytest.raises(UsageError) as refusal:
        load("veach-ajar/scene.xml")
    assert str(refusal.value).count("is missing (with --lenient: left out)") == 6


def test_the_whole_ajar_leniently(mitsuba):
    scene = load("veach-ajar/scene.xml", lenient=True)
    # The same room, but for the textures.
    assert triangles(scene) == triangles(load(f"{SIMPLE}.json"))
    pots = ["Pot2_0001", "Pot2_0002", "Pot3_0001", "Pot3_0002"]
    pots += ["Material_0001", "Material_0002"]
    missing = [note for note in scene.notes if "missing: left out" in note]
    assert len(missing) == len(pots)
    for pot in pots:
        assert any(pot in note for note in missing)
    assert len(scene.notes) == len(pots)

    materials = {mesh.name: mesh.material for mesh in scene.meshes}
    floor = materials["Floor"]
    assert floor.reflectance == Checker((0.8,) * 3, (0.2,) * 3, (20.0, 80.0))
    assert (floor.alpha, floor.eta) == (0.1, (1.65746, 0.880369, 0.521229))
    assert isinstance(materials["Landscape"].reflectance, Bitmap)
    assert materials["Landscape"].reflectance.filter == "nearest"
    assert materials["Door"].reflectance.filter == "bilinear"
    # Its plain form has the mean colours of the textures.
    for name in ("Landscape", "Table", "Door"):
        plain = {m.name: m.material for m in load(f"{SIMPLE}.json").meshes}[name]
        mean = materials[name].reflectance.pixels.mean(axis=(0, 1))
        assert_allclose(mean, plain.reflectance, atol=6e-4)
    assert (scene.camera.width, scene.camera.height) == (1280, 720)


def test_the_staircase_is_refused_for_its_tiles(mitsuba):
    with pytest.raises(UsageError, match='principled in twosided "FloorTilesBSDF"'):
        load("staircase2/scene.xml")


def test_the_staircase_leniently(mitsuba):
    scene = load("staircase2/scene.xml", lenient=True)
    camera = scene.camera
    assert camera.position == (6.91182, 1.65163, 2.55414)
    assert (camera.width, camera.height, camera.fov) == (1024, 1024, 70)
    assert not camera.mirrored
    for words in (("principled", "FloorTiles"), ("Glass", "homogeneous"), ("Disks",)):
        assert any(all(word in note for word in words) for note in scene.notes)
    assert len(scene.notes) == 4  # and what the principled one is taken as

    # 19 models; 5 disks of 126 triangles and 8 rectangles of 2.
    counts = Counter(mesh.name.split()[0] for mesh in scene.meshes)
    assert (counts["disk"], counts["rectangle"]) == (5, 8)
    in_files = 0
    for path in (SCENES / "staircase2" / "models").glob("*.obj"):
        lines = path.read_text().splitlines()
        corners = [len(line.split()) - 1 for line in lines if line.startswith("f ")]
        in_files += sum(n - 2 for n in corners)
    assert len(scene.meshes) == 19 + 5 + 8
    assert sum(triangles(scene).values()) == in_files + 5 * 126 + 8 * 2

    materials = {mesh.name: mesh.material for mesh in scene.meshes}
    assert materials["Glass"] == Dielectric(1.5)
    wood = materials["Wood_0001"]
    assert isinstance(wood, Coated)
    assert (wood.alpha, wood.nonlinear, wood.two_sided) == (0.1, True, True)
    tiles = materials["FloorTiles"]
    assert isinstance(tiles, Conductor)
    assert (tiles.schlick, tiles.alpha) == (True, 0.25)
    assert isinstance(materials["Wall_0001"], Lambertian)
    lamps = [mesh for mesh in scene.meshes if any(mesh.emission)]
    assert len(lamps) == 13
    # The lamps in the ceiling shine downwards.
    disks = [lamp for lamp in lamps if len(lamp.faces) == 126]
    for disk in disks:
        a, b, c = disk.vertices[disk.faces[0]]
        assert np.cross(b - a, c - a)[1] < 0


REAL = ("veach-ajar/simple/scene.json", "veach-ajar/scene.xml", "staircase2/scene.xml")


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_what_is_left_out_of_a_real_scene_changes_nothing(name, mitsuba):
    """With two bounces, in four frames, to the last bit."""
    scene = load(name, lenient=True)
    named = Named(str(SCENES / name), True, 24, 16)
    found = effects(frames_of(named, scene), 2, 4, lambda done, total: None)
    assert found
    assert all(effect.identical for effect in found), found
