"""Path-traced samples that other processes draw, to the same last bit.

Each worker is given some rows of the frame, with their moments, and adds samples to
them one after the other, as one process would.
"""

from collections import Counter
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from restir_gi.reference.methods import Job
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.moments import Moments, add_samples
from restir_gi.reference.numerics.schedule import Schedule, bands
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.system.workers import work
from restir_gi.reference.transport.accumulate import PathSamples, Pixel, path_samples
from restir_gi.reference.transport.path_tracer import Light
from restir_gi.reference.transport.world import build_world
from restir_gi.reference.truth.resumable import SampleSource

MOST_SHARES, LEAST_ROWS = 32, 256
"""Of a frame, for all workers; and rows that are worth a message."""


@dataclass(frozen=True, slots=True)
class Request:
    """Samples that are asked for.

    Attributes
    ----------
    light : 'indirect', 'direct' or 'full'; which paths count
    bounces : int; bounces of indirect light
    pixel : 'center' or 'box'; where camera rays go
    """

    named: Named
    light: Light
    bounces: int
    seed: int
    pixel: Pixel


@dataclass(frozen=True, slots=True, eq=False)
class Share:
    """What one worker is to do.

    Attributes
    ----------
    request : Request; whose samples
    start, stop : int; rows of the frame
    moments : Moments; of these rows, so far
    until : int; samples in the end
    """

    request: Request
    start: int
    stop: int
    moments: Moments
    until: int


def sampled_by(executor: Executor, named: Named) -> Callable[[Job], SampleSource]:
    """How workers draw the samples of a job.

    Parameters
    ----------
    named : Named; the scene of the job, at its frame
    """

    def source(job: Job) -> SampleSource:
        request = Request(named, job.light, job.bounces, job.seed, job.settings.pixel)
        rows = named.width * named.height
        share_rows = max(LEAST_ROWS, -(-rows // MOST_SHARES))
        counts: Counter[str] = Counter()
        if request.pixel == "center":
            counts["primary"] = rows  # once, by whichever worker opens the scene

        def advance(before: Moments, until: int) -> Moments:
            shares = [
                Share(request, r.start, r.stop, _cut(before, r), until)
                for r in bands(rows, share_rows)
            ]
            mean, squares = np.empty((rows, 3)), np.empty((rows, 3))
            for share, (found, rays) in work(executor, add_share, shares):
                mean[share.start : share.stop] = found.mean
                squares[share.start : share.stop] = found.squares
                counts.update(rays)
            return Moments(until, mean, squares)

        return SampleSource(rows, advance, lambda: counts)

    return source


def add_share(share: Share) -> tuple[Moments, Counter[str]]:
    """Add samples to some rows: what a worker does.

    Returns the moments of these rows, and the rays that were traced, by kind.
    """
    samples = _opened(share.request)
    before = Counter(samples.world.caster.counts)

    def draw(rows: slice, number: int) -> Vec3s:
        moved = slice(share.start + rows.start, share.start + rows.stop)
        return samples.radiance(moved, number)

    found = add_samples(share.moments, draw, share.until, Schedule())
    return found, samples.world.caster.counts - before


@lru_cache(maxsize=2)
def _opened(request: Request) -> PathSamples:
    named = request.named
    found = find_scene_or_file(named.name, named.lenient, named.allow_outside)
    scene = frames_of(named, found)(0)
    return path_samples(
        build_world(scene),
        Schedule(),
        light=request.light,
        bounces=request.bounces,
        seed=request.seed,
        pixel=request.pixel,
    )


def _cut(moments: Moments, rows: slice) -> Moments:
    return Moments(moments.count, moments.mean[rows], moments.squares[rows])
