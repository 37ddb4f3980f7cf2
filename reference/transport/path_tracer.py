"""The plain estimator that everything must agree with.

A path is camera - x1 - x2 - ... - x(k+1) - light.  Emission seen at x1, and light that
reaches x1 straight from a light, are *direct*; "k-bounce indirect" are the paths with a
surface point x2 up to x(k+1) between.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    dot,
    zero_vectors,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.scene.camera import camera_rays
from restir_gi.reference.scene.emitters import emitted
from restir_gi.reference.scene.hits import surface_points
from restir_gi.reference.scene.materials.bsdf_sampling import BsdfSamples, sample
from restir_gi.reference.scene.materials.table import can_scatter
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.direct_light import next_event, weighted_emitter_hits
from restir_gi.reference.transport.world import World

Light = Literal["indirect", "direct", "full"]

FEW_DEAD = 0.75
"""Share of paths alive above which dead ones are not sorted out."""

MAX_BOUNCES = 30
"""Vertices that a stream of 64 dimensions can feed, two a vertex."""


def first_hits(world: World, x: Scalars, y: Scalars) -> SurfacePoints:
    """What the camera sees through points of the image.

    Parameters
    ----------
    x, y : (N,) float64, pixels; points of the image
    """
    origin, direction = camera_rays(world.camera, x, y)
    hits = world.caster.from_camera(origin, direction)
    return surface_points(world.geometry, hits, origin, direction)


def follow(
    world: World, points: SurfacePoints, direction: Vec3s, active: Masks, kind: str
) -> SurfacePoints:
    """What rays that leave surface points meet first [Ouyang21, Eq. 2].

    Parameters
    ----------
    direction : (N, 3) float64; unit vectors
    active : (N,) bool; which rays are traced

    Returns
    -------
    SurfacePoints; N rows; misses where no ray was traced
    """
    hits = world.caster.from_surface(points, direction, active, kind)
    return surface_points(world.geometry, hits, points.position, direction)


def reflected_radiance(
    world: World,
    points: SurfacePoints,
    bounces: int,
    uniforms: Uniforms,
    skip_direct: bool = False,
    first: BsdfSamples | None = None,
    tail: Scalars | None = None,
    tail_begins: int = 0,
) -> Vec3s:
    """Radiance that surface points scatter towards their viewers, one path each.

    [Ouyang21, Eq. 3].

    Parameters
    ----------
    points : SurfacePoints; N points x; misses scatter nothing
    bounces : int; surface points that a path may visit after x; 0 is direct light alone
    uniforms : Uniforms
        N rows.  Vertex i after x takes dimension 2i for its direction and 2i + 1 for
        its light.
    skip_direct : bool; leave out light that reaches x straight from a light
    first : BsdfSamples or None
        Directions in which the paths leave x, where the caller has chosen them.
    tail : (N,) float64 or None
        Russian roulette: weight of all that lies beyond vertex ``tail_begins``, 0 where
        the path ends there; ``None`` for 1.
    tail_begins : int; the last vertex that every path reaches

    Returns
    -------
    (N, 3) float64, W/(m² sr); without emission of x itself
    """
    radiance = zero_vectors(len(points))
    walk = _Walk(
        np.arange(len(points)), points, 1.0 + zero_vectors(len(points)), uniforms
    )
    walk = walk.pruned(can_scatter(world.materials, points))
    for vertex in range(bounces + 1):
        if len(walk.rows) == 0:
            break
        counts = not (skip_direct and vertex == 0)
        # Light that x receives straight from a light it has chosen ...
        if counts:
            u = walk.uniforms.draw(2 * vertex + 1)
            light = next_event(world, walk.points, u)
            walk.add(radiance, walk.throughput * light)
        is_last = vertex == bounces
        if is_last and not world.seeks_lights:
            break
        # ... and from lights that a ray drawn from its material meets.
        if first is not None and vertex == 0:
            bsdf = take(first, walk.rows)
        else:
            u = walk.uniforms.draw(2 * vertex)
            bsdf = sample(world.materials, walk.points, u)
        goes_on = walk.points.hit & (dot(bsdf.weight, bsdf.weight) > 0)
        hits = world.caster.from_surface(walk.points, bsdf.wi, goes_on, "bounce")
        throughput = walk.throughput * bsdf.weight
        if counts:
            found, light = weighted_emitter_hits(world, walk.points, bsdf, hits)
            radiance[walk.rows[found]] += throughput[found] * light
        if is_last:
            break
        # Walk on where there is a surface, and roulette lets the path live.
        met = surface_points(world.geometry, hits, walk.points.position, bsdf.wi)
        alive = met.hit
        if tail is not None and vertex == tail_begins:
            throughput = throughput * tail[walk.rows, None]
            alive = alive & (tail[walk.rows] > 0)
        walk = _Walk(walk.rows, met, throughput, walk.uniforms).pruned(alive)
    return radiance


@dataclass(frozen=True, slots=True)
class _Walk:
    """Paths on their way: row of the frame, last vertex, product of weights."""

    rows: Indices
    points: SurfacePoints
    throughput: Vec3s
    uniforms: Uniforms

    def add(self, radiance: Vec3s, light: Vec3s) -> None:
        if len(self.rows) == len(radiance):
            radiance += light
        else:
            radiance[self.rows] += light

    def pruned(self, alive: Masks) -> "_Walk":
        # Dead rows scatter nothing and trace no ray: a few cost less than a copy.
        some = np.flatnonzero(alive)
        if len(some) > FEW_DEAD * len(alive):
            return self
        return _Walk(
            self.rows[some],
            take(self.points, some),
            self.throughput[some],
            self.uniforms.rows(some),
        )


def camera_radiance(
    world: World,
    points: SurfacePoints,
    light: Light,
    bounces: int,
    uniforms: Uniforms,
) -> Vec3s:
    """One path-traced sample of the radiance that reaches the camera.

    The rendering equation [Kajiya86, Eq. 1; Ouyang21, Eq. 1].

    Parameters
    ----------
    bounces : int; bounces of indirect light, 0 to 30

    Returns
    -------
    (N, 3) float64, W/(m² sr); unbiased
    """
    if light == "indirect":
        if bounces == 0:
            return zero_vectors(len(points))
        return reflected_radiance(world, points, bounces, uniforms, skip_direct=True)
    seen = emitted(world.emitters, world.geometry, points)
    deeper = bounces if light == "full" else 0
    return seen + reflected_radiance(world, points, deeper, uniforms)
