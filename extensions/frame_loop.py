"""The frame loop that all methods of whole paths share."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from extensions.connection import CRITERIA
from extensions.pt_settings import PathSettings
from extensions.shifting import Shift
from reference.arrays import Indices, Vec3s
from reference.passes.gbuffer import visible_points
from reference.resampling.reservoir import Reservoirs
from reference.rng import KeyedUniforms, Stream, Uniforms
from reference.scene.animation import Animation, still
from reference.scene.camera import pixel_centers
from reference.scene.surface import VisiblePoints
from reference.schedule import Schedule, in_bands
from reference.world import World, next_world, same_but_for_the_camera


@dataclass(frozen=True, slots=True, eq=False)
class PathFrame:
    """What one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int
        From 0.
    world : World
        The scene as it was.
    visible : VisiblePoints
        G-buffer, through the centres of the pixels.
    reservoirs : Reservoirs
        Of paths, a pixel each.
    color : (N, 3) float64, W/(m² sr)
        Indirect light.
    """

    number: int
    world: World
    visible: VisiblePoints
    reservoirs: Reservoirs
    color: Vec3s


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """What the passes of one frame share.

    Attributes
    ----------
    number : int
        Of the frame.
    world : World
        The scene as it is.
    visible : VisiblePoints
        G-buffer, through the centres of the pixels.
    settings : PathSettings
        The algorithm.
    bounces : int
        Of indirect light.
    seed : int
        Of the run.
    """

    number: int
    world: World
    visible: VisiblePoints
    settings: PathSettings
    bounces: int
    seed: int

    @property
    def pixels(self) -> int:
        """How many."""
        return len(self.visible.depth)

    @property
    def shift(self) -> Shift:
        """Of paths between points, in this frame or another."""
        return Shift(CRITERIA[self.settings.shift], self._of_paths)

    def _of_paths(self, number: Indices) -> Uniforms:
        pixel = (number % self.pixels).astype(np.uint32)
        return KeyedUniforms(pixel, number // self.pixels, self.seed, Stream.PATH)

    def numbers(self, rows: slice) -> Indices:
        """Keys of the paths that this frame draws.

        Parameters
        ----------
        rows : slice
            Pixels.

        Returns
        -------
        (K,) int64
            No path of any other frame has them.
        """
        return np.arange(rows.start, rows.stop) + self.number * self.pixels

    def uniforms(self, rows: slice, stream: Stream) -> Uniforms:
        """Random numbers of the pixels.

        Parameters
        ----------
        rows : slice
            Pixels.
        stream : Stream
            Who draws.

        Returns
        -------
        Uniforms
            K rows.
        """
        pixel = np.arange(rows.start, rows.stop, dtype=np.uint32)
        return KeyedUniforms(pixel, self.number, self.seed, stream)


OfPaths = TypeVar("OfPaths", bound=PathFrame)


def path_frames(
    make: Callable[[Moment, OfPaths | None, Schedule], OfPaths],
    world: World,
    settings: PathSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[OfPaths]:
    """Frames of whole paths, without end.

    Parameters
    ----------
    make : callable
        From a moment, the frame before it if there is one, and a schedule to a frame.
    world : World
        The scene in frame 0.
    settings : PathSettings
        The algorithm.
    bounces : int
        Bounces of indirect light, 1 to 30.
    seed : int
        Runs of different seeds are independent.
    schedule : Schedule
        Bands and threads; no influence on the result.
    animation : Animation, optional
        Validated scenes of all frames; by default the scene stands still.  A frame
        before which shapes or lights have moved starts over: the paths of the last one
        are of another scene.

    Returns
    -------
    iterator of PathFrame
        Frame after frame, each resampling what the last one left.
    """

    def frame(
        number: int, now: World, visible: VisiblePoints, last: OfPaths | None
    ) -> OfPaths:
        moment = Moment(number, now, visible, settings, bounces, seed)
        is_other = last and not same_but_for_the_camera(last.world.scene, now.scene)
        return make(moment, None if is_other else last, schedule)

    return frames(frame, world, schedule, animation)


class Made(Protocol):
    """A frame that others follow."""

    @property
    def number(self) -> int:
        """From 0."""

    @property
    def world(self) -> World:
        """The scene as it was."""

    @property
    def visible(self) -> VisiblePoints:
        """G-buffer, through the centres of the pixels."""


Frame = TypeVar("Frame", bound=Made)


def frames(
    make: Callable[[int, World, VisiblePoints, Frame | None], Frame],
    world: World,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[Frame]:
    """Frames without end.

    Parameters
    ----------
    make : callable
        From a frame's number, scene and G-buffer, and the frame before it if there is
        one, to the frame.
    world : World
        The scene in frame 0.
    schedule : Schedule
        Bands and threads; no influence on the result.
    animation : Animation, optional
        Validated scenes of all frames; by default the scene stands still.

    Yields
    ------
    Made
        Frame after frame.
    """
    animation = animation or still(world.scene)
    x, y = pixel_centers(world.camera.width, world.camera.height)

    def g_buffer(now: World) -> VisiblePoints:
        return in_bands(schedule, len(x), lambda r: visible_points(now, x[r], y[r]))

    last: Frame | None = None
    while True:
        now = next_world(last.world, animation(last.number + 1)) if last else world
        visible = last.visible if last and now is last.world else g_buffer(now)
        last = make(last.number + 1 if last else 0, now, visible, last)
        yield last
