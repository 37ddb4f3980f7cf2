"""Frames of paths in small scenes, as the production code draws them."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.shifting import Criterion, Paths
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream, Uniforms
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Material,
    mirror,
)
from restir_gi.reference.scene.shapes import Mesh
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import World, build_world

BLOCKS: dict[str, Material | None] = {
    "paint": None,
    "rough-metal": Conductor((0.9, 0.8, 0.6), alpha=0.1),
    "glossy-metal": Conductor((0.9, 0.8, 0.6), alpha=0.02),
    "mirror": mirror((0.9, 0.9, 0.9)),
    "rough-coat": Coated((0.5, 0.3, 0.2), alpha=0.3),
    "smooth-coat": Coated((0.5, 0.3, 0.2), alpha=0.0),
    "glass": Dielectric(1.5),
    "bright": mirror((0.9, 0.9, 0.9)),
    "glazed": Coated((0.5, 0.3, 0.2), alpha=0.0, ior=3.0),
}
"""Materials of both blocks of a Cornell box.

In the bright box the ceiling shines, so that rays often hit an emitter; in the glazed
one the walls are coated too.
Of the rough metal √alpha is above the usual threshold of 0.2, and alpha is not.
"""


@dataclass(frozen=True, slots=True)
class PathUniforms:
    """Random numbers of paths by their numbers: pixel, and frame times pixels."""

    pixels: int
    seed: int

    def __call__(self, number: Indices) -> Uniforms:
        """Random numbers of some paths.

        Parameters
        ----------
        number : (N,) int; of the paths
        """
        pixel = (number % self.pixels).astype(np.uint32)
        return KeyedUniforms(pixel, number // self.pixels, self.seed, Stream.PATH)


@dataclass(frozen=True, slots=True, eq=False)
class DrawnPaths:
    """Paths of a frame, one for each pixel.

    Attributes
    ----------
    points : SurfacePoints; what the pixels see
    paths : Paths; one for each pixel
    """

    world: World
    points: SurfacePoints
    numbers: PathUniforms
    paths: Paths


@cache
def room(scene: str, size: int) -> tuple[World, SurfacePoints]:
    """A Cornell box with blocks of another material, and what its pixels see.

    Parameters
    ----------
    size : int; pixels of a side of the image

    Returns
    -------
    World, SurfacePoints; of size² pixels
    """
    found = find_scene("cornell-box")
    camera = replace(found.camera, width=size, height=size)
    meshes = tuple(_other(scene, mesh) for mesh in found.meshes)
    world = build_world(validate(replace(found, camera=camera, meshes=meshes)))
    return world, visible_points(world, *pixel_centers(size, size)).surface


def _other(scene: str, mesh: Mesh) -> Mesh:
    """A mesh of the box as a scene has it."""
    material = BLOCKS[scene]
    here = "block" in mesh.name or (scene == "glazed" and mesh.name != "light")
    if material is not None and here:
        return replace(mesh, material=material)
    if scene == "bright" and mesh.name == "ceiling":
        return replace(mesh, emission=(1.0, 1.0, 1.0))
    return mesh


@cache
def frame_of(
    scene: str, size: int, seed: int, frame: int, bounces: int, criterion: Criterion
) -> DrawnPaths:
    """Paths of a frame.

    Parameters
    ----------
    size : int; pixels of a side of the image
    seed, frame : int; of the random numbers
    """
    world, points = room(scene, size)
    numbers = PathUniforms(size * size, seed)
    number = np.arange(size * size) + frame * size * size
    drawn = draw_paths(
        world,
        points,
        bounces=bounces,
        criterion=criterion,
        number=number,
        uniforms=numbers(number),
    )
    return DrawnPaths(world, points, numbers, drawn.y)
