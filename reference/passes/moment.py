"""What the passes of one frame share, and what a frame leaves behind."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from reference.arrays import Indices, Masks, Scalars, Vec3s
from reference.passes.receivers import Receivers
from reference.passes.replay import Replay
from reference.passes.roulette import tail_weight
from reference.records import cut
from reference.resampling.reservoir import Reservoirs
from reference.rng import KeyedUniforms, Stream, UInts
from reference.scene.animation import Changes
from reference.scene.surface import VisiblePoints
from reference.schedule import Schedule
from reference.settings import Settings
from reference.world import World


@dataclass(frozen=True, slots=True)
class Frame:
    """All that one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int
        From 0.
    world : World
        The scene as it was.
    visible : VisiblePoints
        G-buffer.
    temporal, spatial : Reservoirs
        Reservoirs at the visible points; the same where all reuse is one pass.
    color : (N, 3) float64, W/(m² sr)
        Indirect light.
    seen : (N,) bool or None
        Whether the visible point sees the sample that is shown; ``None`` where that is
        part of W.
    """

    number: int
    world: World
    visible: VisiblePoints
    temporal: Reservoirs
    spatial: Reservoirs
    color: Vec3s
    seen: Masks | None


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """What the passes of one frame share.

    Attributes
    ----------
    number : int
        Of the frame, from 0.
    world : World
        The scene.
    visible : VisiblePoints
        G-buffer.
    settings : Settings
        The algorithm.
    bounces : int
        Bounces of indirect light.
    seed : int
        Of the run.
    schedule : Schedule
        Bands and threads.
    changes : 'nothing', 'camera' or 'scene'
        What may differ between frames of the run.
    """

    number: int
    world: World
    visible: VisiblePoints
    settings: Settings
    bounces: int
    seed: int
    schedule: Schedule
    changes: Changes

    @property
    def pixels(self) -> int:
        """Of the frame."""
        return len(self.visible.depth)

    @property
    def remembers(self) -> bool:
        """Samples keep their suffix: their radiance or their age will be asked for."""
        return self.changes == "scene" or isfinite(self.settings.max_age)

    @property
    def validates(self) -> bool:
        """In this frame samples are traced again, and none drawn where there is one."""
        every = self.settings.validate_every
        asked = self.settings.motion == "as-stored" and self.changes == "scene"
        return asked and every > 0 and self.number % every == every - 1

    @property
    def replay(self) -> Replay:
        """How the radiance of any sample of the run follows from its path's number."""
        pixels, seed, settings = self.pixels, self.seed, self.settings
        width = self.world.camera.width

        def split(numbers: Indices) -> tuple[Indices, UInts]:
            frame, pixel = np.divmod(numbers, pixels)
            return frame, pixel.astype(np.uint32)

        def uniforms(numbers: Indices) -> KeyedUniforms:
            frame, pixel = split(numbers)
            return KeyedUniforms(pixel, frame, seed, Stream.PATH)

        def tail(numbers: Indices) -> Scalars:
            frame, pixel = split(numbers)
            return tail_weight(pixel, width, settings.roulette, frame, seed)

        alone = settings.roulette == 1 or self.bounces == 1
        return Replay(self.bounces, uniforms, None if alone else tail)

    def numbers(self, r: slice) -> Indices:
        """Numbers of the paths that some pixels draw in this frame.

        Parameters
        ----------
        r : slice
            K pixels.

        Returns
        -------
        (K,) int64
            frame · pixels + pixel.
        """
        return self.number * self.pixels + np.arange(r.start, r.stop)

    def uniforms(self, stream: Stream, r: slice) -> KeyedUniforms:
        """Random numbers of some pixels.

        Parameters
        ----------
        stream : Stream
            Who draws.
        r : slice
            K pixels.

        Returns
        -------
        KeyedUniforms
            K rows.
        """
        pixel = np.arange(r.start, r.stop, dtype=np.uint32)
        return KeyedUniforms(pixel, self.number, self.seed, stream)

    def receivers(self, r: slice) -> Receivers:
        """Some pixels, about to resample.

        Parameters
        ----------
        r : slice
            K pixels.

        Returns
        -------
        Receivers
            K rows.
        """
        return Receivers(self.world, cut(self.visible.surface, r), self.settings)
