"""Initial candidates: a tree of paths a pixel, of which one is kept."""

from dataclasses import dataclass, replace

import numpy as np

from extensions.connection import Criterion
from extensions.paths import Paths, Technique, no_paths
from extensions.walking import Leaving, Step, arrive, leave, start
from reference.arrays import Indices, Masks, Scalars, Vec3s
from reference.direct_light import choose_light, met_lights
from reference.light_shares import share_of_chance
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
    step, trunk = start(points), _Trunk(no_paths(points, number))
    kept: Candidates | None = None
    for vertex in range(1, bounces + 2):
        is_last = vertex == bounces + 1
        by_chance = not is_last or (
            world.emitters is not None and world.emitters.can_be_hit
        )
        active = step.points.hit & by_chance
        leaving = leave(world, step, vertex, uniforms, active)
        if vertex > 1:
            u = uniforms.draw(2 * vertex - 1)
            lights = _chosen(world, step, u)
            if by_chance:
                other = uniforms.draw(2 * (vertex - 1))[3]
                lights = merge(lights, _met(world, step, leaving), other)
            found = replace(lights, y=_ended(step, trunk, vertex, lights.y))
            kept = found if kept is None else merge(kept, found, u[3])
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


@dataclass(frozen=True, slots=True)
class _Lights:
    """Lights that end N paths, as their last points receive them.

    ``pdf`` is the density with which the path chose its direction to the light, 1 where
    the light itself was chosen; ``joins`` tells whether the last point may be joined.
    """

    technique: Indices
    joins: Masks
    wi: Vec3s
    radiance: Vec3s
    reflected: Vec3s
    pdf_light: Scalars
    pdf: Scalars


def _chosen(world: World, step: Step, u: Draw) -> Candidates:
    """Lights by next-event estimation."""
    light, size = choose_light(world, step.points, u), len(step.points)
    found = _Lights(
        technique=np.full(size, Technique.NEXT_EVENT, np.int8),
        joins=step.joinable,
        wi=light.wi,
        radiance=np.where(light.seen[:, None], light.weight, 0.0),
        reflected=light.value,
        pdf_light=light.pdf,
        pdf=np.ones(size),
    )
    return _competing(step, found)


def _met(world: World, step: Step, leaving: Leaving) -> Candidates:
    """Lights that the rays met."""
    bsdf, size = leaving.bsdf, len(step.points)
    rows, some, by_choice = met_lights(world, step.points, bsdf, leaving.hits)
    radiance, pdf_light = scatter(rows, some, size), scatter(rows, by_choice, size)
    share = share_of_chance(bsdf.pdf, bsdf.delta, pdf_light)
    found = _Lights(
        technique=np.full(size, Technique.CHANCE, np.int8),
        joins=step.joinable & ~bsdf.delta,
        wi=bsdf.wi,
        radiance=radiance,
        reflected=bsdf.weight * radiance * share[:, None],
        pdf_light=pdf_light,
        pdf=bsdf.pdf,
    )
    return _competing(step, found)


def _competing(step: Step, lights: _Lights) -> Candidates:
    p_hat = luminance(step.throughput * lights.reflected)
    return Candidates(lights, p_hat, p_hat, np.zeros(len(p_hat)))


def _ended(step: Step, trunk: _Trunk, vertex: int, lights: _Lights) -> Paths:
    """Paths with a light after x_v, which is the reconnection vertex if it can be."""
    paths, size = trunk.paths, len(step.points)
    end, value = np.full(size, vertex, np.int8), step.throughput * lights.reflected
    known = paths.joint > 0
    here = lights.joins & ~known
    surface, wi, pdf_light = paths.surface, paths.wi, paths.pdf_light
    joint, density = paths.joint, paths.density
    incoming = paths.incoming * lights.reflected
    if here.any():
        surface = where(known, surface, step.points)
        joint = np.where(here, end, joint)
        wi, incoming, pdf_light, density = (
            where(here, a, b)
            for a, b in (
                (lights.wi, wi),
                (lights.radiance, incoming),
                (lights.pdf_light, pdf_light),
                (_density(step, lights.pdf), density),
            )
        )
    return replace(
        paths,
        end=end,
        technique=lights.technique,
        joint=joint,
        surface=surface,
        wi=wi,
        incoming=incoming,
        pdf_light=pdf_light,
        density=density,
        value=value,
    )
