"""A real scene around the passes, many runs of it side by side."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Vec3s
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.path_tracer import follow, reflected_radiance
from restir_gi.reference.transport.world import World, build_world


@dataclass(frozen=True, slots=True, eq=False)
class SceneHarness:
    """A scene that R runs look at, run after run in rows.

    Attributes
    ----------
    visible : VisiblePoints; what one run sees, P pixels
    surface : SurfacePoints; the same for all, R · P rows
    runs : int; R
    seed : int; of the light at sample points, and of the neighbours
    """

    world: World
    visible: VisiblePoints
    surface: SurfacePoints
    runs: int
    seed: int

    def receivers(self) -> dict[str, NDArray[Any]]:
        """Buffers of the visible points."""
        return {
            "visible_position": self.surface.position,
            # Where nothing is seen there is no normal; such a pixel is black.
            "visible_normal": np.where(
                self.surface.hit[:, None], self.surface.normal, [0.0, 0.0, 1.0]
            ),
            "albedo": self.surface.color,
        }

    def trace(self, direction: Vec3s, frame: int) -> dict[str, NDArray[Any]]:
        """Sample points that rays from the visible points meet.

        Parameters
        ----------
        direction : (N, 3); unit vectors
        frame : int; from 0
        """
        met = follow(self.world, self.surface, direction, self.surface.hit, "initial")
        uniforms = self._uniforms(frame, Stream.PATH)
        radiance = reflected_radiance(self.world, met, 0, uniforms)
        place = contact(self.world.geometry, met)
        return {"position": place, "normal": met.normal, "radiance": radiance}

    def sees(self, viewer: Indices, position: Vec3s, normal: Vec3s) -> Masks:
        """Whether visible points see sample points, (N,) bool; nothing lies between.

        Parameters
        ----------
        viewer : (N,) int; rows
        position, normal : (N, 3), m and 1; sample points
        """
        x = take(self.surface.viewpoints, viewer)
        lit: Masks = np.any(normal != 0, axis=1)
        return self.world.caster.visible(
            x, position.astype(float), normal.astype(float), lit, "reuse"
        )

    def neighbors(self, count: int, frame: int) -> Indices:
        """Neighbours of each row, within its own run, (N, K) int; or −1.

        Parameters
        ----------
        count : int; K
        frame : int; from 0
        """
        pixels = len(self.visible.depth)
        row = np.arange(self.runs * pixels)
        draws = [self._uniforms(frame, Stream.SPATIAL).draw(k) for k in range(count)]
        width = self.world.camera.width
        found = find_neighbors(row % pixels, self.visible, width, UNBIASED, draws)
        start = row // pixels * pixels
        return np.stack([np.where(k >= 0, k + start, -1) for k in found], axis=1)

    def _uniforms(self, frame: int, stream: Stream) -> KeyedUniforms:
        pixel = np.arange(len(self.surface), dtype=np.uint32)
        return KeyedUniforms(pixel, frame, self.seed, stream)


def open_harness(scene: str, size: int, runs: int, seed: int) -> SceneHarness:
    """Make a built-in scene ready for many runs.

    Parameters
    ----------
    runs : int; R
    seed : int; of the first of them; seeds of batches must differ
    """
    found = find_scene(scene)
    camera = replace(found.camera, width=size, height=size)
    world = build_world(validate(replace(found, camera=camera)))
    visible = visible_points(world, *pixel_centers(size, size))
    surface = take(visible.surface, np.tile(np.arange(size * size), runs))
    return SceneHarness(world, visible, surface, runs, seed)
