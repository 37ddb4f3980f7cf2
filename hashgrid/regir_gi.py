"""ReGIR GI: whole paths in the cells of a hash grid, and ReSTIR PT on top.

[ZyanideND] has three steps, which have their numbers here:

1. What a path holds from each of its vertices on, its suffix, is stored in a cell.
2. While a path is drawn, a vertex looks into its cell, and resamples the suffixes of
   the frame before along with its own.
3. It is reconnected to the one that is kept.

Paths are drawn from the end.  All light that reaches x_v by way of further vertices is
an integral of its own, and the suffix that begins at x_v a sample of it, with a
reservoir; with the prefix from x_(v-1) to x_v it is a sample of x_(v-1).  What reaches
x_1 is a new path of the pixel, which ReSTIR PT reuses over the screen.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from restir_gi.extensions.candidates import density_at, ended, find_lights, no_paths
from restir_gi.extensions.frame_loop import PathFrame, path_frames, path_shift
from restir_gi.extensions.restir_pt import reused
from restir_gi.extensions.shifting import (
    Leaving,
    PathNeighbor,
    Paths,
    Step,
    advance,
    leave,
    roughness,
    segment,
    start,
)
from restir_gi.hashgrid.grid import Cache, insert, lattice_of, look_up, vertex_uniforms
from restir_gi.hashgrid.path_settings import CellSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
)
from restir_gi.reference.numerics.records import NONE, concatenate, cut, take, where
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.resampling.generalized import Shifted, resample
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    finalize,
    merge,
)
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.materials.table import pdf, scattering
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True, eq=False)
class PathCache:
    """Suffixes in the cells of a grid.

    Attributes
    ----------
    cache : Cache
        Of V vertices, with reservoirs of `restir_gi.extensions.shifting.Paths` from
        them on.
    reach : (V,) int8; largest index of a last surface point that each could have drawn
    """

    cache: Cache
    reach: Indices


@dataclass(frozen=True, slots=True, eq=False)
class CellFrame(PathFrame):
    """What one frame of ReGIR GI leaves for the next, and the picture.

    Attributes
    ----------
    caches : mapping of int to PathCache
        By the number of the vertex that looks into them.
    """

    caches: Mapping[int, PathCache]


def render_cell_frames(
    world: World,
    settings: CellSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[CellFrame]:
    """Frames of indirect light by ReGIR GI, without end [ZyanideND].

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    """
    return path_frames(next_frame, world, settings, bounces, seed, schedule, animation)


def next_frame(frame: FrameContext[CellSettings], last: CellFrame | None) -> CellFrame:
    """One frame: paths that look into cells, cells for the next frame, ReSTIR PT."""
    before = last.caches if last else {}

    def drawn(rows: slice) -> Suffixes:
        x_1, number = cut(frame.visible.surface, rows), frame.numbers(rows)
        uniforms = frame.uniforms_of(Stream.PATH, number)
        leaving = leave(frame.world, start(x_1), 1, uniforms, x_1.hit)
        return draw_suffixes(frame, before, number, points=x_1, leaving=leaving, v=1)

    # Steps 2 and 3, wherever a path looks into a cell.
    paths = in_bands(frame.schedule, frame.pixels, drawn)
    # Whatever a cell knew, it is one new path of the pixel.
    new = Reservoirs(paths.kept.y, paths.kept.W, np.ones(frame.pixels))
    kept = reused(frame, last, lambda rows: cut(new, rows))
    # Step 1, for the next frame.
    caches = store(frame, paths.records)
    return CellFrame(
        number=frame.number,
        world=frame.world,
        visible=frame.visible,
        reservoirs=kept,
        color=kept.y.value * kept.W[:, None],
        caches=caches,
    )


@dataclass(frozen=True, slots=True)
class FirstDirections:
    """How N suffixes leave their first point.

    Attributes
    ----------
    wi : (N, 3) float64; unit directions
    weight : (N, 3) float64; f cos θ / p
    pdf : (N,) float64, 1/sr; p
    delta : (N,) bool; by a delta lobe
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    delta: Masks


@dataclass(frozen=True, slots=True)
class CacheRecords:
    """What K paths store at x_v, and at later vertices.

    Attributes
    ----------
    reservoirs : Reservoirs
        Of the suffixes from there on; without a sample where it cannot be joined.
    later : CacheRecords or None; at the next vertex that stores
    """

    points: SurfacePoints
    reservoirs: Reservoirs
    later: "CacheRecords | None"


@dataclass(frozen=True, slots=True)
class Suffixes:
    """What K paths hold from x_v on.

    Attributes
    ----------
    kept : Reservoirs; of paths whose first point is x_v
    first : FirstDirections; how they leave it
    """

    kept: Reservoirs
    first: FirstDirections
    records: CacheRecords | None


def draw_suffixes(
    frame: FrameContext[CellSettings],
    caches: Mapping[int, PathCache],
    number: Indices,
    points: SurfacePoints,
    leaving: Leaving,
    v: int,
) -> Suffixes:
    """Draw all that follows x_v, from the end, and let cells improve it.

    Parameters
    ----------
    caches : mapping of int to PathCache
        Of the last frame, by the number of the vertex that looks into them.
    number : (K,) int64; keys of the paths
    v : int; from 1
    """
    world, criterion, s = frame.world, path_shift(frame).criterion, frame.settings
    uniforms = frame.uniforms_of(Stream.PATH, number)
    # On to x_(v+1), the second point of suffixes that begin at x_v.
    step = advance(world, criterion, start(points), 1, leaving)
    is_last = v == frame.bounces
    onward: Leaving | None = None
    if not is_last or world.seeks_lights:
        onward = leave(world, step, v + 1, uniforms, step.points.hit)
    # Suffixes that end there ...
    lights = find_lights(world, step, v + 1, uniforms, onward)
    found = replace(lights, y=ended(step, no_paths(points, number), 2, lights.y))
    records: CacheRecords | None = None
    if not is_last and onward is not None:
        # ... and those that go on: with the suffix of x_(v+1).
        rest = draw_suffixes(
            frame, caches, number, points=step.points, leaving=onward, v=v + 1
        )
        y = prepend(step, rest.kept.y, rest.first)
        found = with_longer(found, y, rest.kept.W, uniforms.draw(2 * v + 1)[3])
        records = rest.records
    kept = one_suffix(found)
    bsdf = leaving.bsdf
    wi = np.where(step.joinable[:, None], -step.points.wo, bsdf.wi)
    first = FirstDirections(wi, step.weight, step.pdf, bsdf.delta)
    if s.looks_up(v) and v in caches:
        # Step 2, and step 3.
        kept = resample_bounce(
            frame, caches[v], number=number, points=points, v=v, own=kept
        )
        first = reconnect(frame, points, kept, first)
    if s.stores(v):
        # Step 1, of paths that can be reconnected; the others count as nulls.
        W = weight_in_cell(kept.y.joint, kept.W)
        records = CacheRecords(points, replace(kept, W=W), records)
    return Suffixes(kept, first, records)


def with_longer(found: Candidates, y: Paths, W: Scalars, u: Scalars) -> Candidates:
    """Suffixes that end at x_(v+1), or in their place those that go on from there.

    Parameters
    ----------
    found : Candidates; that end there
    y : Paths; that go on, as samples of x_v
    W : (N,) float64; of the suffixes of x_(v+1)
    u : (N,) float64; in [0, 1)
    """
    p_hat = luminance(y.value)
    return merge(found, Candidates(y, p_hat, p_hat * W, 0 * p_hat), u)


def one_suffix(found: Candidates) -> Reservoirs:
    """The suffixes that paths have drawn, each a sample of M = 1, null or not."""
    ones = np.ones(len(found.w))
    return finalize(replace(found, M=ones), ones)


def prepend(step: Step, suffix: Paths, first: FirstDirections) -> Paths:
    """Paths that go from x_(v-1) to x_v, and then as the suffixes of x_v do.

    Parameters
    ----------
    step : Step; N prefixes, from x_(v-1) to x_v; ``weight`` is theirs
    suffix : Paths; N paths from x_v on, which is the first point of theirs

    Returns
    -------
    Paths
        N paths from x_(v-1) on.  The random numbers of the suffix are taken for the
        next ones of the path itself: where they are others, the suffix is joined, and
        not replayed.
    """
    there = suffix.there
    later = np.where(suffix.joint > 0, suffix.joint + 1, 0).astype(np.int8)
    grown = replace(
        suffix,
        end=np.where(there, suffix.end + 1, 0).astype(np.int8),
        joint=np.where(there, later, 0).astype(np.int8),
        value=step.weight * suffix.value,
    )
    # The first point that may be joined is the one that is.
    joins = there & step.joinable & ~first.delta
    if not joins.any():
        return grown
    here = replace(
        grown,
        joint=np.full(len(suffix), 2, np.int8),
        surface=step.points,
        wi=first.wi,
        incoming=divide_or_zero(suffix.value, first.weight),
        density=density_at(step, first.pdf),
    )
    return where(joins, here, grown)


# ------------------------------------------------- step 1: store suffixes in the grid


def weight_in_cell(joint: Indices, W: Scalars) -> Scalars:
    """W of suffixes in a cell, (N,) float64: 0 where they cannot be joined at once.

    Parameters
    ----------
    joint : (N,) int; first surface point that is joined, 2 for the second
    W : (N,) float64
    """
    return np.where(joint == 2, W, 0.0)


def store(
    frame: FrameContext[CellSettings], records: CacheRecords | None
) -> dict[int, PathCache]:
    """Grids of what all pixels have stored, by the vertices that look into them."""
    s, stored = frame.settings, dict[int, CacheRecords]()
    for v in filter(s.stores, range(1, frame.bounces + 1)):
        if records is not None:
            stored[v], records = records, records.later
    caches: dict[int, PathCache] = {}
    for group in s.grids(tuple(stored)):
        points = concatenate([stored[v].points for v in group])
        reservoirs = concatenate([stored[v].reservoirs for v in group])
        vertex = np.repeat(group, frame.pixels)
        pixel = np.tile(np.arange(frame.pixels), len(group))
        cache = insert(
            world=frame.world,
            lattice=lattice_of(frame.world.camera, s.facings),
            points=points,
            reservoirs=reservoirs,
            active=reconnectable(frame, points) & s.inserts(reservoirs.W),
            uniforms=vertex_uniforms(frame, pixel, vertex, Stream.CELLS),
        )
        found = PathCache(cache, (frame.bounces + 2 - vertex).astype(np.int8))
        caches |= {v: found for v in group if s.looks_up(v)}
    return caches


def reconnectable(frame: FrameContext[CellSettings], points: SurfacePoints) -> Masks:
    """Whether vertices are rough enough, (K,): no sample is looked at."""
    least = max(path_shift(frame).criterion.roughness, 0.0)
    rough: Masks = roughness(frame.world.materials, points) >= least
    return rough


# ------------------------------------- step 2: resample a bounce with those of its cell


def resample_bounce(
    frame: FrameContext[CellSettings],
    lookup: PathCache,
    number: Indices,
    points: SurfacePoints,
    v: int,
    own: Reservoirs,
) -> Reservoirs:
    """Bounce reservoirs: what vertices x_v drew, and what their cells hold.

    Parameters
    ----------
    lookup : PathCache; of the last frame, for these vertices
    number : (K,) int64; keys of the paths
    """
    s, cache, here = frame.settings, lookup.cache, np.arange(len(points))
    uniforms = vertex_uniforms(frame, number % frame.pixels, v, Stream.CELLS)
    found = look_up(cache, points, uniforms, s.cells, s.cell_reuse)
    able = reconnectable(frame, points)
    shift = path_shift(frame)
    canonical = PathNeighbor(
        shift=shift,
        world=frame.world,
        points=points,
        world_from=frame.world,
        points_from=points,
        reservoirs=own,
        rows=here,
        same_domain=True,
    )
    # The numbers of a suffix are those of another pixel's path: it is connected at its
    # second point, or not at all.
    joined = replace(shift.criterion, last_joint=2, replays=False)
    in_cells = CellNeighbor(
        shift=replace(shift, criterion=joined),
        world=frame.world,
        points=points,
        world_from=cache.world,
        points_from=cache.points,
        reservoirs=cache.reservoirs,
        rows=here,
        reach=frame.bounces + 2 - v,
        reach_from=lookup.reach,
    )
    neighbors = [replace(in_cells, rows=np.where(able, row, NONE)) for row, _ in found]
    u = [np.zeros(len(here)), *(u_n for _, u_n in found)]
    kept = resample([canonical, *neighbors], u, s.cell_mis, s.cell_cap)
    # The prefix is replayed from this path's numbers, not from the neighbour's.
    return replace(kept, y=replace(kept.y, number=number))


@dataclass(frozen=True, slots=True, eq=False)
class CellNeighbor(PathNeighbor):
    """Vertices whose suffixes others resample; not all of them are as long.

    Attributes
    ----------
    reach : int; largest index of a last surface point of the receivers' paths
    reach_from : (N,) int8; the same of the neighbours'
    """

    reach: int = field(kw_only=True)
    reach_from: Indices = field(kw_only=True)

    def shifted(self, at: Indices) -> Shifted:
        """The neighbours' suffixes at the receivers, (A,); 0 if they are too long."""
        fits = self.reservoirs.y.end[self.rows[at]] <= self.reach
        return only_where(fits, PathNeighbor.shifted(self, at))

    def inverse(self, samples: Paths, at: Indices) -> Shifted:
        """The receivers' suffixes at their neighbours, (A,); 0 if they are too long."""
        fits = samples.end[at] <= self.reach_from[self.rows[at]]
        return only_where(fits, PathNeighbor.inverse(self, samples, at))


def only_where(fits: Masks, shifted: Shifted) -> Shifted:
    """What a shift gives; 0 for paths that are too long for the receiver.

    Parameters
    ----------
    fits : (A,) bool; whose paths are not
    """
    value, jacobian = shifted
    return np.where(fits[:, None], value, 0.0), np.where(fits, jacobian, 0.0)


# -------------------------------------------- step 3: reconnect to the one that is kept


def reconnect(
    frame: FrameContext[CellSettings],
    points: SurfacePoints,
    kept: Reservoirs,
    first: FirstDirections,
) -> FirstDirections:
    """How paths leave x_v: to the second point of the suffix that was kept."""
    rows = np.flatnonzero(kept.y.joint == 2)
    if not len(rows):
        return first
    world, criterion = frame.world, path_shift(frame).criterion
    x, to = take(points, rows), take(kept.y.surface, rows)
    seen, _ = segment(criterion, world.geometry, x, to)
    wi, delta = first.wi.copy(), first.delta.copy()
    weight, density = first.weight.copy(), first.pdf.copy()
    wi[rows], delta[rows] = -seen.wo, False
    density[rows] = pdf(world.materials, x, -seen.wo)
    value = scattering(world.materials, x, -seen.wo)
    weight[rows] = divide_or_zero(value, density[rows, None])
    return FirstDirections(wi, weight, density, delta)
