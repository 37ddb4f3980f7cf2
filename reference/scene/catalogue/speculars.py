"""Rooms whose floors scatter into single directions: coated, a mirror, glass."""

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.rooms import BLACK, GREEN, RED, WHITE, pose
from restir_gi.reference.scene.lights import PointLight
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Dielectric,
    Lambertian,
    Material,
    mirror,
)
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, box, quad
from restir_gi.reference.scene.textures import Checker


def specular_floor() -> Scene:
    """A polished dark floor that mirrors a ceiling, which only the floor lights.

    A shaded lamp hangs low: it lights a spot of the floor and nothing else.  What the
    floor mirrors has been to that spot before, which few paths find.
    """
    floor = Coated((0.12, 0.1, 0.08), alpha=0.0, ior=1.5)
    meshes = (
        quad("floor", (-3, 0, 2), (6, 0, 0), (0, 0, -6), floor),
        *_room(3.0, 2.0, -4.0, 2.6),
        # A black box without bottom; the lamp in it is a point, which no floor shows.
        quad("shade, top", (0.5, 0.75, -1.5), (0, 0, 0.5), (0.5, 0, 0), BLACK),
        quad("shade, front", (0.5, 0.25, -1.0), (0.5, 0, 0), (0, 0.5, 0), BLACK),
        quad("shade, back", (0.5, 0.25, -1.5), (0, 0.5, 0), (0.5, 0, 0), BLACK),
        quad("shade, left", (0.5, 0.25, -1.5), (0, 0, 0.5), (0, 0.5, 0), BLACK),
        quad("shade, right", (1.0, 0.25, -1.5), (0, 0.5, 0), (0, 0, 0.5), BLACK),
        box("column", (0.35, 1.5, 0.35), pose(25, (-1.1, 0.75, -2.2)), WHITE),
    )
    camera = Camera(position=(-0.15, 0.85, 1.9), target=(0.02, 0.02, -0.7), fov=46.0)
    lamp = PointLight((0.75, 0.65, -1.25), (90.0, 78.0, 60.0))
    return Scene(name="specular-floor", camera=camera, meshes=meshes, points=(lamp,))


def mirror_floor() -> Scene:
    """A room on a mirror.

    Rays hit the lamp by way of the floor too, where light sampling finds nothing.
    """
    return _on(mirror((0.9, 0.9, 0.92)), "mirror-floor")


def glass_floor() -> Scene:
    """A room on a pane of glass over a diffuse ground.

    All light that reaches the ground, or comes from it, is refracted twice.
    """
    # Into the walls: rims that lie in them would let light out of the room.
    pane = box("pane", (6.4, 0.12, 6.4), pose(0, (0, -0.06, -1)), Dielectric(1.5))
    checker = Lambertian(Checker((0.7, 0.58, 0.35), (0.35, 0.42, 0.5), scale=(6, 6)))
    ground = quad("ground", (-3, -0.5, 2), (6, 0, 0), (0, 0, -6), checker)
    return _furnished("glass-floor", (pane, ground), bottom=-0.5)


def _on(floor: Material, name: str) -> Scene:
    ground = quad("floor", (-3, 0, 2), (6, 0, 0), (0, 0, -6), floor)
    return _furnished(name, (ground,), bottom=0.0)


def _furnished(name: str, floor: tuple[Mesh, ...], bottom: float) -> Scene:
    meshes = (
        *floor,
        *_room(3.0, 2.0, -4.0, 2.6, bottom),
        box("tall block", (0.6, 1.3, 0.6), pose(20, (-0.8, 0.66, -1.7)), WHITE),
        box("short block", (0.7, 0.5, 0.7), pose(-15, (0.8, 0.26, -0.8)), WHITE),
        quad(
            "lamp",
            (-0.5, 2.59, -1.5),
            (1.0, 0, 0),
            (0, 0, 1.0),
            BLACK,
            emission=(12.0, 10.0, 7.0),
        ),
    )
    camera = Camera(position=(0.1, 1.3, 1.95), target=(0.03, 0.5, -1.2), fov=64.0)
    return Scene(name=name, camera=camera, meshes=meshes)


def _room(
    half: float, front: float, back: float, height: float, bottom: float = 0.0
) -> tuple[Mesh, ...]:
    """Ceiling and four walls, closed, around a floor of whatever kind."""
    wide, deep, tall = 2 * half, front - back, height - bottom
    return (
        quad("ceiling", (-half, height, back), (wide, 0, 0), (0, 0, deep), WHITE),
        quad("back wall", (-half, bottom, back), (wide, 0, 0), (0, tall, 0), WHITE),
        quad("front wall", (-half, bottom, front), (0, tall, 0), (wide, 0, 0), WHITE),
        quad("left wall", (-half, bottom, front), (0, 0, -deep), (0, tall, 0), RED),
        quad("right wall", (half, bottom, back), (0, 0, deep), (0, tall, 0), GREEN),
    )
