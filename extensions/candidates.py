"""Initial candidates: a tree of paths a pixel, of which one is kept.

Every vertex may end a path, with a light that is chosen by next-event estimation or hit
by the ray that goes on.  A path and its reconnection vertex are recorded on the way.
"""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.extensions.shifting import (
    Criterion,
    Leaving,
    Paths,
    Step,
    Technique,
    advance,
    leave,
    start,
)
from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    zero_vectors,
)
from restir_gi.reference.numerics.records import scatter, where
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.resampling.reservoir import Candidates, merge
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.direct_light import (
    bsdf_sampling_weight,
    choose_light,
    emitter_hits,
)
from restir_gi.reference.transport.world import World


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
        may_hit = not is_last or world.seeks_lights
        active = step.points.hit & may_hit
        leaving = leave(world, step, vertex, uniforms, active)
        if vertex > 1:
            # Paths that end at x_v.
            met = leaving if may_hit else None
            lights = find_lights(world, step, vertex, uniforms, met)
            found = replace(lights, y=ended(step, trunk.paths, vertex, lights.y))
            u = uniforms.draw(2 * vertex - 1)[3]
            kept = found if kept is None else merge(kept, found, u)
        if is_last:
            break
        # On to x_(v+1).
        before, step = step, advance(world, criterion, step, vertex, leaving)
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


def no_paths(points: SurfacePoints, number: Indices) -> Paths:
    """Paths without a light, of keys ``number``, (N,), and any points."""
    size = len(number)
    none = np.zeros(size, np.int8)
    return Paths(
        number=number,
        end=none,
        technique=none,
        joint=none,
        surface=points,
        wi=zero_vectors(size),
        incoming=zero_vectors(size),
        pdf_light=np.zeros(size),
        density=np.zeros(size),
        value=zero_vectors(size),
    )


@dataclass(frozen=True, slots=True)
class Lights:
    """Lights that end N paths, as their last points receive them.

    Attributes
    ----------
    technique : (N,) int8; how they were found
    joins : (N,) bool; the last point may be a reconnection vertex
    wi : (N, 3) float64; unit directions to them
    radiance : (N, 3) float64
        Radiance, over the density of the choice where they were chosen.
    reflected : (N, 3) float64, W/(m² sr)
        By the last point, over its density, and weighted.
    pdf_light : (N,) float64, 1/sr; with which next-event estimation chooses them
    pdf : (N,) float64, 1/sr
        With which the path chose its direction to the light, 1 where the light itself
        was chosen.
    """

    technique: Indices
    joins: Masks
    wi: Vec3s
    radiance: Vec3s
    reflected: Vec3s
    pdf_light: Scalars
    pdf: Scalars


def find_lights(
    world: World, step: Step, vertex: int, uniforms: Uniforms, leaving: Leaving | None
) -> Candidates:
    """One light for each path at x_v, chosen or hit.

    Parameters
    ----------
    uniforms : Uniforms
        N rows; dimension 2 (v - 1) + 1 chooses the light, lane 3 of the one before
        between the two.
    leaving : Leaving or None; rays that left x_v; ``None`` where none may hit a light

    Returns
    -------
    Candidates
        Of `Lights`; the two are other integrals, so that w = p̂, and M counts none.
    """
    size, none = len(step.points), np.zeros(len(step.points))
    light = choose_light(world, step.points, uniforms.draw(2 * vertex - 1))
    chosen = Lights(
        technique=np.full(size, Technique.NEXT_EVENT, np.int8),
        joins=step.joinable,
        wi=light.wi,
        radiance=np.where(light.seen[:, None], light.weight, 0.0),
        reflected=light.value,
        pdf_light=light.pdf,
        pdf=np.ones(size),
    )
    p_hat = luminance(step.throughput * chosen.reflected)
    lights = Candidates(chosen, p_hat, p_hat, none)
    if leaving is None:
        return lights
    bsdf = leaving.bsdf
    rows, some, p_light = emitter_hits(world, step.points, bsdf, leaving.hits)
    radiance, pdf_light = scatter(rows, some, size), scatter(rows, p_light, size)
    weight = bsdf_sampling_weight(bsdf.pdf, bsdf.delta, pdf_light)
    hit = Lights(
        technique=np.full(size, Technique.EMITTER_HIT, np.int8),
        joins=step.joinable & ~bsdf.delta,
        wi=bsdf.wi,
        radiance=radiance,
        reflected=bsdf.weight * radiance * weight[:, None],
        pdf_light=pdf_light,
        pdf=bsdf.pdf,
    )
    p_hat = luminance(step.throughput * hit.reflected)
    u = uniforms.draw(2 * (vertex - 1))[3]
    return merge(lights, Candidates(hit, p_hat, p_hat, none), u)


def ended(step: Step, paths: Paths, vertex: int, lights: Lights) -> Paths:
    """Paths with a light after x_v, which is the reconnection vertex if it can be.

    Parameters
    ----------
    paths : Paths
        What is known of them, ``incoming`` being the product of weights beyond the
        reconnection vertex.
    """
    size = len(step.points)
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
                (density_at(step, lights.pdf), density),
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


def density_at(step: Step, pdf: Scalars) -> Scalars:
    """Density of both ends of a joint at x_v.

    Parameters
    ----------
    step : Step; N paths at x_v, that came from x_(v-1)
    pdf : (N,) float64, 1/sr; with which x_v is left; 1 where the light was chosen

    Returns
    -------
    (N,) float64; p(ω_(v-1)) cos φ_v / d² p(ω_v)
    """
    assert step.came is not None
    density: Scalars = step.pdf * step.came.spread * pdf
    return density
