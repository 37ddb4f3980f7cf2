"""Initial candidates: a tree of paths a pixel, of which one is kept."""

from dataclasses import dataclass, replace

import numpy as np

from extensions.connection import Criterion
from extensions.paths import Paths, Technique, no_paths
from extensions.walking import Leaving, Step, arrive, leave, start
from reference.arrays import Indices, Masks, Scalars, Vec3s
from reference.direct_light import choose_light, met_lights, share_of_chance
from reference.records import scatter, where
from reference.resampling.reservoir import Candidates, merge
from reference.resampling.target import luminance
from reference.rng import Draw, Uniforms
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

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N visible points x_1.
    bounces : int
        Of indirect light, at least 1: surface points after x_1 that a path may visit.
    criterion : Criterion
        When points may be joined.
    number : (N,) int64
        Keys of the paths.
    uniforms : Uniforms
        N rows, made from these keys.  Vertex v takes dimension 2 (v - 1) for its
        direction and 2 (v - 1) + 1 for its light; lanes 3 choose within the tree.

    Returns
    -------
    Candidates
        Of `Paths`; w is the light of the whole tree, M = 1 for trees without light.

    Notes
    -----
    Paths of other lengths, or that end otherwise, are other integrals: each is drawn
    once, so that w = p̂(u), the luminance of f / p, without a weight.
    """
    size = len(points)
    nothing = Candidates(
        no_paths(points, number), np.zeros(size), np.zeros(size), np.zeros(size)
    )
    kept, step, trunk = nothing, start(points), _Trunk(no_paths(points, number))
    for vertex in range(1, bounces + 2):
        is_last = vertex == bounces + 1
        if vertex > 1:
            u = uniforms.draw(2 * vertex - 1)
            found = _chosen(world, step, trunk, vertex, u)
            kept = _streamed(kept, found, u[3])
        if is_last and not (world.emitters and world.emitters.can_be_hit):
            break
        leaving = leave(world, step, vertex, uniforms, step.points.hit)
        if vertex > 1:
            found = _by_chance(world, step, trunk, vertex, leaving)
            kept = _streamed(kept, found, uniforms.draw(2 * (vertex - 1))[3])
        if is_last:
            break
        before, step = step, arrive(world, criterion, step, vertex, leaving)
        if vertex > 1:
            trunk = trunk.grown(before, vertex, leaving, step)
        if not step.points.hit.any():
            break
    return Candidates(kept.y, kept.p_hat, kept.w, np.ones(size))


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
        density = _density(step, after.pdf)
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


def _density(step: Step, pdf: Scalars | float) -> Scalars:
    assert step.came is not None
    density: Scalars = step.pdf * step.came.spread * pdf
    return density


def _chosen(world: World, step: Step, trunk: _Trunk, vertex: int, u: Draw) -> Paths:
    """Paths that end at x_v by next-event estimation."""
    light = choose_light(world, step.points, u)
    here = step.joinable & (trunk.paths.joint == 0)
    return _ended(
        step,
        trunk,
        vertex,
        Technique.NEXT_EVENT,
        here,
        light.wi,
        np.where(light.seen[:, None], light.weight, 0.0),
        light.value,
        light.pdf,
        _density(step, 1.0),
    )


def _by_chance(
    world: World, step: Step, trunk: _Trunk, vertex: int, leaving: Leaving
) -> Paths:
    """Paths that end at x_v since its ray met a light."""
    bsdf = leaving.bsdf
    rows, some, by_choice = met_lights(world, step.points, bsdf, leaving.hits)
    size = len(step.points)
    radiance, pdf_light = scatter(rows, some, size), scatter(rows, by_choice, size)
    share = share_of_chance(bsdf.pdf, bsdf.delta, pdf_light)
    here = step.joinable & ~bsdf.delta & (trunk.paths.joint == 0)
    return _ended(
        step,
        trunk,
        vertex,
        Technique.CHANCE,
        here,
        bsdf.wi,
        radiance,
        bsdf.weight * radiance * share[:, None],
        pdf_light,
        _density(step, bsdf.pdf),
    )


def _ended(
    step: Step,
    trunk: _Trunk,
    vertex: int,
    technique: Technique,
    here: Masks,
    wi: Vec3s,
    radiance: Vec3s,
    reflected: Vec3s,
    pdf_light: Scalars,
    density: Scalars,
) -> Paths:
    """Paths with a light after x_v, which is the reconnection vertex ``here``."""
    paths, size = trunk.paths, len(step.points)
    longer = replace(paths, incoming=paths.incoming * reflected)
    joined = replace(
        paths,
        joint=np.full(size, vertex, np.int8),
        surface=step.points,
        wi=wi,
        incoming=radiance,
        pdf_light=pdf_light,
        density=density,
    )
    found: Paths = where(here, joined, longer)
    return replace(
        found,
        end=np.full(size, vertex, np.int8),
        technique=np.full(size, technique, np.int8),
        value=step.throughput * reflected,
    )


def _streamed(kept: Candidates, found: Paths, u: Scalars) -> Candidates:
    """Another path of the tree competes."""
    p_hat = luminance(found.value)
    M = np.zeros(len(found))
    return merge(kept, Candidates(found, p_hat, p_hat, M), u)
