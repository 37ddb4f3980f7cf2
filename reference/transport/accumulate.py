"""Path-traced truth: numbered samples, accumulated one after the other.

A sample of a frame is a pure function of its number, which is the frame word of the
random key.  What is kept between two samples is `Moments` alone; so a run that was cut
anywhere goes on as if nothing had happened, to the last bit.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.moments import Moments, add_samples, no_samples
from restir_gi.reference.numerics.records import cut
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.path_tracer import Light, camera_radiance, first_hits
from restir_gi.reference.transport.world import World

Pixel = Literal["center", "box"]

BATCH_SECONDS = 0.5
"""Time between two states of an accumulation, unless one sample takes longer."""


@dataclass(frozen=True, slots=True, eq=False)
class PathSamples:
    """Path-traced samples of a frame, by number.

    Attributes
    ----------
    light : 'indirect', 'direct' or 'full'; which paths count
    bounces : int; bounces of indirect light, 0 to 30
    seed : int; samples of different seeds are independent
    stream : Stream; who draws; samples of different streams are independent too
    centers : SurfacePoints or None
        First hits through the pixel centres, shared by all samples; ``None`` where
        each sample draws its own point of the pixel.
    """

    world: World
    light: Light
    bounces: int
    seed: int
    stream: Stream
    centers: SurfacePoints | None

    @property
    def rows(self) -> int:
        """Pixels of the frame."""
        return self.world.camera.width * self.world.camera.height

    def radiance(self, rows: slice, number: int) -> Vec3s:
        """One sample of some pixels, (K, 3) float64, W/(m² sr); unbiased.

        Parameters
        ----------
        number : int; of the sample, from 0
        """
        pixel = np.arange(rows.start, rows.stop, dtype=np.uint32)
        if self.centers is None:
            u = KeyedUniforms(pixel, number, self.seed, Stream.PIXEL).draw(0)
            y, x = np.divmod(pixel, self.world.camera.width)
            points = first_hits(self.world, x + u[0], y + u[1])
        else:
            points = cut(self.centers, rows)
        uniforms = KeyedUniforms(pixel, number, self.seed, self.stream)
        return camera_radiance(self.world, points, self.light, self.bounces, uniforms)


def path_samples(
    world: World,
    schedule: Schedule,
    *,
    light: Light,
    bounces: int,
    seed: int,
    pixel: Pixel = "center",
    stream: Stream = Stream.PATH,
) -> PathSamples:
    """Samples of a frame, with the first hits that they share.

    Parameters
    ----------
    bounces : int; bounces of indirect light, 0 to 30
    pixel : 'center' or 'box'
        Camera rays through the centres of the pixels, or anywhere in them.
    """
    centers = None
    if pixel == "center":
        x, y = pixel_centers(world.camera.width, world.camera.height)
        centers = in_bands(schedule, len(x), lambda r: first_hits(world, x[r], y[r]))
    return PathSamples(world, light, bounces, seed, stream, centers)


Advance = Callable[[Moments, int], Moments]
"""From moments, and a number of samples, to the moments of so many samples."""


def accumulate(
    samples: PathSamples, moments: Moments, stop: int, schedule: Schedule
) -> Iterator[Moments]:
    """Accumulate until there are enough samples, in batches of about half a second.

    Parameters
    ----------
    moments : Moments; of the samples before
    stop : int; samples in the end
    """

    def advance(before: Moments, until: int) -> Moments:
        return add_samples(before, samples.radiance, until, schedule)

    return in_batches(advance, moments, stop)


def ever_more(samples: PathSamples, step: int, schedule: Schedule) -> Iterator[Moments]:
    """Moments after ever more samples, for whoever looks at the clock in between.

    Parameters
    ----------
    samples : PathSamples; to be added, from number 0 on

    Yields
    ------
    Moments; without end
    """
    moments = no_samples(samples.rows)
    while True:
        stop = moments.count + step
        moments = add_samples(moments, samples.radiance, stop, schedule)
        yield moments


def in_batches(advance: Advance, moments: Moments, stop: int) -> Iterator[Moments]:
    """Advance until there are enough samples, in batches of about half a second.

    Parameters
    ----------
    moments : Moments; of the samples before
    stop : int; samples in the end

    Yields
    ------
    Moments
        After each batch.  How many samples make a batch depends on the clock; what
        the moments are after a given number of samples does not.
    """
    batch = 1
    while moments.count < stop:
        start = time.perf_counter()
        until = min(moments.count + batch, stop)
        moments = advance(moments, until)
        elapsed = max(time.perf_counter() - start, 1e-6)
        yield moments
        batch = max(1, min(int(batch * BATCH_SECONDS / elapsed), 4 * batch))
