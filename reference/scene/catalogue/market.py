"""A market at night: lights by the thousand, of which each place sees a few."""

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.lamps import lamps, numbers
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, quad

GROUND = Lambertian((0.45, 0.42, 0.4))
CLOTH = Lambertian((0.7, 0.55, 0.4))
WOOD = Lambertian((0.5, 0.36, 0.24))

STALLS = 30
"""Along each side of the square."""

STEP = 5.0
"""From stall to stall, m."""

CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = np.array(
    [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
        (1, 5, 7),
        (1, 7, 3),
    ]
)


def night_market() -> Scene:
    """A square of 150 m with 900 stalls under 30,000 small coloured lamps.

    A power-proportional choice finds a lamp of the stall at hand once in 900 times.
    """
    side = STEP * (np.arange(STALLS) - STALLS / 2 + 0.5)
    x, z = (a.ravel() for a in np.meshgrid(side, side))
    places = np.stack([x, np.zeros_like(x), z], axis=-1)
    u = numbers(30_000)
    stall = places[np.arange(30_000) % len(places)]
    hung = np.stack([2.2 * u[0] - 1.1, 1.9 + 0.4 * u[1], 1.2 * u[2] - 0.5], axis=-1)
    half = STALLS * STEP / 2
    meshes = (
        quad("ground", (-half, 0, half), (2 * half, 0, 0), (0, 0, -2 * half), GROUND),
        _boxes("counters", places, (-1.2, 0.0, 0.3), (2.4, 0.9, 0.5), WOOD),
        _boxes("back walls", places, (-1.3, 0.0, -0.9), (2.6, 2.6, 0.08), CLOTH),
        _boxes("roofs", places, (-1.4, 2.6, -0.9), (2.8, 0.06, 2.0), CLOTH),
        _boxes("crates", places, (-1.0, 0.0, -0.6), (0.5, 0.6, 0.5), WOOD),
    )
    camera = Camera(position=(0.3, 1.9, 8.9), target=(-1.2, 1.3, 0.0), fov=60.0)
    lights = lamps(stall + hung, u, 30_000.0)
    return Scene(name="night-market", camera=camera, meshes=meshes + lights)


def _boxes(
    name: str,
    places: Vec3s,
    corner: tuple[float, float, float],
    size: tuple[float, float, float],
    material: Lambertian,
) -> Mesh:
    """A box at each place."""
    vertices = places[:, None] + np.array(corner) + CORNERS * size
    faces = 8 * np.arange(len(places))[:, None, None] + FACES
    return Mesh(
        name=name,
        vertices=vertices.reshape(-1, 3),
        faces=faces.reshape(-1, 3),
        material=material,
    )
