"""Runs of methods of whole paths, and what reuse does to their mean.

A replicate is a run under its own seed, minus the mean of its own candidates without
reuse, whose expectation is 0.  Correct reuse fails the tiles of a scene with
probability 1e-4, and the image mean with as much.
"""

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np
from scipy import stats

from restir_gi.extensions.restir_pt import render_path_frames
from restir_gi.extensions.shifting import Shift
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world
from tests.properties.path_scenes import world
from tests.statistics.replicates import (
    BATCHES,
    ONE_BAND,
    largest_t,
    means,
    path_traced,
    threshold,
)

FAMILY = 1e-4
SIZE, FRAMES = 24, 4
STRIDE = 10
"""Frames of the animation from one to the next: a camera that moves fast."""

COLUMNS = 3 * (SIZE // 8) ** 2


class Flat(Shift):
    """Values are right, and all Jacobians 1."""

    def __call__(self, *whence):
        """Shift, and forget what it does to the measure."""
        value, jacobian = Shift.__call__(self, *whence)
        return value, (jacobian > 0).astype(float)


ALONE = {"temporal": False, "spatial": False}
"""Settings without reuse."""


def of_reuse(scene, settings, bounces, runs, render=render_path_frames):
    """Means of the last frame over those of the same candidates without reuse."""
    w = world(scene, SIZE)
    alone = replace(settings, **ALONE)
    rows = []
    for seed in range(runs):

        def colors(s, seed=seed):
            frames = render(w, s, bounces, seed, ONE_BAND)
            return [frame.color for frame in islice(frames, FRAMES)]

        rows.append(colors(settings)[-1] - np.mean(colors(alone), axis=0))
    return means(rows, SIZE)


def judged(found, scale):
    """Whether no bias is seen: largest |t| of the tiles, and of the image."""
    n = len(found.values)
    image = float(np.abs(found.mean[0] / found.error[0]))
    print(
        f"bias of reuse {100 * found.mean[0] / scale:+.2f} % ±"
        f" {100 * found.error[0] / scale:.2f}, largest tile |t| {largest_t(found):.1f}"
        f" of {threshold(COLUMNS, FAMILY, n):.1f}"
    )
    tiles = largest_t(found) < threshold(COLUMNS, FAMILY, n)
    return tiles and image < stats.t.isf(FAMILY / 2, n - 1)


def brightness(scene, bounces):
    """Of the path-traced picture."""
    return float(path_traced(world(scene, SIZE), 64, bounces).mean[0])


def of_a_camera_that_moves(settings, runs, render=render_path_frames):
    """Last frame with reuse less that without, and the image's mean."""
    return of_a_scene_that_moves("moving-camera", settings, runs, render)


def of_a_scene_that_moves(
    name, settings, runs, render=render_path_frames, without=ALONE, stride=STRIDE
):
    """The same for any animation of the catalogue."""
    first, last, animation = moving(name, stride)
    frames = first, settings, 2, runs, render, without, animation
    return of_last_frames(*frames), float(path_traced(last, 64, 2).mean[0])


@cache
def moving(name, stride=STRIDE):
    """Worlds of the first and the last frame, and the animation, seen by few pixels."""
    found = find_animation(name)

    def at(frame):
        scene = found(stride * frame)
        camera = replace(scene.camera, width=SIZE, height=SIZE)
        return validate(replace(scene, camera=camera))

    scenes = [at(frame) for frame in range(FRAMES)]
    animation = Animation(lambda frame: scenes[frame], found.changes)
    return build_world(scenes[0]), build_world(scenes[-1]), animation


def of_last_frames(w, settings, bounces, runs, render, without, animation=None):
    """Last frames with reuse over those without: of one number, on the same paths."""
    rows = []
    for seed in range(runs):

        def last(s, seed=seed):
            frames = render(w, s, bounces, seed, ONE_BAND, animation)
            return [frame.color for frame in islice(frames, FRAMES)][-1]

        rows.append(last(settings) - last(replace(settings, **without)))
    return means(rows, w.camera.width)


BOUND = threshold(COLUMNS + 1, FAMILY, BATCHES)
"""Of the largest |t| of tiles and image in `of_candidates`."""


def of_candidates(w, settings, bounces, render, jitter=None, frames=256):
    """Largest |t| of frames without reuse less path tracing, of tiles and image."""
    rows = []
    for batch in range(BATCHES):
        found = render(w, settings, bounces, batch, ONE_BAND)
        some = [frame.color for frame in islice(found, frames // BATCHES)]
        rows.append(np.mean(some, axis=0))
    mine, truth = means(rows, SIZE), path_traced(w, frames, bounces, jitter)
    error = np.hypot(mine.error, truth.error)
    t = np.abs(mine.mean - truth.mean) / np.maximum(error, 1e-300)
    ratio = mine.mean[0] / truth.mean[0]
    print(f"candidates over the truth {ratio:.4f}, largest |t| {t.max():.1f}")
    return t[error > 0].max()
