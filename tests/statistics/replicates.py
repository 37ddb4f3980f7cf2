"""Independent runs of ReSTIR GI, and how their means are judged.

A replicate is one whole run under its own seed, with empty reservoirs at its start;
pixels and frames within it are never counted as samples.  Each run comes with a
companion: the mean, over the same frames, of the same initial samples without any
reuse.  The difference of the two has expectation 0 where reuse is unbiased, and less
noise than either, since reuse only weights the same samples anew.  What initial samples
estimate on their own is measured apart, with many more of them.  The sum of the two
means is the mean of ReSTIR GI, to be held against a truth.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.records import concatenate, take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream, UInts
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.passes.initial import initial_samples
from restir_gi.reference.passes.pixels import Pixels
from restir_gi.reference.passes.shade import shade
from restir_gi.reference.passes.temporal import temporal_resampling
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.restir_gi import next_frame
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.path_tracer import camera_radiance
from restir_gi.reference.transport.world import World, build_world

Array = NDArray[np.float64]

TILE = 8
ONE_BAND = Schedule(band=1 << 20)


def small_world(scene: Scene, width: int, height: int) -> World:
    camera = replace(scene.camera, width=width, height=height)
    return build_world(validate(replace(scene, camera=camera)))


def g_buffer(world: World, jitter: np.random.Generator | None = None) -> VisiblePoints:
    """Visible points at pixel centres, or at one random point of each pixel."""
    x, y = pixel_centers(world.camera.width, world.camera.height)
    if jitter is not None:
        x, y = (np.floor(c) + jitter.random(len(c)) for c in (x, y))
    return visible_points(world, x, y)


def run(
    world: World,
    settings: Settings,
    frames: int,
    seed: int,
    visible: VisiblePoints,
    bounces: int = 1,
) -> tuple[Array, Array]:
    """Last frame of a run, and the mean of its initial samples: (N, 3) each."""
    alone = replace(settings, temporal=False, spatial=False)
    color = frame_colors(world, settings, frames, seed, visible, bounces)
    initial = frame_colors(world, alone, frames, seed, visible, bounces)
    return color[-1], np.mean(initial, axis=0)


GAP = 8
"""Rows between runs in one frame: more than the radius of the search for neighbours."""


def tall(
    world: World, visible: list[VisiblePoints], gap: int = GAP
) -> tuple[World, VisiblePoints]:
    """Frames one below the other in a tall one, with rows between that see nothing."""
    width, height = world.camera.width, world.camera.height
    camera = replace(world.camera, height=(height + gap) * len(visible))
    nothing = take(visible[0], np.zeros(gap * width, int))
    surface = replace(nothing.surface, primitive=np.full(gap * width, -1, np.int32))
    nothing = replace(nothing, surface=surface, depth=np.zeros(gap * width))
    seen = concatenate([part for v in visible for part in (v, nothing)])
    return replace(world, scene=replace(world.scene, camera=camera)), seen


def runs_at_once(
    world: World,
    settings: Settings,
    frames: int,
    seed: int,
    visible: list[VisiblePoints],
    bounces: int = 1,
) -> list[tuple[Array, Array]]:
    """As `run`, of several runs that stand one below the other in one tall frame.

    Random numbers belong to a pixel, so that the runs are independent; no neighbour is
    found across the gap.  Small frames spend half of their time on calls: a tall one
    does not.
    """
    assert max(settings.radius * world.camera.width, settings.min_radius) + 1 < GAP
    all_of_them, seen = tall(world, visible)
    whole = run(all_of_them, settings, frames, seed, seen, bounces)
    color, initial = (apart(rows, world, len(visible)) for rows in whole)
    return list(zip(color, initial, strict=True))


def apart(rows: Array, world: World, runs: int) -> Array:
    """Frames of a tall one, (runs, N, 3)."""
    width, height = world.camera.width, world.camera.height
    return rows.reshape(runs, -1, 3)[:, : width * height]


def frame_colors(
    world: World,
    settings: Settings,
    frames: int,
    seed: int,
    visible: VisiblePoints,
    bounces: int = 1,
) -> list[Array]:
    """Indirect light of each frame of one run."""
    last, colors = None, []
    for number in range(frames):
        frame = FrameContext(
            number=number,
            world=world,
            visible=visible,
            settings=settings,
            bounces=bounces,
            seed=seed,
            schedule=ONE_BAND,
        )
        last = next_frame(frame, last)
        colors.append(last.color)
    return colors


def tile_means(rows: Array, width: int) -> Array:
    """(..., N, C) rows to (..., tiles * C) means over 8 x 8 pixels."""
    *many, count, columns = rows.shape
    across, down = width // TILE, count // width // TILE
    image = rows.reshape(*many, down, TILE, across, TILE, columns)
    return image.mean(axis=(-4, -2)).reshape(*many, -1)


@dataclass(frozen=True)
class Means:
    """Image mean in column 0, then tiles and channels: a row a replicate."""

    values: Array

    @property
    def mean(self) -> Array:
        """Of each column."""
        return self.values.mean(axis=0)

    @property
    def error(self) -> Array:
        """Standard error of the mean of each column."""
        return self.values.std(axis=0, ddof=1) / np.sqrt(len(self.values))

    @property
    def skewness(self) -> Array:
        """Third standardized moment of each column; 0 where it does not vary."""
        central = self.values - self.mean
        cubes, spread = (central**3).mean(axis=0), central.std(axis=0) ** 3
        return np.divide(cubes, spread, out=np.zeros_like(cubes), where=spread > 0)


def means(rows: list[Array], width: int) -> Means:
    whole = np.array(rows)
    image = whole.mean(axis=(1, 2))[:, None]
    return Means(np.concatenate([image, tile_means(whole, width)], axis=1))


def path_traced(
    world: World,
    samples: int,
    bounces: int = 1,
    jitter: np.random.Generator | None = None,
) -> Means:
    """Indirect light by the path tracer: the truth."""

    def color(points: SurfacePoints, pixel: UInts, number: int) -> Array:
        u = KeyedUniforms(pixel, number, SEED_OF_TRUTH, Stream.PATH)
        return camera_radiance(world, points, "indirect", bounces, u)

    return in_batches(world, samples, color, jitter)


def initially_sampled(
    world: World,
    settings: Settings,
    samples: int,
    bounces: int = 1,
    jitter: np.random.Generator | None = None,
) -> Means:
    """Indirect light by the initial samples of ReSTIR GI alone."""

    def color(points: SurfacePoints, pixel: UInts, number: int) -> Array:
        streams = (Stream.INITIAL, Stream.PATH, Stream.SPECULAR, Stream.TEMPORAL)
        *three, last = (
            KeyedUniforms(pixel, number, SEED_OF_INITIAL, s) for s in streams
        )
        source, glossy_samples = settings.source, settings.glossy_samples
        named = dict(zip(("directions", "paths", "speculars"), three, strict=True))
        fresh = initial_samples(world, points, source, glossy_samples, bounces, **named)
        nothing = Reservoirs(fresh.y, 0.0 * fresh.pdf, 0.0 * fresh.pdf)
        q, u, cap = Pixels(world, points, settings), last.draw(0)[0], 1.0
        kept = temporal_resampling(q, fresh, nothing, u, cap=cap)
        return shade(world, points, kept) + fresh.not_reused

    return in_batches(world, samples, color, jitter)


BATCHES = 64

# Runs take the seeds from 0 on; what is compared must not share a random number.
SEED_OF_TRUTH, SEED_OF_INITIAL = 1 << 20, (1 << 20) + 1


def in_batches(
    world: World,
    samples: int,
    color: Callable[[SurfacePoints, UInts, int], Array],
    jitter: np.random.Generator | None,
) -> Means:
    """Means of independent samples a pixel in 64 batches, a replicate each."""
    visible = g_buffer(world, jitter)
    count = len(visible.depth)
    at_once = max(1, min(samples // BATCHES, (1 << 14) // count))
    pixel = np.arange(count * at_once, dtype=np.uint32)
    points = take(visible.surface, pixel % count)
    rounds = -(-samples // (BATCHES * at_once))
    rows = []
    for batch in range(BATCHES):
        total = np.zeros((count, 3))
        for i in range(rounds):
            if jitter is not None:
                points = take(g_buffer(world, jitter).surface, pixel % count)
            some = color(points, pixel, batch * rounds + i)
            total += some.reshape(at_once, count, 3).mean(axis=0)
        rows.append(total / rounds)
    return means(rows, world.camera.width)


def hall_t(difference: Array, error: Array, skewness: Array, n: int) -> Array:
    """t-statistics with their skewness taken out by Hall's cubic transformation.

    Replicates are skewed to the right, and Student's t then rejects correct estimators
    as too dark far more often than it says.  The transformation removes the terms of
    order 1/sqrt(n) of the error and is monotone, so that no large t becomes small
    [Hall92, section 2].
    """
    t = np.divide(difference, error, out=np.zeros_like(error), where=error > 0)
    a = skewness / np.sqrt(n)
    return t + a * t**2 / 3 + a**2 * t**3 / 27 + a / 6


def largest_t(reuse: Means, expected: float | Array = 0.0) -> float:
    """Largest |t| among the tiles."""
    t = hall_t(reuse.mean - expected, reuse.error, reuse.skewness, len(reuse.values))
    return float(np.abs(t[1:]).max())


def threshold(tests: int, family: float, n: int) -> float:
    """Bound on |t| that correct tiles exceed with probability ``family`` in all.

    Bonferroni: tiles share samples through reuse, so that nothing may be assumed of
    their dependence.
    """
    return float(stats.t.isf(family / (2 * tests), n - 1))
