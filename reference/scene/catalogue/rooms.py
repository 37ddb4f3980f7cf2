"""Rooms: the Cornell box, a door ajar, a hall of many lights."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.lamps import lamps, numbers
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import box, quad
from restir_gi.reference.scene.textures import Color

WHITE = Lambertian((0.73, 0.73, 0.73))
RED = Lambertian((0.63, 0.065, 0.05))
GREEN = Lambertian((0.14, 0.45, 0.091))
BLACK = Lambertian((0.0, 0.0, 0.0))


def pose(yaw_degrees: float, position: Color) -> Scalars:
    """Rigid pose: a turn about the y axis, then a move.

    Parameters
    ----------
    yaw_degrees : float; counter-clockwise seen from above (+y)
    position : (float, float, float), m; where the origin of the own frame goes

    Returns
    -------
    (4, 4) float64; own frame to world
    """
    c, s = np.cos(np.radians(yaw_degrees)), np.sin(np.radians(yaw_degrees))
    matrix = np.eye(4)
    matrix[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    matrix[:3, 3] = position
    return matrix


def cornell_box() -> Scene:
    """The Cornell box: red and green walls, two white blocks, one light.

    A room of 2 x 2 x 2 m.
    """
    meshes = (
        quad("floor", (-1, 0, 1), (2, 0, 0), (0, 0, -2), WHITE),
        quad("ceiling", (-1, 2, -1), (2, 0, 0), (0, 0, 2), WHITE),
        quad("back wall", (-1, 0, -1), (2, 0, 0), (0, 2, 0), WHITE),
        quad("left wall", (-1, 0, 1), (0, 0, -2), (0, 2, 0), RED),
        quad("right wall", (1, 0, -1), (0, 0, 2), (0, 2, 0), GREEN),
        box("tall block", (0.6, 1.2, 0.6), pose(18, (-0.35, 0.6, -0.35)), WHITE),
        box("short block", (0.6, 0.6, 0.6), pose(-17, (0.35, 0.3, 0.35)), WHITE),
        quad(
            "light",
            (-0.25, 1.99, -0.25),
            (0.5, 0, 0),
            (0, 0, 0.5),
            BLACK,
            emission=(17.0, 12.0, 4.0),
        ),
    )
    # A little aside, so that no edge of the room runs exactly through pixel centres.
    camera = Camera(position=(0.05, 1.03, 3.9), target=(0.02, 0.99, 0), fov=38.0)
    return Scene(name="cornell-box", camera=camera, meshes=meshes)


def door_ajar() -> Scene:
    """A dim room lit through the gap of a door that stands ajar.

    All light comes from the next room; only what the gap lets through reaches the
    camera's room.
    """
    wood = Lambertian((0.45, 0.25, 0.12))
    wall = Lambertian((0.75, 0.73, 0.7))
    floor = Lambertian((0.5, 0.45, 0.4))
    # The camera's room spans x in [-2, 2]; the wall at x = -2 has a doorway at
    # z in [-0.5, 0.5]; the lamp hangs in the next room, x in [-5, -2].
    meshes = (
        quad("floor", (-5, 0, 2), (7, 0, 0), (0, 0, -4), floor),
        quad("ceiling", (-5, 2.5, -2), (7, 0, 0), (0, 0, 4), wall),
        quad("north wall", (-5, 0, -2), (7, 0, 0), (0, 2.5, 0), wall),
        quad("south wall", (2, 0, 2), (-7, 0, 0), (0, 2.5, 0), wall),
        quad("east wall", (2, 0, -2), (0, 0, 4), (0, 2.5, 0), wall),
        quad("west wall", (-5, 0, 2), (0, 0, -4), (0, 2.5, 0), wall),
        box("wall by the hinge", (0.1, 2.5, 1.5), pose(0, (-2, 1.25, -1.25)), wall),
        box("wall by the handle", (0.1, 2.5, 1.5), pose(0, (-2, 1.25, 1.25)), wall),
        box("lintel", (0.1, 0.5, 1.0), pose(0, (-2, 2.25, 0)), wall),
        # Hinged at z = -0.5, opened by 15 degrees into the camera's room; it reaches
        # into floor and lintel, so that no light slips over or under it.
        box(
            "door",
            (0.05, 2.02, 1.0),
            pose(
                15,
                (
                    -2 + 0.5 * np.sin(np.radians(15)),
                    1.0,
                    -0.5 + 0.5 * np.cos(np.radians(15)),
                ),
            ),
            wood,
        ),
        box("table", (0.9, 0.06, 1.4), pose(8, (0.1, 0.75, -0.7)), wood),
        box("table leg", (0.7, 0.72, 0.08), pose(8, (0.1, 0.36, -0.7)), wood),
        box("pot", (0.3, 0.35, 0.3), pose(40, (0.1, 0.955, -0.8)), WHITE),
        quad(
            "lamp",
            (-4.99, 0.8, 0.9),
            (0, 0, -0.8),
            (0, 1.0, 0),
            BLACK,
            emission=(120.0, 110.0, 95.0),
        ),
    )
    camera = Camera(position=(1.85, 1.4, 1.6), target=(-1.0, 0.9, -0.6), fov=70.0)
    return Scene(name="door-ajar", camera=camera, meshes=meshes)


def many_lights() -> Scene:
    """A hall under 30,000 small coloured lamps.

    Each lamp is one triangle that faces down, 5 to 20 mm wide.
    """
    u = numbers(30_000)
    centre = np.stack([7.9 * u[0] - 3.95, 2.2 + 1.2 * u[1], 7.9 * u[2] - 3.95], axis=-1)
    meshes = (
        quad("floor", (-4, 0, 4), (8, 0, 0), (0, 0, -8), WHITE),
        quad("ceiling", (-4, 3.6, -4), (8, 0, 0), (0, 0, 8), WHITE),
        quad("back wall", (-4, 0, -4), (8, 0, 0), (0, 3.6, 0), WHITE),
        quad("left wall", (-4, 0, 4), (0, 0, -8), (0, 3.6, 0), RED),
        quad("right wall", (4, 0, -4), (0, 0, 8), (0, 3.6, 0), GREEN),
        box("pillar", (0.8, 2.0, 0.8), pose(30, (-1.2, 1.0, -0.5)), WHITE),
        box("bench", (1.6, 0.5, 0.6), pose(-20, (1.3, 0.25, 0.6)), WHITE),
    )
    camera = Camera(position=(0.3, 1.5, 3.8), target=(0, 0.9, 0), fov=65.0)
    return Scene(
        name="many-lights", camera=camera, meshes=meshes + lamps(centre, u, 40.0)
    )
