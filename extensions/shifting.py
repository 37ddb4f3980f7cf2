"""The hybrid shift of whole paths: random replay, reconnection, and both in one.

[Lin22, section 7].  A path belongs to a pixel, and is shifted to another: the random
numbers that drew it are replayed from the other visible point, up to the vertex before
its reconnection vertex; there the two are connected, and the rest is shared.  A path
without reconnection vertex is replayed whole.  What makes a vertex a reconnection
vertex is tested on the offset path as it was on the base path: so the shift back leads
to where it came from, or does not exist.

The page follows that order: the record of a path, the reconnection criterion, one
vertex of random replay, the shift.  Paths are x_1 - x_2 - ... - x_end - light, where
the pixel sees x_1, and c is the index of the reconnection vertex.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    zero_vectors,
)
from restir_gi.reference.numerics.records import scatter, take, where
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.resampling.generalized import Shifted
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.hits import Hits, surface_points
from restir_gi.reference.scene.materials.bsdf_sampling import BsdfSamples, sample
from restir_gi.reference.scene.materials.parameters import Kind, MaterialTable
from restir_gi.reference.scene.materials.table import pdf, scattering
from restir_gi.reference.scene.origins import contact, step_before
from restir_gi.reference.scene.surface import SurfacePoints, direction_and_distance
from restir_gi.reference.transport.direct_light import (
    balance,
    bsdf_sampling_weight,
    choose_light,
    emitter_hits,
    light_sampling_weight,
)
from restir_gi.reference.transport.world import World

NEVER_JOINED = (Kind.SMOOTH_CONDUCTOR, Kind.DIELECTRIC, Kind.ROUGH_DIELECTRIC)
"""Kinds that scatter into single directions alone, and those that see both sides."""


# ------------------------------------------------------------ what is kept of a path


class Technique(IntEnum):
    """How a path found its light."""

    NOTHING = 0
    NEXT_EVENT = 1
    EMITTER_HIT = 2


@dataclass(frozen=True, slots=True)
class Paths:
    """N paths, as samples: what is kept of one, so that another pixel can reuse it.

    Attributes
    ----------
    number : (N,) int64
        Key of the random numbers: with them, and x_1, the path can be drawn again.
    end : (N,) int8; index of the last surface point, at least 2; 0 for no path
    technique : (N,) int8; `Technique` by which x_end found its light
    joint : (N,) int8
        Index c of the reconnection vertex x_c, from which on the path is shared; 0
        where there is none, and the whole path is replayed.
    surface : SurfacePoints; x_c, as it was seen from x_(c-1)
    wi : (N, 3) float64; unit direction from x_c to the next point, or to the light
    incoming : (N, 3) float64
        What arrives at x_c from there.  Where light follows x_c: its radiance, for
        next-event estimation over the density of the choice, W/(m² sr).  Else all
        that comes after x_c, each factor over its density.
    pdf_light : (N,) float64, 1/sr
        Where light follows x_c: density with which next-event estimation chooses it.
    density : (N,) float64
        With which x_(c-1) and x_c chose their directions: p(ω_(c-1)) cos φ_c / d² of
        the one, per area, times p(ω_c) of the other, which is 1 for next-event
        estimation.
    value : (N, 3) float64, W/(m² sr)
        Contribution f / p at the pixel: integrand in primary sample space.
    """

    number: Indices
    end: Indices
    technique: Indices
    joint: Indices
    surface: SurfacePoints
    wi: Vec3s
    incoming: Vec3s
    pdf_light: Scalars
    density: Scalars
    value: Vec3s

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.number)

    @property
    def there(self) -> Masks:
        """(N,) bool: there is a path at all."""
        found: Masks = self.end > 0
        return found

    def moved(self, value: Vec3s, jacobian: Scalars) -> "Paths":
        """The same paths from other pixels.

        Parameters
        ----------
        value : (N, 3) float64; there
        jacobian : (N,) float64, sr/sr; of the shift

        Returns
        -------
        Paths; densities at the joint change as the Jacobian says
        """
        joined = self.joint > 0
        density = np.where(joined, self.density * jacobian, self.density)
        return replace(self, value=value, density=density)


# --------------------------------------------------------- the reconnection criterion


@dataclass(frozen=True, slots=True)
class Criterion:
    """When two neighbouring points of a path may be joined.

    Attributes
    ----------
    roughness : float
        Least perceptual roughness of both, the root of the GGX width; ``inf`` for
        never.
    distance : float; least distance of both, in half extents of the scene
    last_joint : int; largest index of a reconnection vertex
    replays : bool
        Whether what cannot be joined at x_2 is replayed; else it is not shifted.
    """

    roughness: float = 0.2
    distance: float = 0.01
    last_joint: int = 127
    replays: bool = True


def roughness(table: MaterialTable, points: SurfacePoints) -> Scalars:
    """Perceptual roughness of all lobes that are no delta lobes.

    The thresholds of the literature are in this unit; alpha is its square.

    Returns
    -------
    (N,) float64
        1 for diffuse surfaces and for the base under a smooth coat, √alpha for
        microfacets, −1 for what scatters into single directions alone, for rough
        dielectrics, which see both sides, and for misses.
    """
    kind = table.kind
    diffuse = (kind == Kind.LAMBERTIAN) | (kind == Kind.SMOOTH_COATED)
    single = np.isin(kind, NEVER_JOINED)
    rough = np.where(diffuse, 1.0, np.where(single, -1.0, np.sqrt(table.alpha)))
    return np.where(points.hit, rough[points.material], -1.0)


@dataclass(frozen=True, slots=True)
class Segment:
    """From one point of a path to the next, N rows.

    Attributes
    ----------
    distance : (N,) float64, m; between them
    spread : (N,) float64, 1/m²
        cos φ / d² at the second: solid angle that its area fills.
    joinable : (N,) bool
        The criterion holds, if both leave by lobes that are no delta lobes.
    """

    distance: Scalars
    spread: Scalars
    joinable: Masks


def segment(
    criterion: Criterion,
    geometry: Geometry,
    x_from: SurfacePoints,
    x_to: SurfacePoints,
) -> tuple[SurfacePoints, Segment]:
    """The segment from one point to another, as the first point sees it.

    Returns
    -------
    SurfacePoints
        The second, as the first sees it: ``wo`` points back.  The direction is that
        from point to point; a ray's differs by the rounding of its hit.
    Segment
        The same for base path and offset path; not joinable where a point is a miss.
    """
    x_s = contact(geometry, x_to)
    omega, distance = direction_and_distance(x_from.position, x_s)
    offset = step_before(geometry, x_to.primitive, x_to.normal, -omega)
    seen = replace(x_to, wo=-omega, position=x_s + offset)
    cosine = np.abs(dot(x_to.normal, omega))
    spread = divide_or_zero(cosine, distance**2)
    table = geometry.materials
    rough = np.minimum(roughness(table, x_from), roughness(table, x_to))
    far = distance > criterion.distance * geometry.extent
    joinable = (distance > 0) & far & (rough >= max(criterion.roughness, 0.0))
    return seen, Segment(distance, spread, joinable)


# ---------------------------------------------------- random replay, vertex by vertex


@dataclass(frozen=True, slots=True)
class Step:
    """A point x_v of N walks, and how they came to it.

    Attributes
    ----------
    points : SurfacePoints; x_v; misses where a walk has ended
    throughput : (N, 3) float64; product of f cos θ / p of x_1 to x_(v-1)
    weight : (N, 3) float64; the last of these factors
    came : Segment or None; from x_(v-1); ``None`` at x_1
    joinable : (N,) bool
        x_v may be a reconnection vertex, if it is left by no delta lobe.
    pdf : (N,) float64, 1/sr
        Density of the direction in which x_(v-1) was left; 0 for a delta lobe.
    """

    points: SurfacePoints
    throughput: Vec3s
    weight: Vec3s
    came: Segment | None
    joinable: Masks
    pdf: Scalars


@dataclass(frozen=True, slots=True)
class Leaving:
    """Directions in which N walks leave a point, and what they meet."""

    bsdf: BsdfSamples
    hits: Hits


def start(points: SurfacePoints) -> Step:
    """Walks that have not left their visible points.

    Parameters
    ----------
    points : SurfacePoints; N visible points x_1
    """
    size = len(points)
    return Step(
        points,
        1.0 + zero_vectors(size),
        1.0 + zero_vectors(size),
        None,
        np.zeros(size, bool),
        np.zeros(size),
    )


def leave(
    world: World, step: Step, vertex: int, uniforms: Uniforms, active: Masks
) -> Leaving:
    """Draw directions and trace them.

    Parameters
    ----------
    uniforms : Uniforms; N rows; dimension 2 (v - 1) draws the direction
    active : (N,) bool; which walks go on
    """
    bsdf = sample(world.materials, step.points, uniforms.draw(2 * (vertex - 1)))
    goes_on = active & step.points.hit & (dot(bsdf.weight, bsdf.weight) > 0)
    hits = world.caster.from_surface(step.points, bsdf.wi, goes_on, "bounce")
    return Leaving(bsdf, hits)


def advance(
    world: World, criterion: Criterion, step: Step, vertex: int, leaving: Leaving
) -> Step:
    """Go on to what the rays met.

    Returns Step; x_(v+1).
    """
    bsdf = leaving.bsdf
    met = surface_points(world.geometry, leaving.hits, step.points.position, bsdf.wi)
    seen, came = segment(criterion, world.geometry, step.points, met)
    joinable = came.joinable & ~bsdf.delta & (vertex < criterion.last_joint)
    weight, density = bsdf.weight, bsdf.pdf
    if joinable.any():
        # What may be joined is the point, not the ray.
        wo, position = (
            where(joinable, a, b)
            for a, b in ((seen.wo, met.wo), (seen.position, met.position))
        )
        met = replace(met, wo=wo, position=position)
        value = scattering(world.materials, step.points, -wo)
        density = np.where(joinable, pdf(world.materials, step.points, -wo), density)
        exact = divide_or_zero(value, density[:, None])
        weight = where(joinable, exact, weight)
    return Step(met, step.throughput * weight, weight, came, joinable, density)


# --------------------------------------------------------------------- the hybrid shift


@dataclass(frozen=True, slots=True)
class Shift:
    """Where paths are reconnected, and from which random numbers they are replayed.

    Attributes
    ----------
    uniforms : callable; random numbers of the paths that have the given numbers
    """

    criterion: Criterion
    uniforms: Callable[[Indices], Uniforms]

    def __call__(
        self,
        world: World,
        points: SurfacePoints,
        at: Indices,
        paths: Paths,
        rows: Indices,
    ) -> tuple[Vec3s, Scalars]:
        """Shift paths to other visible points [Lin22, section 7.2].

        Replayed vertices keep their random numbers, and add the factor 1.  At the joint
        p(ω_(c-1)) cos φ_c / d² p(ω_c) of the offset path is divided by the same of the
        base path.

        Parameters
        ----------
        at : (N,) int; which of the points the paths go to
        rows : (N,) int; which of the base paths are shifted

        Returns
        -------
        value : (N, 3) float64, W/(m² sr)
            f / p at the new point; 0 where the path does not exist there: out of sight,
            below a horizon, of another length, or joinable elsewhere.
        jacobian : (N,) float64
            |∂u_to / ∂u_from| in primary sample space; 0 where there is no such path.
        """
        value, density = zero_vectors(len(rows)), np.zeros(len(rows))
        joint = paths.joint[rows]
        able = (points.primitive[at] >= 0) & (paths.end[rows] > 0)
        # c = 2: x_1 is connected as it is.
        here = np.flatnonzero(able & (joint == 2))
        if len(here):
            step = start(take(points, at[here]))
            some = take(paths, rows[here])
            value[here], density[here] = self._reconnect(world, step, some, 1)
        # c > 2, or none: random replay comes first.
        going = able & (joint != 2) & self.criterion.replays
        here = np.flatnonzero(going)
        if len(here):
            step = start(take(points, at[here]))
            some = take(paths, rows[here])
            value[here], density[here] = self._replay(world, step, some)
        # The Jacobian: the offset path's density over the base path's.
        base = np.where(joint > 0, paths.density[rows], 1.0)
        return value, divide_or_zero(density, base)

    def _replay(self, world: World, step: Step, paths: Paths) -> tuple[Vec3s, Scalars]:
        """Value and density of paths that are joined later than x_2, or never."""
        value, density = zero_vectors(len(paths)), np.zeros(len(paths))
        rows: Indices = np.arange(len(paths))
        vertex = 1
        while len(rows):
            # x_(v+1), from the base path's numbers: no joint before the base path's.
            everyone = np.ones(len(rows), bool)
            leaving = leave(world, step, vertex, self.uniforms(paths.number), everyone)
            same = ~(step.joinable & ~leaving.bsdf.delta)
            step = advance(world, self.criterion, step, vertex, leaving)
            rows, paths, step = _kept(same & step.points.hit, rows, paths, step)
            vertex += 1
            # Those whose next vertex is x_c are connected; others may end at x_v.
            joins = paths.joint == vertex + 1
            ends = (paths.joint == 0) & (paths.end == vertex)
            for here, finish in (
                (joins, self._reconnect),
                (ends, self._replay_to_light),
            ):
                at, part, there = _kept(here, rows, paths, step)
                if len(at):
                    value[at], density[at] = finish(world, there, part, vertex)
            rows, paths, step = _kept(~(joins | ends), rows, paths, step)
        return value, density

    def _reconnect(
        self, world: World, step: Step, paths: Paths, vertex: int
    ) -> tuple[Vec3s, Scalars]:
        """Value and density of paths that are joined to x_(v+1)."""
        # From x_v to x_c, which is v + 1 here.
        x, table = step.points, world.materials
        there, came = segment(self.criterion, world.geometry, x, paths.surface)
        omega = -there.wo
        # The domain: joined here as the base path was, from the same side, not before.
        fits = came.joinable & ~step.joinable & (dot(there.normal, omega) < 0)
        # Both vertices scatter in the new directions.
        left = scattering(table, x, omega)
        p_left = np.where(fits, pdf(table, x, omega), 0.0)
        onward = scattering(table, there, paths.wi)
        chosen = paths.technique == Technique.NEXT_EVENT
        last = paths.end == paths.joint
        p_onward = pdf(table, there, paths.wi)
        share = np.where(
            chosen,
            light_sampling_weight(world, there, paths.wi, paths.pdf_light),
            balance(p_onward, paths.pdf_light),
        )
        # A chosen light keeps its numbers: the joint does not touch them.
        p_onward = np.where(last & chosen, 1.0, p_onward)
        # f / p: up to x_v, at x_v, at x_c, and all that is shared.
        weight = divide_or_zero(left, p_left[:, None])
        weight = weight * divide_or_zero(onward, p_onward[:, None])
        weight = weight * np.where(last, share, 1.0)[:, None]
        value = step.throughput * weight * paths.incoming
        value = np.where(fits[:, None], value, 0.0)
        # One shadow ray, for those that would shine.
        shines: Masks = np.any(value > 0, axis=1)
        x_s = contact(world.geometry, there)
        seen = world.caster.visible(x, x_s, there.normal, shines, "reuse")
        return (
            np.where(seen[:, None], value, 0.0),
            np.where(seen & fits, p_left * came.spread * p_onward, 0.0),
        )

    def _replay_to_light(
        self, world: World, step: Step, paths: Paths, vertex: int
    ) -> tuple[Vec3s, Scalars]:
        """Value of paths that end at x_v; in their own random numbers J is 1."""
        x, uniforms = step.points, self.uniforms(paths.number)
        chosen = paths.technique == Technique.NEXT_EVENT
        value, fits = zero_vectors(len(paths)), np.zeros(len(paths), bool)
        if chosen.any():
            active = chosen & x.hit & ~step.joinable
            light = choose_light(world, x, uniforms.draw(2 * vertex - 1), active)
            value, fits = light.value, active
        if not chosen.all():
            leaving = leave(world, step, vertex, uniforms, ~chosen & x.hit)
            bsdf = leaving.bsdf
            active = ~chosen & ~(step.joinable & ~bsdf.delta)
            rows, radiance, p_light = emitter_hits(world, x, bsdf, leaving.hits)
            share = bsdf_sampling_weight(bsdf.pdf[rows], bsdf.delta[rows], p_light)
            met = scatter(rows, radiance * share[:, None], len(paths))
            value = np.where(active[:, None], bsdf.weight * met, value)
            fits = fits | active
        value = step.throughput * value
        return value, (fits & value.any(axis=1)).astype(float)


def _kept(
    mask: Masks, rows: Indices, paths: Paths, step: Step
) -> tuple[Indices, Paths, Step]:
    """Some of the rows; without a copy, if they are all."""
    if mask.all():
        return rows, paths, step
    at = np.flatnonzero(mask)
    return rows[at], take(paths, at), take(step, at)


@dataclass(frozen=True, slots=True, eq=False)
class PathNeighbor:
    """Pixels whose reservoirs of paths others resample; each sees one point.

    Attributes
    ----------
    world, points : World, SurfacePoints; of the K receivers
    world_from, points_from : World, SurfacePoints
        In which the N paths were made, and what their pixels saw.
    reservoirs : Reservoirs; N rows of `Paths`
    rows : (K,) int; row that each receiver resamples, or ``NONE``
    same_domain : bool; neighbour and receiver are one point, and nothing is shifted
    """

    shift: Shift
    world: World
    points: SurfacePoints
    world_from: World
    points_from: SurfacePoints
    reservoirs: Reservoirs
    rows: Indices
    same_domain: bool = False

    def unshifted(self, at: Indices) -> Vec3s:
        """Value of the neighbours' paths where they are, (A, 3)."""
        return take(self.reservoirs.y.value, self.rows[at])

    def shifted(self, at: Indices) -> Shifted:
        """The neighbours' paths at the receivers ``at``, which all have one, (A,)."""
        paths, rows = self.reservoirs.y, self.rows[at]
        return self.shift(self.world, self.points, at, paths, rows)

    def inverse(self, samples: Any, at: Indices) -> Shifted:
        """The receivers' paths ``at`` back at their neighbours, (A,)."""
        rows = self.rows[at]
        return self.shift(self.world_from, self.points_from, rows, samples, at)
