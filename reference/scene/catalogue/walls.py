"""Open scenes under the sun: closed forms, grazing light, a glossy floor, a checker."""

import numpy as np

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.rooms import WHITE, pose
from restir_gi.reference.scene.lights import ConstantEnvironment, DirectionalLight
from restir_gi.reference.scene.materials.kinds import Coated, Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import box, quad
from restir_gi.reference.scene.textures import Checker

SUN = (10.0, 9.0, 7.5)
FLOOR_REFLECTANCE = (0.6, 0.5, 0.4)
WALL_REFLECTANCE = (0.8, 0.4, 0.2)


def sunlit_wall() -> Scene:
    """A wall in the sun lights the floor before it; the sun grazes the floor exactly.

    The wall stands at z = 0 on the floor y = 0.  Its irradiance is uniform, so that the
    light of the floor is the form factor of a rectangle.
    """
    meshes = (
        quad("floor", (-4, 0, 4), (8, 0, 0), (0, 0, -4), Lambertian(FLOOR_REFLECTANCE)),
        quad("wall", (-1, 0, 0), (2, 0, 0), (0, 2, 0), Lambertian(WALL_REFLECTANCE)),
    )
    return Scene(
        name="sunlit-wall",
        camera=Camera(position=(1.1, 2.2, 3.6), target=(0, 0.55, 0.4), fov=52.0),
        meshes=meshes,
        suns=(DirectionalLight((0.0, 0.0, -1.0), SUN),),
    )


def parallel_plates() -> Scene:
    """Sunlight from below reaches the upper plate past the lower one.

    Unit squares at y = 0 and y = 1.  The sun rises at slope 1/2, so that the shadow of
    the lower plate falls beside the upper one, which is lit evenly from below and
    lights the lower one.
    """
    slope = np.array([1.0, 0.5, 0.0]) / np.sqrt(1.25)
    lower, upper = Lambertian(FLOOR_REFLECTANCE), Lambertian(WALL_REFLECTANCE)
    meshes = (
        quad("lower plate", (-0.5, 0, 0.5), (1, 0, 0), (0, 0, -1), lower),
        quad("upper plate", (-0.5, 1, -0.5), (1, 0, 0), (0, 0, 1), upper),
    )
    direction = (float(slope[0]), float(slope[1]), 0.0)
    return Scene(
        name="parallel-plates",
        camera=Camera(position=(0.3, 0.62, 1.0), target=(0, 0.33, 0), fov=80.0),
        meshes=meshes,
        suns=(DirectionalLight(direction, SUN),),
    )


def glossy_floor() -> Scene:
    """A stool on a glossy floor before a sunlit wall.

    Shadows and reflections of thin legs: where reuse without visibility is wrong.
    """
    floor = Coated((0.3, 0.28, 0.25), alpha=0.1, ior=1.8)
    wood = Lambertian((0.5, 0.3, 0.15))
    wall = Lambertian((0.8, 0.75, 0.65))
    legs = tuple(
        box(f"leg {x} {z}", (0.06, 0.9, 0.06), pose(20, (x, 0.45, z)), wood)
        for x in (-0.35, 0.35)
        for z in (-0.3, 0.3)
    )
    meshes = (
        quad("floor", (-3, 0, 3), (6, 0, 0), (0, 0, -5), floor),
        quad("wall", (-3, 0, -2), (6, 0, 0), (0, 3, 0), wall),
        quad(
            "side wall", (-3, 0, 3), (0, 0, -5), (0, 3, 0), Lambertian((0.3, 0.4, 0.6))
        ),
        box("seat", (0.95, 0.08, 0.85), pose(20, (0, 0.94, 0)), wood),
        *legs,
    )
    return Scene(
        name="glossy-floor",
        camera=Camera(position=(1.3, 1.5, 3.2), target=(-0.1, 0.35, -0.3), fov=42.0),
        meshes=meshes,
        suns=(DirectionalLight((-0.48, -0.6, -0.64), (9.0, 8.5, 8.0)),),
    )


def grazing_light() -> Scene:
    """A long floor lit only from its far left end, at grazing angles.

    The sun passes above a screen on the right and reaches the upper half of a low wall
    on the left; the floor sees that strip near its horizon.
    """
    meshes = (
        quad("floor", (-1, 0, 3), (6, 0, 0), (0, 0, -6), WHITE),
        quad("lit wall", (-1, 0, 3), (0, 0, -6), (0, 0.8, 0), WHITE),
        quad("screen", (5, 0, -3), (0, 0, 6), (0, 0.4, 0), WHITE),
        box("block", (0.5, 0.3, 0.5), pose(30, (1.4, 0.15, -0.4)), WHITE),
        box("post", (0.12, 0.39, 0.12), pose(10, (2.2, 0.195, 0.6)), WHITE),
    )
    return Scene(
        name="grazing-light",
        camera=Camera(position=(3.6, 1.7, 1.2), target=(0.8, -0.1, -0.1), fov=52.0),
        meshes=meshes,
        suns=(DirectionalLight((-1.0, 0.0, 0.0), (30.0, 28.0, 24.0)),),
    )


def checker() -> Scene:
    """Checkered floor and blocks under an even sky."""
    tiles = Lambertian(Checker((0.8, 0.8, 0.8), (0.1, 0.15, 0.3), (6.0, 6.0)))
    stripes = Lambertian(Checker((0.9, 0.3, 0.1), (0.9, 0.8, 0.5), (2.0, 2.0)))
    meshes = (
        quad("floor", (-3, 0, 3), (6, 0, 0), (0, 0, -6), tiles),
        quad("wall", (-1.5, 0, -1.2), (3, 0, 0), (0, 1.6, 0), stripes),
        box("block", (0.7, 0.9, 0.7), pose(35, (0.4, 0.45, 0.3)), WHITE),
    )
    return Scene(
        name="checker",
        camera=Camera(position=(1.5, 1.8, 3.6), target=(0, 0.4, 0), fov=50.0),
        meshes=meshes,
        environment=ConstantEnvironment((1.0, 1.1, 1.3)),
    )
