"""One vertex of eye paths: draw lights, take over others, look once, and go on."""

from dataclasses import dataclass

import numpy as np

from hashgrid.cache import find
from hashgrid.light_candidates import keep_one
from hashgrid.light_donor import Lent, LightDonor
from hashgrid.light_settings import LightSettings
from hashgrid.lights import in_sight, same_lights
from hashgrid.vertex_numbers import decisions, of_vertices
from reference.arrays import Indices, Masks, Vec3s, dot, zero_vectors
from reference.direct_light import found_by_chance
from reference.resampling.generalized import resample
from reference.resampling.reservoir import (
    Reservoirs,
)
from reference.rng import KeyedUniforms, Stream, Uniforms
from reference.scene.hits import surface_points
from reference.scene.materials.bsdf_sampling import BsdfSamples, sample
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True)
class Walk:
    """Paths on their way, K rows.

    Attributes
    ----------
    pixel : (K,) int64; whose
    throughput : (K, 3) float64; product of f cos θ / p of x_1 to x_(v-1)
    """

    pixel: Indices
    points: SurfacePoints
    throughput: Vec3s


@dataclass(frozen=True, slots=True)
class Visit:
    """What K paths leave at x_v, and how they go on.

    Attributes
    ----------
    reservoirs : Reservoirs or None
        Of `hashgrid.lights.LightPoints`; ``None`` where nobody asks for them.
    light : (K, 3) float64, W/(m² sr); added to the pixels
    onward : Walk; at x_(v+1); misses where a path has ended
    """

    reservoirs: Reservoirs | None
    light: Vec3s
    onward: Walk


@dataclass(frozen=True, slots=True, eq=False)
class Vertex:
    """How vertices of one number are visited.

    Attributes
    ----------
    frame, seed : int; of the random numbers
    number : int; v, from 1
    is_last : bool; no surface point follows
    lent : Lent or None; by the last frame
    """

    world: World
    settings: LightSettings
    frame: int
    seed: int
    number: int
    is_last: bool
    lent: Lent | None

    def visit(self, walk: Walk) -> Visit:
        """Light that arrives at x_v, and the way to x_(v+1).

        Light that x_1 receives straight from a light is not indirect, and left out; its
        reservoirs are for others.
        """
        kept: Reservoirs | None = None
        if self.number > 1 or self.settings.visible:
            u = self.keys(walk.pixel, Stream.LIGHTS)
            drawn = keep_one(self.world, walk.points, self.settings, u)
            kept = self._reused(walk, drawn)
        onward, met = self._onward(walk)
        light = zero_vectors(len(walk.pixel))
        if self.number > 1 and kept is not None:
            light = walk.throughput * (met + self._shaded(walk.points, kept))
        return Visit(kept, light, onward)

    def keys(self, pixel: Indices, stream: Stream) -> Uniforms:
        """Random numbers of vertices x_v.

        Parameters
        ----------
        pixel : (K,) int64; whose paths
        """
        return of_vertices(pixel, self.frame, self.number, self.seed, stream)

    def _reused(self, walk: Walk, drawn: Reservoirs) -> Reservoirs:
        """Resample with what the last frame left in the cells around."""
        s, here = self.settings, np.arange(len(walk.pixel))
        if self.lent is None or s.cells == 0:
            return drawn
        cache, uniforms = self.lent.cache, self.keys(walk.pixel, Stream.CELLS)
        now = self.world, walk.points
        same = same_lights(self.world.emitters, self.world.emitters)
        own = LightDonor(*now, *now, drawn, here, same, s.chance, same_domain=True)
        then, theirs = (cache.world, cache.points), self.lent.reservoirs
        others = [
            LightDonor(*now, *then, theirs, rows, self.lent.lights_from, s.chance)
            for rows in find(cache, walk.points, uniforms, s.cells, s.reuse)
        ]
        lanes = decisions(uniforms, len(others) + 1)
        return resample([own, *others], lanes, s.mis, s.cap)

    def _shaded(self, points: SurfacePoints, kept: Reservoirs) -> Vec3s:
        """One ray for the point that was kept."""
        shines = (kept.W > 0) & kept.y.value.any(axis=1)
        seen = in_sight(self.world, points, kept.y, shines)
        light: Vec3s = kept.y.value * np.where(seen, kept.W, 0.0)[:, None]
        return light

    def _onward(self, walk: Walk) -> tuple[Walk, Vec3s]:
        """Draw directions, trace them, and see which lights they meet."""
        world = self.world
        pixel = walk.pixel.astype(np.uint32)
        path = KeyedUniforms(pixel, self.frame, self.seed, Stream.PATH)
        bsdf = sample(world.materials, walk.points, path.draw(2 * (self.number - 1)))
        goes_on = walk.points.hit & (dot(bsdf.weight, bsdf.weight) > 0)
        if self.is_last:
            goes_on = goes_on & self._may_meet(bsdf)
        hits = world.caster.from_surface(walk.points, bsdf.wi, goes_on, "bounce")
        met = zero_vectors(len(walk.pixel))
        rows, radiance = found_by_chance(world, walk.points, bsdf, hits)
        counts = self._may_meet(bsdf)[rows, None]
        met[rows] = np.where(counts, bsdf.weight[rows] * radiance, 0.0)
        points = surface_points(world.geometry, hits, walk.points.position, bsdf.wi)
        onward = Walk(walk.pixel, points, walk.throughput * bsdf.weight)
        return onward, met

    def _may_meet(self, bsdf: BsdfSamples) -> Masks:
        """Whose rays may meet lights by chance."""
        emitters = self.world.emitters
        able = emitters is not None and emitters.can_be_hit
        if self.settings.chance == "balance":
            return np.full(len(bsdf.pdf), able)
        return bsdf.delta & able
