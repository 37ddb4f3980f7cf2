"""What all methods of whole paths share: their frames, and how paths are shifted."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from restir_gi.extensions.pt_settings import CRITERIA, PathSettings
from restir_gi.extensions.shifting import Shift
from restir_gi.reference.frame import FrameContext, frames
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.transport.world import World, same_but_for_the_camera


@dataclass(frozen=True, slots=True, eq=False)
class PathFrame:
    """What one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int; from 0
    world : World; the scene as it was
    visible : VisiblePoints; G-buffer, through the centres of the pixels
    reservoirs : Reservoirs; of paths, a pixel each
    color : (N, 3) float64, W/(m² sr); indirect light
    """

    number: int
    world: World
    visible: VisiblePoints
    reservoirs: Reservoirs
    color: Vec3s


def path_shift(frame: FrameContext[PathSettings]) -> Shift:
    """How paths are shifted between points, in this frame or another."""
    uniforms = partial(frame.uniforms_of, Stream.PATH)
    return Shift(CRITERIA[frame.settings.shift], uniforms)


Settings = TypeVar("Settings", bound=PathSettings)
OfPaths = TypeVar("OfPaths", bound=PathFrame)


def path_frames(
    next_frame: Callable[[FrameContext[Settings], OfPaths | None], OfPaths],
    world: World,
    settings: Settings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[OfPaths]:
    """Frames of whole paths, without end.

    Arguments as of :func:`restir_gi.reference.frame.frames`.

    Where shapes or lights have moved, a frame has no history: the paths of the last one
    are of another scene.
    """

    def without_history_if_moved(
        frame: FrameContext[Settings], last: OfPaths | None
    ) -> OfPaths:
        if last and not same_but_for_the_camera(last.world.scene, frame.world.scene):
            last = None
        return next_frame(frame, last)

    return frames(
        without_history_if_moved, world, settings, bounces, seed, schedule, animation
    )
