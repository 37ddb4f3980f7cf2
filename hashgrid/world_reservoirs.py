"""World-space reservoirs: light sampling at every vertex of eye paths.

[Boisse21].  Each vertex draws points on lights and keeps one (Algorithm 1), resamples
it with what vertices near it kept in the frame before, traces one shadow ray, and is
put into a cell for the next frame (Algorithm 2, on the page `restir_gi.hashgrid.grid`,
where its lines are counted).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from restir_gi.extensions.shifting import roughness
from restir_gi.hashgrid.grid import Cache, insert, lattice_of, look_up, vertex_uniforms
from restir_gi.hashgrid.light_settings import LightSettings
from restir_gi.hashgrid.lights import (
    Chance,
    LightPoints,
    draw_lights,
    hits_count,
    light_samples,
    reflected,
    reflected_hits,
    renumbered,
)
from restir_gi.reference.frame import FrameContext, frames
from restir_gi.reference.numerics.arrays import (
    Indices,
    Scalars,
    Vec3s,
    dot,
    zero_vectors,
)
from restir_gi.reference.numerics.records import concatenate, cut, keep, take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.resampling.generalized import Shifted, resample
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    finalize,
    initial_candidates,
    merge,
)
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.hits import surface_points
from restir_gi.reference.scene.materials.bsdf_sampling import sample
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
from restir_gi.reference.transport.direct_light import sees_light
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True, eq=False)
class LightFrame:
    """What one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int; from 0
    world : World; the scene as it was
    visible : VisiblePoints; G-buffer, through the centres of the pixels
    pixel, vertex : (V,) int64
        Whose path each vertex of the cache is of, and its number on it.
    cache : Cache
        Vertices x_2 of all pixels, then x_3, ...; before them x_1, if they are kept.
    color : (N, 3) float64, W/(m² sr); indirect light
    """

    number: int
    world: World
    visible: VisiblePoints
    pixel: Indices
    vertex: Indices
    cache: Cache
    color: Vec3s


def render_light_frames(
    world: World,
    settings: LightSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[LightFrame]:
    """Frames of indirect light by world-space reservoirs, without end.

    Camera, shapes and lights may move.
    """
    return frames(next_frame, world, settings, bounces, seed, schedule, animation)


def next_frame(
    frame: FrameContext[LightSettings], last: LightFrame | None
) -> LightFrame:
    """One frame: eye paths, vertex by vertex, and the grid for the next one.

    Light that x_1 receives straight from a light is not indirect, and left out.

    [Boisse21, section 3].
    """
    world, s = frame.world, frame.settings
    history = carried(last.cache, world) if last and s.cells else None
    color, visited = zero_vectors(frame.pixels), []
    x = Vertices(
        np.arange(frame.pixels), frame.visible.surface, 1.0 + zero_vectors(frame.pixels)
    )
    for v in range(1, frame.bounces + 2):
        # Where nothing was hit, nothing is drawn; an empty set is still a set.
        x = keep(x, x.points.hit)
        found = in_bands(
            frame.schedule, len(x.pixel), partial(visit, frame, history, v, x)
        )
        color[x.pixel] += found.light
        if found.reservoirs is not None:
            visited.append((v, x, found.reservoirs))
        x = found.onward
    # Algorithm 2 puts the vertices into cells; lines 2 and 3 were done at each of them.
    paths = concatenate([x for _, x, _ in visited])
    vertex = concatenate([np.full(len(x.pixel), v) for v, x, _ in visited])
    cache = insert(
        world=world,
        lattice=lattice_of(world.camera, s.facings),
        points=paths.points,
        reservoirs=concatenate([reservoirs for _, _, reservoirs in visited]),
        # Light in single directions is not reused, nor that of rough dielectrics.
        active=(roughness(world.materials, paths.points) >= 0) & (s.cells > 0),
        uniforms=vertex_uniforms(frame, paths.pixel, vertex, Stream.CELLS),
    )
    return LightFrame(
        number=frame.number,
        world=world,
        visible=frame.visible,
        pixel=paths.pixel,
        vertex=vertex,
        cache=cache,
        color=color,
    )


@dataclass(frozen=True, slots=True)
class Vertices:
    """Vertices x_v of K eye paths.

    Attributes
    ----------
    pixel : (K,) int64; whose
    throughput : (K, 3) float64; product of f cos θ / p of x_1 to x_(v-1)
    """

    pixel: Indices
    points: SurfacePoints
    throughput: Vec3s


@dataclass(frozen=True, slots=True)
class Visited:
    """What K paths leave at x_v, and how they go on.

    Attributes
    ----------
    reservoirs : Reservoirs or None
        Of `LightPoints`; ``None`` for visible points without reservoirs.
    light : (K, 3) float64, W/(m² sr); added to the pixels
    onward : Vertices; x_(v+1); misses where a path has ended
    """

    reservoirs: Reservoirs | None
    light: Vec3s
    onward: Vertices


def visit(
    frame: FrameContext[LightSettings],
    history: Cache | None,
    v: int,
    vertices: Vertices,
    rows: slice,
) -> Visited:
    """Reservoir and light of vertices x_v, and the way to x_(v+1).

    Parameters
    ----------
    history : Cache or None; of the last frame
    v : int; number of the vertices, from 1
    """
    world, s, here = frame.world, frame.settings, cut(vertices, rows)
    x, light, r = here.points, zero_vectors(len(here.pixel)), None
    if v > 1 or s.visible:
        # Alg. 2, line 2.
        r = ris(frame, v, here)
        if history is not None:
            r = reuse(frame, history, v, here, r)
    if r is not None and v > 1:
        # Alg. 1, shading: f(r.y) · r.W, and one shadow ray for what was kept.
        shines = np.flatnonzero((r.W > 0) & r.y.value.any(axis=1))
        if len(shines):
            some = take(x, shines)
            to_light = light_samples(world, some, take(r.y, shines))
            seen = sees_light(world, some, to_light, np.ones(len(shines), bool))
            weight = np.where(seen, r.W[shines], 0.0)
            light[shines] = r.y.value[shines] * weight[:, None]
    # On to x_(v+1).
    path = KeyedUniforms(
        here.pixel.astype(np.uint32), frame.number, frame.seed, Stream.PATH
    )
    bsdf = sample(world.materials, x, path.draw(2 * (v - 1)))
    goes_on = x.hit & (dot(bsdf.weight, bsdf.weight) > 0)
    if v == frame.bounces + 1:
        goes_on = goes_on & hits_count(world, bsdf, s.chance)
    hits = world.caster.from_surface(x, bsdf.wi, goes_on, "bounce")
    onward = surface_points(world.geometry, hits, x.position, bsdf.wi)
    if v > 1:
        hit = reflected_hits(world, x, bsdf, hits, s.chance)
        light = here.throughput * (hit + light)
    return Visited(
        r, light, Vertices(here.pixel, onward, here.throughput * bsdf.weight)
    )


def ris(frame: FrameContext[LightSettings], v: int, vertices: Vertices) -> Reservoirs:
    """Initial reservoirs of vertices x_v: one point on a light each, and M candidates.

    [Boisse21, Alg. 1], RIS: p draws by power, p̂ is the light without shadows.
    """
    world, s = frame.world, frame.settings
    uniforms = vertex_uniforms(frame, vertices.pixel, v, Stream.LIGHTS)

    def drawn(i: int) -> tuple[Candidates, Scalars]:
        # Generate x_i ~ p.
        u = uniforms.draw(i)
        x_i, p = draw_lights(world.emitters, u)
        f = reflected(world, vertices.points, x_i, s.chance)
        # WRS(x_i, p̂(x_i) / p(x_i)).
        return initial_candidates(replace(x_i, value=f), luminance(f), p), u[3]

    return resampled(map(drawn, range(s.candidates)))


def resampled(drawn: Iterable[tuple[Candidates, Scalars]]) -> Reservoirs:
    """Keep one of M candidates: W = w_sum / (M p̂(y)).

    Parameters
    ----------
    drawn : iterable of Candidates and (N,); at least one, each with what decides on it
    """
    stream = iter(drawn)
    r, _ = next(stream)
    for candidate, u in stream:
        r = merge(r, candidate, u)
    return finalize(r, r.M)


def reuse(
    frame: FrameContext[LightSettings],
    history: Cache,
    v: int,
    vertices: Vertices,
    r: Reservoirs,
) -> Reservoirs:
    """Resample reservoirs with those of the cells around, of the frame before.

    [Boisse21], with MIS weights of [Lin22].
    """
    s = frame.settings
    uniforms = vertex_uniforms(frame, vertices.pixel, v, Stream.CELLS)
    found = look_up(history, vertices.points, uniforms, s.cells, s.reuse)
    canonical = LightNeighbor(
        world=frame.world,
        points=vertices.points,
        world_from=frame.world,
        points_from=vertices.points,
        reservoirs=r,
        rows=np.arange(len(r.M)),
        chance=s.chance,
        same_domain=True,
    )
    in_cells = replace(
        canonical,
        world_from=history.world,
        points_from=history.points,
        reservoirs=history.reservoirs,
        same_domain=False,
    )
    neighbors = [replace(in_cells, rows=row) for row, _ in found]
    u = [np.zeros(len(r.M)), *(u_n for _, u_n in found)]
    return resample([canonical, *neighbors], u, s.mis, s.cap)


@dataclass(frozen=True, slots=True, eq=False)
class LightNeighbor:
    """Vertices of the frame before, and the points on lights that they keep.

    Attributes
    ----------
    world, points : World, SurfacePoints; of the K receivers
    world_from, points_from : World, SurfacePoints; of the N neighbours
    reservoirs : Reservoirs; N rows of `LightPoints`, in the receivers' list of lights
    rows : (K,) int; row that each receiver resamples, or ``NONE``
    same_domain : bool; neighbour and receiver are one point
    """

    world: World
    points: SurfacePoints
    world_from: World
    points_from: SurfacePoints
    reservoirs: Reservoirs
    rows: Indices
    chance: Chance
    same_domain: bool = False

    def unshifted(self, at: Indices) -> Vec3s:
        """Value of the neighbours' points where they are, (A, 3)."""
        return take(self.reservoirs.y.value, self.rows[at])

    def shifted(self, at: Indices) -> Shifted:
        """The neighbours' points at the receivers ``at``, which all have one, (A,)."""
        lights = take(self.reservoirs.y, self.rows[at])
        value = reflected(self.world, take(self.points, at), lights, self.chance)
        return value, np.ones(len(at))

    def inverse(self, samples: LightPoints, at: Indices) -> Shifted:
        """The receivers' points ``at`` in their neighbours' scene, (A,)."""
        points = take(self.points_from, self.rows[at])
        now, then = self.world.emitters, self.world_from.emitters
        lights = renumbered(take(samples, at), now, then)
        value = reflected(self.world_from, points, lights, self.chance)
        return value, np.ones(len(at))


def carried(cache: Cache, world: World) -> Cache:
    """A cache for the frame after it, in which lights have come and gone.

    Samples are by the new list of lights, and know their cells.
    """
    grid, r = cache.grid, cache.reservoirs
    cell = np.zeros(len(r.M), np.int64)
    cell[grid.cell_storage] = np.repeat(grid.slot + 1, np.diff(grid.index_buffer))
    lights = renumbered(r.y, cache.world.emitters, world.emitters)
    return replace(cache, reservoirs=replace(r, y=replace(lights, cell=cell)))
