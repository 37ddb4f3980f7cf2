"""Our side of the comparison with Mitsuba: frames of ReSTIR GI, one after the other.

    python -m tests.benchmarks.our_side SCENE SIZE BOUNCES FRAMES

renders so many in a process of its own, and imports no more than that takes.
"""

import os
import sys
from pathlib import Path

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.restir_gi import next_frame
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import build_world
from tests.benchmarks.scenes import bumpy_box, sized

THREADS = os.cpu_count() or 1


def real_scene() -> Path:
    return Path(os.environ["RESTIR_SCENES"]) / "veach-ajar" / "simple" / "scene.xml"


def scene_of(name: str, size: int) -> Scene:
    if name == "veach-ajar":
        from restir_gi.reference.scene.loaders.load import load_scene

        return validate(sized(load_scene(real_scene()), size, size))
    scene = bumpy_box() if name == "bumpy-box" else find_scene(name)
    return validate(sized(scene, size, size))


class Runner:
    """A run from its first frame on."""

    def __init__(self, name: str, size: int, bounces: int, seed: int) -> None:
        self.world = build_world(scene_of(name, size))
        self.visible = visible_points(self.world, *pixel_centers(size, size))
        self.bounces, self.seed, self.last = bounces, seed, None

    def step(self) -> np.ndarray:
        """Indirect light of the next frame."""
        schedule = Schedule(threads=THREADS)
        frame = FrameContext(
            number=self.last.number + 1 if self.last else 0,
            world=self.world,
            visible=self.visible,
            settings=UNBIASED,
            bounces=self.bounces,
            seed=self.seed,
            schedule=schedule,
        )
        self.last = next_frame(frame, self.last)
        return self.last.color


if __name__ == "__main__":
    name, (size, bounces, frames) = sys.argv[1], map(int, sys.argv[2:])
    runner = Runner(name, size, bounces, 0)
    for _ in range(frames):
        runner.step()
