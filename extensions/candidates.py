"""Initial candidates: a tree of paths a pixel, of which one is kept."""

from dataclasses import dataclass, replace

import numpy as np

from extensions.connection import Criterion
from extensions.ends import density_at, ended, find_lights
from extensions.paths import Paths, no_paths
from extensions.walking import Leaving, Step, arrive, leave, start
from reference.arrays import Indices
from reference.records import where
from reference.resampling.reservoir import Candidates, merge
from reference.rng import Uniforms
from reference.scene.surface import SurfacePoints
from reference.world import World


def draw_paths(
    world: World,
    points: SurfacePoints,
    bounces: int,
    criterion: Criterion,
    number: Indices,
    uniforms: Uniforms,
) -> Candidates:
    """Draw a tree of paths from each visible point, and keep one by its light.

    Paths of other lengths, or that end otherwise, are other integrals: each is drawn
    once, so that w = p̂(u), the luminance of f / p, without a weight.

    Parameters
    ----------
    points : SurfacePoints; N visible points x_1
    bounces : int
        Of indirect light, at least 1: surface points after x_1 that a path may visit.
    number : (N,) int64; keys of the paths
    uniforms : Uniforms
        N rows, made from these keys.  Vertex v takes dimension 2 (v - 1) for its
        direction and 2 (v - 1) + 1 for its light; lanes 3 choose within the tree.

    Returns
    -------
    Candidates
        Of `Paths`; w is the light of the whole tree, M = 1 for trees without light.
    """
    step, trunk = start(points), _Trunk(no_paths(points, number))
    kept: Candidates | None = None
    for vertex in range(1, bounces + 2):
        is_last = vertex == bounces + 1
        by_chance = not is_last or world.seeks_lights
        active = step.points.hit & by_chance
        leaving = leave(world, step, vertex, uniforms, active)
        if vertex > 1:
            met = leaving if by_chance else None
            lights = find_lights(world, step, vertex, uniforms, met)
            found = replace(lights, y=ended(step, trunk.paths, vertex, lights.y))
            u = uniforms.draw(2 * vertex - 1)[3]
            kept = found if kept is None else merge(kept, found, u)
        if is_last:
            break
        before, step = step, arrive(world, criterion, step, vertex, leaving)
        if vertex > 1:
            trunk = trunk.grown(before, vertex, leaving, step)
        if not step.points.hit.any():
            break
    ones = np.ones(len(points))
    if kept is None:
        return Candidates(no_paths(points, number), 0 * ones, 0 * ones, ones)
    return replace(kept, M=ones)


@dataclass(frozen=True, slots=True)
class _Trunk:
    """The part of a tree that all further paths share.

    ``paths.incoming`` is the product of weights beyond the reconnection vertex.
    """

    paths: Paths

    def grown(self, step: Step, vertex: int, leaving: Leaving, after: Step) -> "_Trunk":
        """Over x_v, which becomes the reconnection vertex if it is the first to do."""
        bsdf, paths = leaving.bsdf, self.paths
        begins = step.joinable & ~bsdf.delta & (paths.joint == 0)
        passed = (paths.joint > 0)[:, None]
        incoming = np.where(passed, paths.incoming * after.weight, paths.incoming)
        density = density_at(step, after.pdf)
        exactly = after.joinable[:, None]
        grown = replace(paths, incoming=incoming)
        here = replace(
            grown,
            joint=np.full(len(paths), vertex, np.int8),
            surface=step.points,
            wi=np.where(exactly, -after.points.wo, bsdf.wi),
            incoming=np.ones_like(incoming),
            density=density,
        )
        return _Trunk(where(begins, here, grown))
