"""Animations, motion between frames, and reprojection.

Evidence: properties.  Tolerances are roundings of float64: poses and points here are
of order 1 to 10 m, and a carried point has fewer than 40 operations, 40 · 10 · 2⁻⁵³ <
1e-13.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.options.reprojection import motion_vectors, reproject
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.animation import still, with_change, with_shape
from restir_gi.reference.scene.camera import (
    Camera,
    camera_rays,
    image_points,
    pixel_centers,
)
from restir_gi.reference.scene.catalogue.rooms import cornell_box, pose
from restir_gi.reference.scene.motion import carry, motion_between, turn
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import build_world

ROUNDING = 1e-13
SIZE = 24

angles = st.floats(-180, 180)
places = st.tuples(*[st.floats(-5, 5)] * 3)


def small(scene):
    return replace(scene, camera=replace(scene.camera, width=SIZE, height=SIZE))


def seen(scene):
    world = build_world(scene)
    return world, visible_points(world, *pixel_centers(SIZE, SIZE))


def looking_from(x):
    return Camera(position=(x, 1.03, 3.9), target=(0.02, 0.99, 0), fov=38.0,
                  width=SIZE, height=SIZE)  # fmt: skip


# ---------------------------------------------------------------- animations


def test_what_does_not_move_is_the_same_object():
    scene = small(cornell_box())
    animation = with_shape(
        still(scene), "tall block", lambda t: pose(2.0 * t, (0, 0, 0))
    )
    a, b = animation(3), animation(4)
    same = [x is y for x, y in zip(a.meshes, b.meshes, strict=True)]
    names = [m.name for m in a.meshes]
    assert [n for n, s in zip(names, same, strict=True) if not s] == ["tall block"]
    assert still(scene)(7) is scene


def test_a_change_begins_with_its_frame():
    scene = small(cornell_box())
    dark = replace(scene, meshes=scene.meshes[:-1])
    animation = with_change(still(scene), 5, lambda _: dark)
    assert animation(4) is scene
    assert animation(5) is dark


@pytest.mark.parametrize(
    "move", [np.diag([2.0, 1, 1, 1]), np.diag([-1.0, 1, 1, 1]), np.zeros((4, 4))]
)
def test_only_rigid_motion_is_accepted(move):
    animation = with_shape(still(cornell_box()), "tall block", lambda t: move)
    with pytest.raises(
        UsageError, match='motion of "tall block" in frame 2 is not rigid'
    ):
        animation(2)


def test_an_unknown_shape_is_named():
    animation = with_shape(still(cornell_box()), "chair", lambda t: np.eye(4))
    with pytest.raises(UsageError, match='no shape is called "chair"'):
        animation(0)


def test_frames_with_other_shapes_are_refused():
    scene = cornell_box()
    with pytest.raises(UsageError, match="same shapes in the same order"):
        motion_between(scene, replace(scene, meshes=scene.meshes[1:]))


# ---------------------------------------------------------------- motion


def test_a_scene_that_stays_has_no_motion():
    scene = cornell_box()
    assert motion_between(scene, scene) is None
    assert motion_between(scene, replace(scene, camera=looking_from(1.0))) is None


@settings(max_examples=40, deadline=None)
@given(angles, places, angles, places)
def test_points_go_with_their_shape_and_come_back(yaw, place, yaw_to, place_to):
    scene = cornell_box()
    animation = with_shape(
        still(scene),
        "tall block",
        lambda t: pose([yaw, yaw_to][t], [place, place_to][t]),
    )
    before, after = animation(0), animation(1)
    motion = motion_between(before, after)
    index = [m.name for m in scene.meshes].index("tall block")
    mesh = scene.meshes[index].vertices
    shape = np.full(len(mesh), index)

    def world_vertices(scene):
        turned = scene.meshes[index].pose
        return mesh @ turned[:3, :3].T + turned[:3, 3]

    if motion is None:
        assert_array_equal(world_vertices(before), world_vertices(after))
        return
    moved = carry(motion, shape, world_vertices(before))
    assert_allclose(moved, world_vertices(after), atol=ROUNDING)
    assert_allclose(
        carry(motion.reversed, shape, moved), world_vertices(before), atol=ROUNDING
    )
    # Other shapes stay, to the last bit; directions keep their length and their angles.
    others = np.full(len(mesh), (index + 1) % len(scene.meshes))
    assert_array_equal(carry(motion, others, mesh), mesh)
    turned = turn(motion, shape, mesh)
    assert_allclose(turned @ turned.T, mesh @ mesh.T, atol=ROUNDING)


# ---------------------------------------------------------------- reprojection


@given(st.floats(-2, 2), st.floats(20, 100), st.booleans())
def test_projection_inverts_the_rays_of_the_camera(x_eye, fov, mirrored):
    camera = replace(looking_from(x_eye), fov=fov, mirrored=mirrored, height=17)
    x, y = pixel_centers(SIZE, 17)
    origin, direction = camera_rays(camera, x, y)
    there = image_points(camera, origin + 3.0 * direction)
    # Pixels are 24 of the unit of the rounding.
    assert_allclose(there, (x, y), atol=24 * ROUNDING)
    behind = image_points(camera, origin - direction)
    assert np.isnan(behind).all()


def test_a_still_scene_finds_itself():
    scene = small(cornell_box())
    world, visible = seen(scene)
    row = reproject(world, visible, world, visible, None, UNBIASED)
    hit = visible.surface.hit
    assert_array_equal(row[hit], np.flatnonzero(hit))
    assert (row[~hit] == NONE).all()
    for v in motion_vectors(world, world, visible, None):
        assert_array_equal(v[hit], 0.0)
        assert np.isnan(v[~hit]).all()


def test_a_moving_camera_finds_the_same_place_again():
    scene = small(cornell_box())
    before, seen_before = seen(replace(scene, camera=looking_from(0.05)))
    world, visible = seen(replace(scene, camera=looking_from(0.65)))
    row = reproject(before, seen_before, world, visible, None, UNBIASED)
    found = row != NONE
    assert 0.5 < found[visible.surface.hit].mean() < 1
    here = visible.surface.position[found]
    there = seen_before.surface.position[row[found]]
    # A pixel is 0.11 m wide at the far wall; slanting walls spread it to 0.5 m.
    assert np.linalg.norm(here - there, axis=1).max() < 0.5
    assert np.median(np.linalg.norm(here - there, axis=1)) < 0.06
    # Control: without reprojection most pixels see another place.
    unmoved = np.linalg.norm(
        visible.surface.position - seen_before.surface.position, axis=1
    )
    assert np.median(unmoved[visible.surface.hit]) > 0.06


def moved_block():
    """Two frames between which the tall block moves, and who was seen where before."""
    scene = small(cornell_box())
    animation = with_shape(
        still(scene), "tall block", lambda t: pose(0.0, (0.3 * t, 0.0, 0.0))
    )
    frames = animation(0), animation(1)
    before, seen_before = seen(frames[0])
    world, visible = seen(frames[1])
    back = motion_between(*reversed(frames))
    row = reproject(before, seen_before, world, visible, back, UNBIASED)
    return scene, (before, seen_before), (world, visible), back, row


def test_a_moving_shape_is_followed():
    scene, (before, seen_before), (world, visible), back, row = moved_block()
    block = [m.name for m in scene.meshes].index("tall block")
    shape = world.geometry.shape[visible.surface.primitive]
    on_block = visible.surface.hit & (shape == block) & (row != NONE)
    assert on_block.sum() > 20
    was = before.geometry.shape[seen_before.surface.primitive[row[on_block]]]
    assert (was == block).mean() > 0.9
    dx, dy = motion_vectors(before, world, visible, back)
    assert (dx[on_block] > 1).all()
    assert np.abs(dy[on_block]).max() < 0.5
    still_there = visible.surface.hit & (shape != block)
    assert_array_equal(dx[still_there], 0.0)


def test_what_was_hidden_begins_anew():
    scene, (before, seen_before), (world, visible), _, row = moved_block()
    names = [m.name for m in scene.meshes]
    now = world.geometry.shape[visible.surface.primitive]
    was = before.geometry.shape[seen_before.surface.primitive]
    uncovered = visible.surface.hit & (now == names.index("back wall"))
    uncovered &= was == names.index("tall block")
    assert uncovered.sum() > 5
    assert (row[uncovered] == NONE).all()
