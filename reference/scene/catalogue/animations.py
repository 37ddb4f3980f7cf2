"""Animated scenes: how the built-in ones change from frame to frame.

Each function takes the scene of frame 0, of any size of picture, and gives the scenes
of all frames.  Motions are smooth, defined for every frame, and go there and back.
"""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.animation import (
    Animation,
    still,
    with_camera,
    with_change,
    with_shape,
)
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.rooms import WHITE, pose
from restir_gi.reference.scene.lights import DirectionalLight
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, box, emits, quad

PERIOD = 64
"""Frames until blocks and lights are back where they were."""

FLIGHT = 128
"""Frames until the camera is."""

CHANGE = 16
"""First frame after a sudden change: history has filled up by then."""

MORNING, EVENING = (2 / 3, -1 / 3, -2 / 3), (2 / 3, -2 / 3, 1 / 3)
"""Along which the sun shines into the room before and after the change: unit."""


def moving_camera(scene: Scene) -> Animation:
    """The camera flies along an arc and turns with it; the blocks uncover the walls.

    Up to 0.7 m to each side, at most 0.035 m and 0.64 degrees a frame.
    """
    x, y, z = scene.camera.position

    def camera_at(frame: int) -> Camera:
        angle = 2 * np.pi * frame / FLIGHT
        aside, ahead = np.sin(angle), 1 - np.cos(angle)
        place = x + 0.7 * aside, y + 0.15 * ahead, z - 0.4 * ahead
        return replace(scene.camera, position=place)

    return with_camera(still(scene), camera_at)


def moving_block(scene: Scene) -> Animation:
    """The short block slides past the tall one and turns about itself.

    0.7 m to the left and 0.2 m to the front in half a period, and back: at most 0.036 m
    and 3 degrees a frame.  About its axis it needs 0.425 m; from there the wall is
    never nearer than 0.65 m, and the axis of the tall block, which needs as much, 0.86
    m.
    """
    center = _center(scene, "short block")

    def move_at(frame: int) -> Scalars:
        there = 1 - np.cos(2 * np.pi * frame / PERIOD)
        way = np.array([-0.35 * there, 0.0, 0.1 * there])
        move = pose(30.0 * there, (0.0, 0.0, 0.0))
        move[:3, 3] = center + way - move[:3, :3] @ center
        return move

    return with_shape(still(scene), "short block", move_at)


def moving_light(scene: Scene) -> Animation:
    """The light travels under the ceiling, from wall to wall.

    Up to 0.6 m to each side, at most 0.059 m a frame, and 0.15 m from the walls.
    """

    def move_at(frame: int) -> Scalars:
        aside = 0.6 * np.sin(2 * np.pi * frame / PERIOD)
        return pose(0.0, (float(aside), 0.0, 0.0))

    return with_shape(still(scene), "light", move_at)


def light_switch(scene: Scene) -> Animation:
    """The only light goes out at once, and for ever.

    Black from frame ``CHANGE`` on: whatever light is left is of the past.
    """
    dark = tuple(
        replace(mesh, emission=(0.0, 0.0, 0.0)) if emits(mesh) else mesh
        for mesh in scene.meshes
    )
    after = replace(scene, meshes=dark)
    return with_change(still(scene), CHANGE, lambda _: after)


def sunlight_turns(scene: Scene) -> Animation:
    """The sun changes its direction at once, as in [Ouyang21, Fig. 11].

    Its patch leaves the far wall and lies on the floor from frame ``CHANGE`` on.
    """
    after = replace(scene, suns=(replace(scene.suns[0], direction=EVENING),))
    return with_change(still(scene), CHANGE, lambda _: after)


def sunlit_room() -> Scene:
    """A room that the sun lights through a window, and nothing else.

    4 x 4 m and 2.5 m high; the window, 1 x 1.2 m, is in the wall on the left.
    """
    wall, floor = Lambertian((0.75, 0.73, 0.7)), Lambertian((0.5, 0.45, 0.4))
    wood = Lambertian((0.45, 0.25, 0.12))

    def of_west_wall(name: str, y: tuple[float, float], z: tuple[float, float]) -> Mesh:
        size = (0.1, y[1] - y[0], z[1] - z[0])
        return box(name, size, pose(0, (-2.0, sum(y) / 2, sum(z) / 2)), wall)

    meshes = (
        quad("floor", (-2, 0, 2), (4, 0, 0), (0, 0, -4), floor),
        quad("ceiling", (-2, 2.5, -2), (4, 0, 0), (0, 0, 4), wall),
        quad("north wall", (-2, 0, -2), (4, 0, 0), (0, 2.5, 0), wall),
        quad("south wall", (2, 0, 2), (-4, 0, 0), (0, 2.5, 0), wall),
        quad("east wall", (2, 0, -2), (0, 0, 4), (0, 2.5, 0), wall),
        # The parts about the window reach into each other and past the room's edges,
        # so that no light slips through their joints.
        of_west_wall("wall beyond the window", (-0.1, 2.6), (-2.1, -0.6)),
        of_west_wall("wall before the window", (-0.1, 2.6), (0.4, 2.1)),
        of_west_wall("sill", (-0.1, 0.9), (-0.7, 0.5)),
        of_west_wall("lintel", (2.1, 2.6), (-0.7, 0.5)),
        box("table", (0.9, 0.06, 1.2), pose(12, (0.5, 0.7, -1.1)), wood),
        box("table leg", (0.7, 0.67, 0.08), pose(12, (0.5, 0.335, -1.1)), wood),
        box("chest", (0.5, 0.5, 0.8), pose(-8, (-1.4, 0.25, -1.3)), WHITE),
    )
    return Scene(
        name="sunlight-turns",
        camera=Camera(position=(1.8, 1.5, 1.7), target=(-0.7, 0.8, -0.6), fov=70.0),
        meshes=meshes,
        suns=(DirectionalLight(MORNING, (40.0, 36.0, 30.0)),),
    )


def _center(scene: Scene, name: str) -> Scalars:
    (mesh,) = (mesh for mesh in scene.meshes if mesh.name == name)
    center: Scalars = mesh.pose[:3, 3]
    return center
