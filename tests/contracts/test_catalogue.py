"""The built-in scenes: their names, and that each shows what its docstring says."""

import inspect
from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.scene.catalogue.animations import CHANGE
from restir_gi.reference.scene.catalogue.registry import (
    CATALOGUE,
    find_animation,
    find_scene,
)
from restir_gi.reference.scene.catalogue.rooms import WHITE
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.materials.kinds import Coated, Dielectric, Lambertian
from restir_gi.reference.scene.shapes import quad
from restir_gi.reference.system.errors import UsageError
from tests.analytic.rendering import path_traced, what_is_seen, world_of

NAMES = [
    "cornell-box",
    "door-ajar",
    "sunlit-wall",
    "glossy-floor",
    "grazing-light",
    "sphere-furnace",
    "half-lit-sphere",
    "parallel-plates",
    "checker",
    "many-lights",
    "night-market",
    "shaft",
    "specular-floor",
    "mirror-floor",
    "glass-floor",
    "moving-camera",
    "moving-block",
    "moving-light",
    "light-switch",
    "sunlight-turns",
]
KNOWN = {"sunlit-wall", "sphere-furnace", "half-lit-sphere", "parallel-plates"}

HARD = {"specular-floor": (2, 200), "shaft": (2, 400)}
"""Bounces, and samples a pixel, with which indirect light is found."""

ANIMATED = set(NAMES[15:])

every_scene = pytest.mark.parametrize("name", NAMES)


def test_the_catalogue_has_its_scenes():
    assert list(CATALOGUE) == NAMES
    assert {name for name, entry in CATALOGUE.items() if entry.animate} == ANIMATED
    assert {name for name, entry in CATALOGUE.items() if entry.answer} == KNOWN


@every_scene
def test_an_entry_is_named_as_its_scene_and_says_what_it_shows(name):
    entry = CATALOGUE[name]
    assert entry.name == name
    assert entry.build().name == name
    for text in (entry.summary, entry.answer or "x"):
        assert text.isascii()
        assert "\n" not in text
        assert len(text) <= 88
    assert inspect.getdoc(entry.build)
    assert entry.animate is None or inspect.getdoc(entry.animate)


@every_scene
def test_a_scene_is_the_same_each_time_and_never_shared(name):
    first, second = find_scene(name), find_scene(name)
    assert first is not second
    assert first.camera == second.camera
    for a, b in zip(first.meshes, second.meshes, strict=True):
        assert np.array_equal(a.vertices, b.vertices)
        assert np.array_equal(a.pose, b.pose)
        assert a.emission == b.emission


@every_scene
def test_mesh_names_differ(name):
    names = [mesh.name for mesh in find_scene(name).meshes]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    ("given", "meant"),
    [("cornell", "cornell-box"), ("door_ajar", "door-ajar"), ("furnace", None)],
)
def test_an_unknown_name_is_told_which_there_are(given, meant):
    with pytest.raises(UsageError) as error:
        find_scene(given)
    message = str(error.value)
    assert repr(given) in message
    assert all(name in message for name in NAMES)
    assert meant is None or f"did you mean {meant}?" in message


@every_scene
def test_a_picture_has_light_and_most_of_it_is_finite_and_seen(name):
    world = world_of(find_scene(name), 16)
    color = path_traced(world, "full", bounces=2, samples=4)
    assert np.isfinite(color).all()
    assert (color >= 0).all()
    assert color.any()
    # Few paths find the light that the polished floor shows.
    bounces, samples = HARD.get(name, (1, 8))
    indirect = path_traced(world, "indirect", bounces=bounces, samples=samples)
    # The subject of the project: indirect light in a good part of each picture.
    assert (indirect.sum(axis=1) > 0).mean() > 0.1


# ---------------------------------------------------------------- scene by scene


def test_door_ajar_is_lit_through_the_gap_alone():
    """A plug in the doorway leaves the camera's room exactly black."""
    scene = find_scene("door-ajar")
    plug = quad("plug", (-2, 0, -0.6), (0, 0, 1.2), (0, 2.1, 0), WHITE)
    shut = world_of(replace(scene, meshes=(*scene.meshes, plug)), 32)
    assert not path_traced(shut, "full", bounces=3, samples=16).any()
    ajar = world_of(scene, 32)
    color = path_traced(ajar, "full", bounces=3, samples=96)
    # Hard, not hopeless: all of the room is lit, a tenth directly.
    assert (color.sum(axis=1) > 0).mean() > 0.8
    direct = path_traced(ajar, "direct", samples=16)
    assert 0.02 < (direct.sum(axis=1) > 0).mean() < 0.2
    # Less than a quarter of the light comes straight: the rest has been around.
    assert direct.sum() < 0.25 * color.sum()


def direct_on(name):
    """What is seen, and its direct light."""
    world = world_of(find_scene(name), 48)
    return what_is_seen(world), path_traced(world, "direct", samples=2)


def test_sunlit_wall_is_lit_evenly_and_the_floor_not_at_all():
    seen, color = direct_on("sunlit-wall")
    floor, wall = seen.primitive == 0, seen.primitive >= 2
    floor |= seen.primitive == 1
    assert not color[floor].any()
    assert wall.sum() > 100
    assert np.ptp(color[wall], axis=0).max() <= 4 * 2.0**-52 * color.max()


def test_parallel_plates_are_lit_on_the_upper_one_from_below():
    seen, color = direct_on("parallel-plates")
    lower = seen.hit & (seen.primitive < 2)
    upper = seen.primitive >= 2
    assert not color[lower].any()
    assert lower.sum() > 300
    assert upper.sum() > 100
    assert color[upper].min() > 0
    assert np.ptp(color[upper], axis=0).max() <= 4 * 2.0**-52 * color.max()


def test_grazing_light_leaves_floor_and_blocks_in_the_shade_of_the_screen():
    """All direct light falls on the upper half of the wall on the left."""
    seen, color = direct_on("grazing-light")
    lit = color.any(axis=1)
    assert lit.sum() > 50
    assert (seen.position[lit, 0] < -0.999).all()
    assert (seen.position[lit, 1] > 0.399).all()
    on_floor = seen.hit & (seen.position[:, 1] < 0.01)
    assert on_floor.mean() > 0.4
    # From the floor the strip is at most 22 degrees high beyond a metre from the wall.
    assert np.degrees(np.arctan(0.8 / 2.0)) < 22


def test_glossy_floor_is_seen_with_shadow_and_is_not_lambertian():
    scene = find_scene("glossy-floor")
    assert isinstance(scene.meshes[0].material, Coated)
    seen, color = direct_on("glossy-floor")
    on_floor = seen.hit & (seen.position[:, 1] < 0.01)
    assert on_floor.mean() > 0.3
    assert 0.02 < (~color[on_floor].any(axis=1)).mean() < 0.3


def test_many_lights_are_thirty_thousand_and_none_is_forgotten():
    world = world_of(find_scene("many-lights"), 8)
    assert len(world.emitters.primitive) == 30_000
    assert (world.emitters.probability > 0).all()
    lamps = [m for m in find_scene("many-lights").meshes if any(m.emission)]
    for corners in map(world_corners, lamps):
        # Fronts, and light with them, face down.
        front = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (front[:, 1] < 0).all()
        assert np.ptp(corners[..., 1], axis=1).max() < 1e-12


def test_on_the_specular_floor_the_lamp_lights_a_spot_of_the_floor_alone():
    """Whatever else is bright has its light from there."""
    seen, direct = direct_on("specular-floor")
    lit = direct.any(axis=1)
    assert 20 < lit.sum() < 0.1 * len(lit)
    assert (seen.position[lit, 1] < 0.01).all()
    # The spot is that of a point through the mouth of the shade.
    x, z = seen.position[lit, 0], seen.position[lit, 2]
    spread = 0.25 * 0.65 / 0.4 + 0.01
    assert np.abs(x - 0.75).max() < spread
    assert np.abs(z + 1.25).max() < spread


def test_what_the_specular_floor_mirrors_is_more_than_what_it_paints():
    """In the picture of indirect light: with a matt floor most of it is gone."""
    scene = find_scene("specular-floor")
    floor = scene.meshes[0]
    matt = replace(floor, material=Lambertian(floor.material.reflectance))
    shiny, painted = (
        world_of(replace(scene, meshes=(mesh, *scene.meshes[1:])), 32)
        for mesh in (floor, matt)
    )
    # Of the floor that is not lit itself, seen under its own grazing angle.
    seen = what_is_seen(shiny)
    rows = seen.hit & (seen.position[:, 1] < 0.01)
    colors = [
        path_traced(w, "indirect", bounces=2, samples=400) for w in (shiny, painted)
    ]
    ratio = colors[0][rows].sum() / colors[1][rows].sum()
    assert ratio > 1.5


def of_the_floor(name, part):
    """Light of the pixels that see the floor: as it is, of the rest, without a part."""
    scene = find_scene(name)
    seen = what_is_seen(world_of(scene, 32))
    floor = seen.hit & (seen.position[:, 1] < 0.01)
    assert floor.mean() > 0.3
    meshes = tuple(mesh for mesh in scene.meshes if mesh.name != part)
    assert len(meshes) == len(scene.meshes) - 1
    color, bare = (
        path_traced(world_of(each, 32), "full", bounces=4, samples=64)
        for each in (scene, replace(scene, meshes=meshes))
    )
    return color[floor].mean(), color[~floor].mean(), bare[floor].mean()


def test_the_mirror_floor_shows_the_room():
    floor, room, bare = of_the_floor("mirror-floor", "floor")
    assert 0.3 * room < floor < 1.5 * room
    assert bare == 0.0


def test_the_ground_is_seen_through_the_glass_floor():
    pane, _, bare = of_the_floor("glass-floor", "ground")
    assert isinstance(find_scene("glass-floor").meshes[0].material, Dielectric)
    assert pane > 1.3 * bare > 0


def test_spheres_are_seen_from_inside():
    for name in ("sphere-furnace", "half-lit-sphere"):
        seen = what_is_seen(world_of(find_scene(name), 16))
        assert seen.front.all()
        assert seen.hit.all()


def direct_before_and_after(name):
    """What is seen, and its direct light before and after the change."""
    worlds = [world_of(find_animation(name)(t), 48) for t in (CHANGE - 1, CHANGE)]
    return what_is_seen(worlds[0]), *(path_traced(w, "direct") for w in worlds)


def test_the_light_goes_out_for_good():
    _, before, after = direct_before_and_after("light-switch")
    assert before.any()
    assert not after.any()
    dark = world_of(find_animation("light-switch")(CHANGE + 100), 16)
    assert not path_traced(dark, "full", bounces=2, samples=4).any()


def test_the_sun_turns_from_the_far_wall_to_the_floor():
    seen, before, after = direct_before_and_after("sunlight-turns")
    was, now = before.any(axis=1), after.any(axis=1)
    # Each patch is a hundredth of the picture, or more, and they share nothing.
    assert was.mean() > 0.01
    assert now.mean() > 0.01
    # The reveals of the window, 0.1 m thick, may be lit all the time.
    inside = seen.position[:, 0] > -1.9
    assert not (was & now & inside).any()
    y, z = seen.position[:, 1], seen.position[:, 2]
    assert (z[was & inside] < -1.99).mean() > 0.5
    assert (y[now & inside] < 0.01).mean() > 0.95


def test_the_room_is_lit_through_the_window_alone():
    scene = find_scene("sunlight-turns")
    pane = quad("pane", (-2, 0.8, 0.5), (0, 0, -1.2), (0, 1.4, 0), WHITE)
    for frame in (0, CHANGE):
        shut = find_animation("sunlight-turns", scene)(frame)
        shut = world_of(replace(shut, meshes=(*shut.meshes, pane)), 32)
        assert not path_traced(shut, "full", bounces=3, samples=16).any()
