"""The built-in animations: rigid, and clear of each other; frames that are refused.

Evidence: properties.  Coordinates are at most 4 m and made of fewer than 40 operations,
40 · 4 · 2⁻⁵³ < 1e-13.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.scene.animation import (
    Animation,
    still,
    with_camera,
    with_shape,
)
from restir_gi.reference.scene.catalogue.animations import CHANGE, FLIGHT, PERIOD
from restir_gi.reference.scene.catalogue.registry import (
    CATALOGUE,
    find_animation,
    find_scene,
)
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.motion import motion_between
from restir_gi.reference.scene.shapes import Sphere
from restir_gi.reference.scene.validation import validate, validate_frames
from restir_gi.reference.system.errors import UsageError

ROUNDING = 1e-13
ANIMATED = [name for name, entry in CATALOGUE.items() if entry.animate]
MOVING = {"moving-block": "short block", "moving-light": "light"}
"""The shape that moves."""
STATED = {"moving-block": (0.036, 3.0), "moving-light": (0.059, 0.0)}
"""Its speed in the docstring: metres and degrees a frame."""

every_animation = pytest.mark.parametrize("name", ANIMATED)
every_motion = pytest.mark.parametrize("name", MOVING)


def shape_of(scene, name):
    (mesh,) = (mesh for mesh in scene.meshes if mesh.name == name)
    return mesh


def poses_of(name, frames):
    animation = find_animation(name)
    return np.array([shape_of(animation(t), MOVING[name]).pose for t in range(frames)])


def angles_between(a, b):
    """Degrees between unit vectors, or of the rotation from one matrix to another."""
    if a.ndim == 3:
        cosine = (np.einsum("tij,tij->t", a, b) - 1) / 2
    else:
        cosine = np.einsum("ti,ti->t", a, b)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


# ---------------------------------------------------------------- all of them


def test_five_are_animated():
    assert len(ANIMATED) == 5


@every_animation
def test_frame_0_is_the_scene_of_the_catalogue(name):
    scene = find_scene(name)
    frame = find_animation(name, scene)(0)
    assert frame.camera == scene.camera
    assert frame.suns == scene.suns
    for a, b in zip(frame.meshes, scene.meshes, strict=True):
        assert_array_equal(a.pose, b.pose)
        assert a.vertices is b.vertices
        assert a.emission == b.emission


@every_animation
def test_every_frame_can_be_rendered_and_moves_rigidly(name):
    """`validate_frames` checks motion, too; the camera touches nothing."""
    animation = find_animation(name)
    valid = validate_frames(animation)
    for frame in (*range(FLIGHT + 1), 10**6, 2**28):
        valid(frame)


@every_animation
def test_all_frames_have_the_size_of_the_picture(name):
    scene = find_scene(name)
    small = replace(scene, camera=replace(scene.camera, width=12, height=8))
    animation = find_animation(name, small)
    sizes = {
        (animation(t).camera.width, animation(t).camera.height) for t in (0, 7, 99)
    }
    assert sizes == {(12, 8)}


@every_animation
def test_what_does_not_move_is_the_same_object(name):
    animation = find_animation(name)
    for before, after in pairwise(map(animation, range(PERIOD))):
        changed = {
            a.name
            for a, b in zip(before.meshes, after.meshes, strict=True)
            if a is not b
        }
        switched = after is animation(CHANGE) and before is not after
        expected = {MOVING.get(name)} - {None}
        if name == "light-switch" and switched:
            expected = {"light"}
        assert changed == expected
        if name in ("light-switch", "sunlight-turns"):
            assert (before is after) != switched


@every_animation
def test_it_says_what_changes(name):
    expected = "camera" if name == "moving-camera" else "scene"
    assert find_animation(name).changes == expected
    assert find_animation("cornell-box").changes == "nothing"


def test_an_unknown_animation_is_an_unknown_scene():
    with pytest.raises(UsageError, match="did you mean moving-block"):
        find_animation("moving-blocks", find_scene("moving-block"))


# ---------------------------------------------------------------- motion


@every_motion
def test_shapes_come_back_and_are_no_faster_than_is_said(name):
    found = poses_of(name, PERIOD + 1)
    assert_allclose(found[PERIOD], found[0], atol=ROUNDING)
    speed, turn = STATED[name]
    fastest = np.linalg.norm(np.diff(found[:, :3, 3], axis=0), axis=1).max()
    assert 0.9 * speed < fastest <= speed
    rotation = found[:, :3, :3]
    # The arc cosine of 1 - 2⁻⁵² is 1e-6 degrees.
    assert angles_between(rotation[1:], rotation[:-1]).max() <= turn + 1e-5


def gap(a, b):
    """Largest distance by which a face of one convex shape parts it from the other.

    Negative where no face does.
    """
    found = []
    for corners in (a, b):
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        p, q = (c.reshape(-1, 3) @ normal.T for c in (a, b))
        found += [*(q.min(axis=0) - p.max(axis=0)), *(p.min(axis=0) - q.max(axis=0))]
    return float(max(found))


def least_gaps(animation, name):
    """Gap between a shape and each other, over a period."""
    scenes = [animation(t) for t in range(PERIOD + 1)]
    return {
        other.name: min(
            gap(
                world_corners(shape_of(s, name)), world_corners(shape_of(s, other.name))
            )
            for s in scenes
        )
        for other in scenes[0].meshes
        if other.name != name
    }


def test_the_block_stands_on_the_floor_and_touches_nothing_else():
    gaps = least_gaps(find_animation("moving-block"), "short block")
    assert abs(gaps.pop("floor")) < ROUNDING
    assert min(gaps.values()) > 0.1


def test_the_light_touches_nothing():
    gaps = least_gaps(find_animation("moving-light"), "light")
    assert gaps.pop("ceiling") > 0.009  # It hangs a centimetre below.
    assert min(gaps.values()) > 0.14


def test_control_a_block_that_goes_too_far_is_noticed():
    animation = with_shape(
        still(find_scene("moving-block")),
        "short block",
        lambda t: pose(0.0, (-0.7 * t / PERIOD, 0.0, -0.5 * t / PERIOD)),
    )
    gaps = least_gaps(animation, "short block")
    assert gaps["tall block"] < 0
    assert gaps["light"] > 0


# ---------------------------------------------------------------- camera


def test_the_camera_flies_before_the_open_side_and_no_faster_than_is_said():
    animation = find_animation("moving-camera")
    cameras = [animation(t).camera for t in range(FLIGHT + 1)]
    x = np.array([camera.position for camera in cameras])
    assert_allclose(x[-1], x[0], atol=ROUNDING)
    assert (np.abs(x[:, 0]) < 0.8).all()
    assert ((x[:, 1] > 0.9) & (x[:, 1] < 1.4)).all()
    assert ((x[:, 2] > 2) & (x[:, 2] < 4)).all()
    fastest = np.linalg.norm(np.diff(x, axis=0), axis=1).max()
    assert 0.034 < fastest <= 0.035
    forward = np.array([camera.axes[2] for camera in cameras])
    assert 0.6 < angles_between(forward[1:], forward[:-1]).max() <= 0.64


# ---------------------------------------------------------------- frames refused


def small_room():
    scene = find_scene("cornell-box")
    return replace(scene, camera=replace(scene.camera, width=8, height=8))


def changed_at(frame, change):
    scene = small_room()
    after = change(scene)
    return Animation(lambda t: after if t >= frame else scene, "scene")


def resized(scene):
    return replace(scene, camera=replace(scene.camera, width=9))


def glowing_less_than_not(scene):
    *others, light = scene.meshes
    return replace(scene, meshes=(*others, replace(light, emission=(-1.0, 0.0, 0.0))))


def flattened(scene):
    floor, *others = scene.meshes
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 1, 1]])
    return replace(scene, meshes=(replace(floor, faces=faces), *others))


def behind_the_wall(scene):
    block = scene.meshes[5]
    inside = tuple(block.pose[:3, 3])
    return replace(scene, camera=replace(scene.camera, position=inside))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (resized, "its image is 9x8 pixels; use 8x8, as in frame 0"),
        (glowing_less_than_not, "emission"),
        (flattened, "validate the scene before it is animated"),
        (behind_the_wall, 'it is inside mesh "tall block"'),
        (lambda s: replace(s, meshes=s.meshes[1:]), "same shapes"),
    ],
)
def test_a_frame_that_cannot_be_rendered_is_named(change, says):
    valid = validate_frames(changed_at(3, change))
    for frame in range(3):
        valid(frame)
    with pytest.raises(UsageError) as error:
        valid(3)
    message = str(error.value)
    assert message.startswith("frame 3 of cornell-box: ")
    assert says in message
    assert len(message.splitlines()) == 1


def test_lights_may_go_out_but_not_before_frame_1():
    def dark(scene):
        *others, light = scene.meshes
        return replace(scene, meshes=(*others, replace(light, emission=(0.0,) * 3)))

    validate_frames(changed_at(1, dark))(1)
    with pytest.raises(UsageError, match=r"frame 0 of .* nothing in the scene emits"):
        validate_frames(changed_at(0, dark))(0)
    with pytest.raises(UsageError, match="nothing in the scene emits"):
        validate(dark(small_room()))


def test_a_scene_that_stays_is_validated_once(monkeypatch):
    seen = []

    def counted(scene, may_be_dark=False):
        seen.append(scene)
        return validate(scene, may_be_dark)

    monkeypatch.setattr("restir_gi.reference.scene.validation.validate", counted)
    animation = changed_at(3, lambda scene: replace(scene, name="later"))
    valid = validate_frames(animation)
    for frame in range(6):
        assert valid(frame) is animation(frame)
    assert [scene.name for scene in seen] == ["cornell-box", "later"]
    scene = small_room()
    assert validate_frames(still(scene))(7) is scene
    assert len(seen) == 2


def test_validated_frames_keep_what_did_not_move():
    """The identity of vertices and faces tells that a mesh is the one of before."""
    scene = small_room()
    ball = Sphere(name="ball", center=(0.3, 0.9, 0.4), radius=0.2,
                  material=scene.meshes[0].material)  # fmt: skip
    scene = validate(flattened(replace(scene, spheres=(ball,))))
    assert scene.notes
    moves = with_shape(still(scene), "ball", lambda t: pose(0.0, (0.0, 0.01 * t, 0.0)))
    valid = validate_frames(with_camera(moves, lambda t: scene.camera))
    a, b = valid(1), valid(2)
    assert all(x is y for x, y in zip(a.meshes, b.meshes, strict=True))
    motion = motion_between(a, b)
    assert list(np.flatnonzero(motion.moves)) == [len(scene.meshes)]
