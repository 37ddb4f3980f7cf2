"""The frame loop of every method, and what the passes of one frame share."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.records import indices
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.animation import Animation, Changes, still
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.transport.world import World, next_world

Settings = TypeVar("Settings")
Settings_co = TypeVar("Settings_co", covariant=True)


@dataclass(frozen=True, slots=True, eq=False)
class FrameContext(Generic[Settings_co]):
    """What the passes of one frame share.

    Attributes
    ----------
    number : int; of the frame, from 0
    world : World; the scene as it is in this frame
    visible : VisiblePoints; G-buffer, through the centres of the pixels
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    changes : 'nothing', 'camera' or 'scene'; what may differ between frames of the run
    """

    number: int
    world: World
    visible: VisiblePoints
    settings: Settings_co
    bounces: int
    seed: int
    schedule: Schedule
    changes: Changes = "nothing"

    @property
    def pixels(self) -> int:
        """Number of pixels N."""
        return len(self.visible.depth)

    def numbers(self, rows: slice | Indices) -> Indices:
        """Numbers of the paths that K pixels draw: frame · N + pixel, (K,) int64."""
        return self.number * self.pixels + indices(rows)

    def uniforms(self, stream: Stream, rows: slice | Indices) -> KeyedUniforms:
        """Random numbers of pixels ``rows``, (K,), in this frame; K rows."""
        pixel = indices(rows).astype(np.uint32)
        return KeyedUniforms(pixel, self.number, self.seed, stream)

    def uniforms_of(self, stream: Stream, numbers: Indices) -> KeyedUniforms:
        """Random numbers of the paths ``numbers``, (K,), of any frame; K rows."""
        frame, pixel = np.divmod(numbers, self.pixels)
        return KeyedUniforms(pixel.astype(np.uint32), frame, self.seed, stream)


class FinishedFrame(Protocol):
    """A finished frame, as far as the loop wants to know it."""

    @property
    def number(self) -> int:
        """From 0."""

    @property
    def world(self) -> World:
        """The scene as it was."""

    @property
    def visible(self) -> VisiblePoints:
        """G-buffer, through the centres of the pixels."""


Frame = TypeVar("Frame", bound=FinishedFrame)


def frames(
    next_frame: Callable[[FrameContext[Settings], Frame | None], Frame],
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[Frame]:
    """Frames without end, each made from the one before it.

    Parameters
    ----------
    next_frame : callable
        The method: from a frame's context, and the frame before it, to the frame.
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    animation : Animation, optional
        Validated scenes of all frames, with cameras of one size; by default the scene
        stands still.
    """
    animation = animation or still(world.scene)
    x, y = pixel_centers(world.camera.width, world.camera.height)

    def g_buffer(now: World) -> VisiblePoints:
        return in_bands(schedule, len(x), lambda r: visible_points(now, x[r], y[r]))

    last: Frame | None = None
    while True:
        number = last.number + 1 if last else 0
        now = next_world(last.world, animation(number)) if last else world
        visible = last.visible if last and now is last.world else g_buffer(now)
        frame = FrameContext(
            number=number,
            world=now,
            visible=visible,
            settings=settings,
            bounces=bounces,
            seed=seed,
            schedule=schedule,
            changes=animation.changes,
        )
        last = next_frame(frame, last)
        yield last
