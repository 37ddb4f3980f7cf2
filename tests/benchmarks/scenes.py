"""Scenes of the benchmarks."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.scene.catalogue.rooms import cornell_box
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh


def sized(scene: Scene, width: int, height: int) -> Scene:
    camera = replace(scene.camera, width=width, height=height)
    return replace(scene, camera=camera)


def bumpy_box() -> Scene:
    """The Cornell box with its tall block replaced by a sphere of 328,000 triangles."""
    scene = cornell_box()
    steps_u, steps_v = 574, 287
    u, v = np.meshgrid(np.arange(steps_u), np.arange(steps_v), indexing="ij")
    phi, theta = 2 * np.pi * u / steps_u, np.pi * (v + 0.5) / steps_v
    radius = 0.55 * (1 + 0.05 * np.sin(9 * phi) * np.sin(7 * theta))
    vertices = np.stack(
        [
            radius * np.sin(theta) * np.cos(phi),
            radius * np.cos(theta) + 0.75,
            radius * np.sin(theta) * np.sin(phi),
        ],
        axis=-1,
    ).reshape(-1, 3)
    a = (u[:, :-1] * steps_v + v[:, :-1]).ravel()
    b = (((u[:, :-1] + 1) % steps_u) * steps_v + v[:, :-1]).ravel()
    faces = np.concatenate(
        [np.stack([a, b, b + 1], axis=-1), np.stack([a, b + 1, a + 1], axis=-1)]
    )
    ball = Mesh(
        name="ball",
        vertices=vertices,
        faces=faces,
        material=Lambertian((0.7, 0.7, 0.7)),
    )
    kept = tuple(m for m in scene.meshes if "block" not in m.name)
    return replace(scene, name="bumpy-box", meshes=(*kept, ball))
