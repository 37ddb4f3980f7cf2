"""What a scene requires: each feature found where it is, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.registry import CATALOGUE, find_scene
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.scene.convexity import MOST_TRIANGLES, first_obstacle
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    LatLongEnvironment,
    PointLight,
    SpotLight,
)
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    mirror,
)
from restir_gi.reference.scene.requirements import left_out, requirements, survey
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Sphere, box, quad
from restir_gi.reference.scene.textures import Bitmap, Checker
from tests.analytic.rendering import moved, what_is_seen, world_of

GREY = Lambertian((0.5, 0.5, 0.5))
FLOOR = quad("floor", (-1, 0, 1), (2, 0, 0), (0, 0, -2), GREY)
SUN = DirectionalLight((0, -1, 0), (1.0, 1.0, 1.0))
LEAST = Scene(
    name="least",
    camera=Camera(position=(0, 1, 3), target=(0, 0, 0)),
    meshes=(FLOOR,),
    suns=(SUN,),
)
ALWAYS = {"triangles", "Lambertian surfaces", "suns"}


def names(scene):
    return {r.name for r in requirements(scene)}


def why(scene, name):
    (found,) = [r.why for r in survey(scene) if r.name == name]
    return found


def made_of(material):
    return replace(LEAST, meshes=(FLOOR, replace(FLOOR, name="it", material=material)))


def lit_by(**lights):
    return replace(LEAST, **lights)


BALL = Sphere(name="it", center=(0, 1, 0), radius=0.5, material=GREY)
WHITE = np.ones((2, 2, 3))
GLOW, DARK = Checker((1.0, 0, 0), (0.0, 0, 0)), Bitmap(np.zeros((2, 2, 3)))
SHINING = replace(BALL, emission=(1.0, 0, 0), two_sided_emission=True)
METAL = (0.9, 0.9, 0.9)
GLOSSY = "sample points that are not Lambertian"
HIDES = "occlusion between points"
HITS = "emitter hits"
ADDED = {
    "nothing": (LEAST, set()),
    "sphere": (replace(LEAST, spheres=(BALL,)), {"spheres", HIDES}),
    "normals": (
        replace(LEAST, meshes=(replace(FLOOR, name="it", normals=np.ones((4, 3))),)),
        {"smooth normals"},
    ),
    "bitmap": (made_of(Lambertian(Bitmap(WHITE))), {"textures"}),
    "checker": (made_of(Lambertian(Checker(METAL, METAL))), {"textures"}),
    "one-sided": (made_of(Lambertian(METAL, two_sided=False)), {"one-sided materials"}),
    "rough metal": (made_of(Conductor(METAL, 0.1)), {"rough conductors", GLOSSY}),
    "black metal": (made_of(Conductor((0.0, 0, 0), 0.1)), {"rough conductors"}),
    "mirror": (made_of(mirror()), {"delta lobes", GLOSSY}),
    "rough coat": (made_of(Coated(METAL, 0.1)), {"coats", GLOSSY}),
    "smooth coat": (made_of(Coated(METAL, 0.0)), {"coats", "delta lobes", GLOSSY}),
    "glass": (made_of(Dielectric()), {"dielectrics", "delta lobes", GLOSSY}),
    "lamp": (
        replace(LEAST, meshes=(FLOOR, replace(FLOOR, name="it", emission=(1.0, 0, 0)))),
        {"area lights", HITS},
    ),
    "textured lamp": (
        replace(LEAST, meshes=(FLOOR, replace(FLOOR, name="it", emission=GLOW))),
        {"area lights", "textured lights", HITS},
    ),
    "black texture": (
        replace(LEAST, meshes=(FLOOR, replace(FLOOR, name="it", emission=DARK))),
        set(),
    ),
    "lamp of two sides": (
        lit_by(spheres=(SHINING,)),
        {"spheres", "area lights", "lights of two sides", HIDES, HITS},
    ),
    "spot light": (
        lit_by(spots=(SpotLight((0, 1, 0), (0, -1, 0), (1.0, 1, 1), 30.0, 20.0),)),
        {"spot lights"},
    ),
    "point light": (
        lit_by(points=(PointLight((0, 1, 0), (1.0, 1, 1)),)),
        {"point lights"},
    ),
    "sky": (
        lit_by(environment=ConstantEnvironment((1.0, 1, 1))),
        {"environment", HITS},
    ),
    "sky map": (lit_by(environment=LatLongEnvironment(WHITE)), {"environment", HITS}),
    "obstacle": (
        replace(LEAST, meshes=(FLOOR, box("it", (1, 1, 1), pose(9, (0, 2, 0)), GREY))),
        {HIDES},
    ),
}


@pytest.mark.parametrize("case", ADDED)
def test_each_part_asks_for_its_feature_and_for_no_other(case):
    scene, expected = ADDED[case]
    assert names(scene) == ALWAYS | expected
    for name in expected - {"point lights", "spot lights", "environment", HITS}:
        assert name == HIDES or '"it"' in why(scene, name)


@pytest.mark.parametrize("case", ADDED)
def test_what_is_not_required_is_left_out_and_nothing_is_both(case):
    scene, _ = ADDED[case]
    needed, without = requirements(scene), left_out(scene)
    assert not any(r.left_out for r in needed)
    assert all(r.left_out for r in without)
    assert {r.name for r in needed} | {r.name for r in without} == {
        r.name for r in survey(LEAST)
    }
    assert len(needed) + len(without) == len(survey(LEAST))
    assert all(r.why for r in survey(scene))


def test_long_lists_are_counted():
    many = tuple(replace(FLOOR, name=f"floor {i}") for i in range(5))
    words = 'mesh "floor 0", mesh "floor 1", mesh "floor 2" and 2 more'
    assert why(replace(LEAST, meshes=many), "triangles") == words
    assert why(lit_by(suns=(SUN, SUN)), "suns") == "2 suns"


NOT_LAMBERTIAN = {"glossy-floor", "specular-floor", "mirror-floor", "glass-floor"}
"""Scenes with coats, mirrors and glass."""


def test_the_lambertian_assumption_is_named_where_it_matters():
    assert '"it"' in why(made_of(Coated(METAL, 0.1)), GLOSSY)
    assert "reuse" in why(made_of(Coated(METAL, 0.1)), GLOSSY)
    for name in CATALOGUE:
        assert (GLOSSY in names(find_scene(name))) == (name in NOT_LAMBERTIAN)


CONVEX = {"sunlit-wall", "parallel-plates", "sphere-furnace", "half-lit-sphere"}


@pytest.mark.parametrize("name", CATALOGUE)
def test_convex_scenes_are_told_from_others(name):
    assert (HIDES not in names(find_scene(name))) == (name in CONVEX)


@pytest.mark.parametrize("name", ["sunlit-wall", "parallel-plates", "door-ajar"])
def test_convexity_does_not_depend_on_place_and_size(name):
    scene = find_scene(name)
    turn = 1e-3 * pose(33, (0, 0, 0))
    turn[:, 3] = 1e3, -2e3, 3e3, 1.0
    there = moved(scene, turn)
    assert (first_obstacle(there) is None) == (first_obstacle(scene) is None)


@pytest.mark.parametrize("name", sorted(CONVEX))
def test_in_a_convex_scene_all_points_see_each_other(name):
    """Evidence for leaving visibility out: no ray between points before each other."""
    world = world_of(find_scene(name), 24)
    seen = what_is_seen(world)
    rng = np.random.default_rng(1)
    hit = np.flatnonzero(seen.hit)
    a, b = rng.choice(hit, 4000), rng.choice(hit, 4000)
    toward = seen.position[b] - seen.position[a]
    sees = np.einsum("ij,ij->i", toward, seen.normal[a]) > 1e-3
    sees &= np.einsum("ij,ij->i", toward, seen.normal[b]) < -1e-3
    assert sees.sum() > 50
    a, b = a[sees], b[sees]
    everyone = np.ones(len(a), bool)
    to = take(seen, b)
    free = world.caster.visible(
        take(seen, a), to.position, to.normal, everyone, "reuse"
    )
    assert free.all()


def test_a_scene_of_many_triangles_is_taken_to_have_obstacles():
    faces = np.tile(FLOOR.faces, (MOST_TRIANGLES // 2 + 1, 1))
    scene = replace(LEAST, meshes=(replace(FLOOR, faces=faces),))
    assert first_obstacle(scene) is scene.meshes[0]
