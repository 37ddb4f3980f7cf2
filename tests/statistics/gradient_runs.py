"""Runs of gradient-domain methods, and what is judged of them.

Of each frame: how much of the true differences it has, a projection on a direction that
path tracing has found beforehand; and means over tiles of the differences to the right
and down, and of the least-squares image.  The direction is noisy and independent of all
that is projected on it, so that what should be 0 stays 0.
"""

from dataclasses import dataclass
from functools import cache
from itertools import islice

import numpy as np

from restir_gi.gradient_domain.gradient_pt import render_gradient_paths
from restir_gi.gradient_domain.reconstruction import (
    Differences,
    differences,
    least_squares,
)
from restir_gi.gradient_domain.settings import GradientPathSettings
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.transport.accumulate import path_samples
from tests.properties.path_scenes import world
from tests.statistics.path_runs import FAMILY, FRAMES, SIZE, moving
from tests.statistics.replicates import (
    ONE_BAND,
    Means,
    largest_t,
    threshold,
    tile_means,
)

SEED_OF_DIRECTIONS, SEED_OF_TRUTH = 1 << 21, (1 << 21) + 1
COLUMNS = 9 * (SIZE // 8) ** 2


@dataclass(frozen=True)
class GradientPlan:
    """A scene that stands still, or a camera that moves through one."""

    name: str
    bounces: int
    moves: bool = False

    @property
    def scenes(self):
        """Worlds of the first and the last frame, and the animation."""
        if not self.moves:
            w = world(self.name, SIZE)
            return w, w, None
        return moving(self.name)


def path_traced_image(w, bounces, seed, numbers):
    """Mean over the areas of pixels, of samples of some numbers."""
    samples = path_samples(
        w,
        ONE_BAND,
        light="indirect",
        bounces=bounces,
        seed=seed,
        pixel="box",
        stream=Stream.PATH,
    )
    every = slice(0, samples.rows)
    return np.mean([samples.radiance(every, number) for number in numbers], axis=0)


@cache
def direction(plan):
    """Of the true differences, in unit length."""
    _, last, _ = plan.scenes
    image = path_traced_image(last, plan.bounces, SEED_OF_DIRECTIONS, range(256))
    d = differences(image, SIZE)
    both = np.concatenate([d.x, d.y], axis=1)
    return both / np.linalg.norm(both)


def judged_rows(plan, primal, d):
    """Projection in column 0, then tiles."""
    both = np.concatenate([d.x, d.y], axis=1)
    image = least_squares(primal, d, SIZE)
    tiles = tile_means(np.concatenate([both, image], axis=1), SIZE)
    return np.concatenate([[np.vdot(both, direction(plan))], tiles])


def row_of(plan, estimates):
    """The same, of pixels and differences side by side."""
    primal, x, y = np.split(estimates, 3, axis=1)
    return judged_rows(plan, primal, Differences(x, y))


def estimates_of(plan, render, settings, seed):
    """Of all frames of a run."""
    first, _, animation = plan.scenes
    found = render(first, settings, plan.bounces, seed, ONE_BAND, animation)
    return [frame.estimates for frame in islice(found, FRAMES)]


def of_reuse(plan, render, settings, runs):
    """Last frames of runs over the same new paths without reuse."""
    alone = GradientPathSettings(shift=settings.shift)
    rows = []
    for seed in range(runs):
        kept = estimates_of(plan, render, settings, seed)[-1]
        new = estimates_of(plan, render_gradient_paths, alone, seed)
        # Frames of a scene that stands still all have one expectation.
        new = new[-1] if plan.moves else np.mean(new, axis=0)
        rows.append(row_of(plan, kept - new))
    return Means(np.array(rows))


def of_candidates(plan, batches, per_batch):
    """New paths without reuse, and path tracing: two means to be held side by side."""
    first, _, _ = plan.scenes
    mine, truth = [], []
    for batch in range(batches):
        frames = render_gradient_paths(
            first, GradientPathSettings(), plan.bounces, batch, ONE_BAND
        )
        some = [frame.estimates for frame in islice(frames, per_batch)]
        mine.append(row_of(plan, np.mean(some, axis=0)))
        numbers = range(batch * per_batch, (batch + 1) * per_batch)
        image = path_traced_image(first, plan.bounces, SEED_OF_TRUTH, numbers)
        truth.append(judged_rows(plan, image, differences(image, SIZE)))
    return Means(np.array(mine)), Means(np.array(truth))


@cache
def true_projection(plan):
    """How much of the direction there really is: what a bias is measured in."""
    _, last, _ = plan.scenes
    image = path_traced_image(last, plan.bounces, SEED_OF_TRUTH, range(256))
    return judged_rows(plan, image, differences(image, SIZE))[0]


def judged(plan, found):
    """Whether no bias is seen, in the projection and in all tiles."""
    n, scale = len(found.values), true_projection(plan)
    bound = threshold(COLUMNS, FAMILY, n)
    along = abs(found.mean[0] / found.error[0])
    print(
        f"{plan.name}: differences {100 * found.mean[0] / scale:+.2f} % ±"
        f" {100 * found.error[0] / scale:.2f}, largest tile |t| {largest_t(found):.1f}"
        f" of {bound:.1f}"
    )
    return largest_t(found) < bound and along < threshold(1, FAMILY, n)
