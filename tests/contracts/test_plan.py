"""Only what a scene requires is run: and pictures are the same to the last bit.

Control: what a scene does require, left out, changes its pictures.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods import method_names
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.effects import (
    ALL,
    effects,
    left_out,
    planner_of,
    prepared_for_all,
)
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import still
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.registry import CATALOGUE, find_scene
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    PointLight,
)
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    mirror,
)
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.scene.plan import EVERYTHING, parts, plan_of
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Sphere, box, quad
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import build_world


def frames(named, bounces, plan, count=3):
    """Colours of the first frames, with a plan for all of them."""
    animation = frames_of(named, find_scene_or_file(named.name))
    if plan.motion:
        animation = prepared_for_all(animation)
    world = build_world(animation(0), planner=lambda scene: plan)
    made = render_frames(world, UNBIASED, bounces, 0, Schedule(), animation)
    return [next(made).color for _ in range(count)]


# ------------------------------------------------------------ built-in scenes


def no_tick(done, total):
    """Tell nobody."""


@pytest.mark.parametrize("name", CATALOGUE)
def test_what_is_left_out_of_a_built_in_scene_changes_nothing(name):
    """Each part by itself, and all of them."""
    named = Named(name, False, 16, 16)
    animation = frames_of(named, find_scene_or_file(name))
    found = effects(animation, 2, 3, no_tick)
    wanted = left_out(animation)
    assert [e.part for e in found] == [*wanted, *([ALL] if len(wanted) > 1 else [])]
    for effect in found:
        assert effect.identical, effect
        assert (effect.largest, effect.deviation) == (0.0, 0.0)


REQUIRED = {
    "occlusion": "cornell-box",
    "chance": "cornell-box",
    "glossy": "glossy-floor",
    "delta": "specular-floor",
}


@pytest.mark.parametrize("part", REQUIRED)
def test_control_what_is_required_is_missed(part):
    """Of the first three frames at least one pixel is another."""
    named = Named(REQUIRED[part], False, 32, 32)
    whole = frames(named, 2, EVERYTHING)
    without = frames(named, 2, replace(EVERYTHING, **{part: False}))
    assert any(not np.array_equal(a, b) for a, b in zip(whole, without, strict=True))


def test_motion_is_left_out_only_where_nothing_moves():
    moving = frames_of(Named("moving-camera", False, 8, 8), find_scene("moving-camera"))
    assert "motion" not in left_out(moving)
    assert "motion" in left_out(still(moving(0)))


# Validation is asked for by --no-plan: where it takes place nothing new is drawn.
UNVALIDATED = {"restir-gi-biased": ("--set", "validate_every=0")}


@pytest.mark.parametrize("name", method_names())
def test_every_method_makes_the_same_picture(name, tmp_path, capsys):
    """With and without a plan, of a scene that leaves out four parts of five."""
    pictures = []
    for words in ((), ("--no-plan",)):
        out = tmp_path / f"{len(words)}.exr"
        about = ["--size", "16x16", "--bounces", "2", "--out", str(out)]
        about += [*words, *UNVALIDATED.get(name, ())]
        about += ["--spp", "4"] if name == "path" else ["--frames", "4"]
        assert main(["render", "sunlit-wall", "--method", name, *about]) == 0
        pictures.append(read_exr(out).color)
    capsys.readouterr()
    assert pictures[0].any()
    assert np.array_equal(*pictures)


# ------------------------------------------------------------ scenes by chance

WALLS = {
    "floor": ((-1, 0, 1), (2, 0, 0), (0, 0, -2)),
    "ceiling": ((-1, 2, -1), (2, 0, 0), (0, 0, 2)),
    "back": ((-1, 0, -1), (2, 0, 0), (0, 2, 0)),
    "left": ((-1, 0, 1), (0, 0, -2), (0, 2, 0)),
    "right": ((1, 0, -1), (0, 0, 2), (0, 2, 0)),
}
GREY = Lambertian((0.6, 0.5, 0.4))
PLACE = pose(20, (0, 0.3, 0))
MATERIALS = (
    GREY,
    Lambertian((0.5, 0.5, 0.5), two_sided=False),
    Conductor((0.8, 0.7, 0.6), alpha=0.2),
    mirror((0.9, 0.9, 0.9)),
    Coated((0.3, 0.5, 0.6), alpha=0.1),
    Coated((0.3, 0.5, 0.6), alpha=0.0),
    Dielectric(1.5),
)


@st.composite
def scenes(draw):
    """Some walls of a room, of any material, things in it, and any lights."""
    material = st.sampled_from(MATERIALS)
    names = draw(st.sets(st.sampled_from(sorted(WALLS)), min_size=1))
    meshes = [quad(name, *WALLS[name], draw(material)) for name in sorted(names)]
    if draw(st.booleans()):
        meshes.append(box("block", (0.6, 0.6, 0.6), PLACE, draw(material)))
    spheres = []
    if draw(st.booleans()):
        spheres.append(
            Sphere(
                name="ball",
                center=(0.4, 0.5, 0.3),
                radius=0.25,
                material=draw(material),
            )
        )
    if draw(st.booleans()):
        lamp = quad("lamp", (-0.2, 1.9, -0.2), (0.4, 0, 0), (0, 0, 0.4), GREY)
        meshes.append(replace(lamp, emission=(5.0, 4.0, 3.0)))
    place = draw(st.sampled_from([(0.0, 1.5, 0.0), (0.0, 4.0, 0.0)]))
    sky = ConstantEnvironment((0.2, 0.3, 0.4))
    points = (PointLight(place, (2.0, 2.0, 2.0)),) if draw(st.booleans()) else ()
    sun = DirectionalLight((0.36, -0.8, -0.48), (1.0, 0.9, 0.8))
    return validate(
        Scene(
            name="by chance",
            camera=Camera(
                position=(0, 1, 3.5), target=(0, 0.8, 0), width=12, height=12
            ),
            meshes=tuple(meshes),
            spheres=tuple(spheres),
            points=points,
            suns=(sun,) if draw(st.booleans()) or not points else (),
            environment=sky if draw(st.booleans()) else None,
        )
    )


@settings(max_examples=40)
@given(scenes(), st.integers(1, 3))
def test_plan_and_no_plan_agree(scene, bounces):
    """Whatever the scene is made of, to the last bit, in each of three frames."""
    pictures = []
    for everywhere in (False, True):
        animation = still(scene)
        if everywhere:
            animation = prepared_for_all(animation)
        world = build_world(scene, planner=planner_of(everywhere))
        made = render_frames(world, UNBIASED, bounces, 1, Schedule(), animation)
        pictures.append([next(made).color for _ in range(3)])
    for a, b in zip(*pictures, strict=True):
        assert np.array_equal(a, b)


def test_a_point_light_outside_a_convex_room_is_hidden_by_it():
    room = Scene(
        name="room",
        camera=Camera(position=(0, 1, 3.5), target=(0, 0.8, 0)),
        meshes=tuple(quad(n, *WALLS[n], GREY) for n in ("floor", "ceiling")),
        points=(PointLight((0, 1, 0), (1.0, 1.0, 1.0)),),
    )
    assert not plan_of(room).occlusion
    outside = replace(room, points=(PointLight((0, 3, 0), (1.0, 1.0, 1.0)),))
    assert plan_of(outside).occlusion
    ball = Sphere(name="ball", center=(0, 0, 0), radius=1.0, material=GREY, inward=True)
    inside = replace(room, meshes=(), spheres=(ball,))
    assert plan_of(inside).occlusion  # the light is on the sphere
    assert not plan_of(
        replace(inside, points=(PointLight((0, 0.5, 0), (1.0, 1.0, 1.0)),))
    ).occlusion


# ------------------------------------------------------------ the command


def test_the_command_says_what_and_why(capsys):
    assert main(["plan", "sunlit-wall", "--frames", "2", "--size", "16x16"]) == 0
    printed, told = capsys.readouterr()
    assert told == ""
    for words in ("occlusion between points", "left out", "convex", "the same to the"):
        assert words in printed


def test_the_command_for_programs(capsys):
    words = ["plan", "moving-light", "--frames", "2", "--size", "16x16", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    by_name = {feature["name"]: feature for feature in found["features"]}
    for name in ("motion", "validation", "occlusion between points", "Jacobians"):
        assert not by_name[name]["left_out"]
    assert by_name["several bounces"]["left_out"]
    assert [e["part"] for e in found["left_out"]] == ["glossy", "delta", ALL]
    assert all(e["identical"] for e in found["left_out"])


def test_parts_are_those_of_the_plan():
    assert parts() == ["occlusion", "chance", "glossy", "delta", "motion"]
    assert all(getattr(EVERYTHING, part) for part in parts())
