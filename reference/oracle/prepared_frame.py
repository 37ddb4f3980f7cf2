"""A frame of a real scene, about to be resampled."""

from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.passes.initial import InitialSamples, initial_samples
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.restir_gi import Frame, render_frames
from restir_gi.reference.scene.materials.parameters import Kind
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import World, build_world

SCENES = ("cornell-box", "door-ajar", "sunlit-wall", "grazing-light", "many-lights")
"""All diffuse, and unlike: corners, a slit, grazing angles, small lights."""

FRAMES, NEIGHBORS = 4, 3
"""Frames before the one that is asked for, and neighbours of each pixel."""

CAPS = {"temporal": 3.0, "moved": 3.0, "spatial": 12.0, "fused": 9.0}
"""Limits of M, low enough to be reached."""

SIMILARITY: dict[str, Value] = {
    "radius": 0.1,
    "min_radius": 3.0,
    "max_angle": 25.0,
    "max_depth": 0.05,
}


@dataclass(frozen=True, slots=True, eq=False)
class PreparedFrame:
    """A frame of a scene about to be resampled.

    Attributes
    ----------
    last : Frame; the frame before
    initial : InitialSamples; new samples of this one
    neighbors : (N, K) int; neighbours of each pixel, or −1
    """

    name: str
    world: World
    last: Frame
    initial: InitialSamples
    neighbors: Indices
    seed: int

    def uniforms(self, stream: Stream) -> KeyedUniforms:
        """Random numbers of this frame."""
        pixel = np.arange(len(self.neighbors), dtype=np.uint32)
        return KeyedUniforms(pixel, FRAMES, self.seed, stream)


def prepare_frame(
    scene: Scene, size: int, seed: int, kinds: tuple[Kind, ...] = (Kind.LAMBERTIAN,)
) -> PreparedFrame:
    """Render the frames before, and draw the samples of the next, with size² rows.

    Raises UsageError: the scene has other materials, which the contract does not cover.

    Parameters
    ----------
    kinds : tuple of Kind; of the materials, as they are sorted
    """
    camera = replace(scene.camera, width=size, height=size)
    world = build_world(validate(replace(scene, camera=camera)))
    if world.materials.kinds != kinds:
        raise UsageError(
            f"scene {scene.name!r} has materials that are not diffuse; the"
            f" contract covers diffuse ones only: name a scene such as {SCENES[0]}"
        )
    frames = render_frames(world, UNBIASED, 1, seed, Schedule())
    last = next(islice(frames, FRAMES - 1, None))
    pixel = np.arange(size * size, dtype=np.uint32)

    def uniforms(stream: Stream) -> KeyedUniforms:
        return KeyedUniforms(pixel, FRAMES, seed, stream)

    initial = initial_samples(
        world,
        last.visible.surface,
        "uniform",
        "path-traced",
        1,
        directions=uniforms(Stream.INITIAL),
        paths=uniforms(Stream.PATH),
        speculars=uniforms(Stream.SPECULAR),
    )
    draws = [uniforms(Stream.SPATIAL).draw(s) for s in range(NEIGHBORS)]
    rows = np.arange(size * size)
    found = find_neighbors(rows, last.visible, size, UNBIASED, draws)
    return PreparedFrame(
        scene.name, world, last, initial, np.stack(found, axis=1), seed
    )
