"""A hash grid of cells in space: Algorithm 2 of [Boisse21], and its look-up.

Space is cut into cells that grow with the distance to the eye.  Each cell keeps the
list of the vertices that lie in it, and a later frame takes some of them.  The page
follows a vertex: its cell, the hashes of the cell, Algorithm 2, and the look-up.

Lines of Algorithm 2 are counted from its first ``foreach``, which is line 1; line 11 is
the last one, which scatters into the cells' storage.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    dot,
    length,
)
from restir_gi.reference.numerics.frames import normal_frames
from restir_gi.reference.numerics.records import NONE, cut, take
from restir_gi.reference.numerics.rng import Draw, KeyedUniforms, Stream, Uniforms
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World

UInts = NDArray[np.uint32]
Hashes = NDArray[np.uint64]

SMALLEST = 1e-3
"""Edge of the smallest cells, m."""

PIXELS = 16.0
"""Edge of a cell in the image, about."""

FARTHEST = 2.0**62
"""Cells beyond are all taken for this one."""

BUCKET = 16
"""Slots of a bucket."""

BUCKETS = 0x40000

NOWHERE = -1
"""In place of a cell: it is empty, or its bucket is full."""

ALIKE = 0.5**0.25
"""Least cosine between the normals of neighbours: max(n · n', 0)⁴ ≥ 1/2."""

INSERTION, LOOK_UP, CHOICE = 0, 1, 16
"""First dimensions of a vertex's random numbers: jitters, then four choices each."""

VERTICES = 32
"""More than any path has: step of the keys from frame to frame."""


# ---------------------------------------------------------------- the cell of a point


@dataclass(frozen=True, slots=True)
class Lattice:
    """How finely space is divided, seen from an eye.

    Attributes
    ----------
    eye : (float, float, float), m
        Of the frame that built the grid; a later frame looks up by the same.
    base : float
        Edge of a cell over its distance, before it is rounded down to a power of two.
    facings : int
        Parts of each component of the normal that cells tell apart, 1 to 16; 1 for
        none.
    """

    eye: tuple[float, float, float]
    base: float
    facings: int = 1


def lattice_of(camera: Camera, facings: int = 1) -> Lattice:
    """Lattice whose cells are some 16 pixels wide.

    Its base is tan(fov_y · 16 · max(1 / h, h / w²)): [Boisse21], with the numbers of
    the author's later renderer.

    Parameters
    ----------
    facings : int; parts of each component of the normal
    """
    w, h = camera.width, camera.height
    fov_y = np.array([2 * np.arctan(camera.half_width * h / w)])
    base = base_of(fov_y, np.array([w]), np.array([h]))
    return Lattice(camera.position, float(base[0]), facings)


def base_of(fov_y: Scalars, width: Indices, height: Indices) -> Scalars:
    """Edge of a cell over its distance, of cameras, (N,) float64; at most 1.

    Parameters
    ----------
    fov_y : (N,) float64, radians; from below to above
    width, height : (N,) int64, pixels
    """
    w, h = width, height
    wide = fov_y * PIXELS * np.maximum(1 / h, h / w**2)
    base: Scalars = np.tan(np.minimum(wide, np.pi / 4))
    return base


def levels(lattice: Lattice, position: Vec3s) -> Indices:
    """Level of detail at points.

    Parameters
    ----------
    position : (N, 3) float64, m; the points

    Returns
    -------
    (N,) int64; floor(log2(1000 · distance · base)), at least 0
    """
    offset = np.clip(position - np.asarray(lattice.eye), -FARTHEST, FARTHEST)
    distance = length(offset)
    wanted = np.maximum(distance * lattice.base / SMALLEST, 1.0)
    # The exponent of a float is exact, where a rounded logarithm is not.
    level: Indices = np.frexp(wanted)[1].astype(np.int64) - 1
    return level


def edges(level: Indices) -> Scalars:
    """Edges of cells, (N,) float64, m; 1e-3 · 2^level.

    Parameters
    ----------
    level : (N,) int64; from 0
    """
    size: Scalars = np.ldexp(SMALLEST, level.astype(np.int32))
    return size


def jittered(lattice: Lattice, position: Vec3s, normal: Vec3s, u: Draw) -> Vec3s:
    """Points moved at random in their tangent plane, by up to √2 edges each way.

    Parameters
    ----------
    position, normal : (N, 3) float64, m and 1; the points, and unit normals
    u : four (N,) float64; lanes 0 and 1

    Returns
    -------
    (N, 3) float64, m; what hides the borders of the cells, at insertion and look-up
    """
    return moved_in_plane(position, normal, edges(levels(lattice, position)), u)


def moved_in_plane(position: Vec3s, normal: Vec3s, edge: Scalars, u: Draw) -> Vec3s:
    """Points moved at random in their tangent plane, (N, 3), m, by cells' edges.

    Parameters
    ----------
    position, normal : (N, 3) float64, m and 1; the points, and unit normals
    edge : (N,) float64, m; of each point's cell
    u : four (N,) float64; lanes 0 and 1
    """
    across, along = normal_frames(normal)
    reach = np.sqrt(2.0) * edge
    a, b = ((2.0 * lane - 1.0) * reach for lane in u[:2])
    moved: Vec3s = position + a[:, None] * across + b[:, None] * along
    return moved


@dataclass(frozen=True, slots=True)
class Keys:
    """Cells that N points lie in.

    Attributes
    ----------
    level : (N,) int16; edge 1e-3 · 2^level m
    x, y, z : (N,) int64; position in units of the edge, rounded down
    facing : (N,) int16
        Part of the normal's sphere; 0 where the lattice does not look at it.
    """

    level: Indices
    x: Indices
    y: Indices
    z: Indices
    facing: Indices

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.level)

    @property
    def hashes(self) -> Hashes:
        """(N,) uint64: the hash of the bucket above, the checksum below.

        Each is h(level + h(x + h(y + h(z + h(facing))))) of the lower 32 bits of the
        fields, modulo 2³²; a checksum is at least 1, and 0 marks a free slot.
        """
        bucket = checksum = np.zeros(len(self.level), np.uint32)
        for field in (self.facing, self.z, self.y, self.x, self.level):
            word = (field.astype(np.int64) & 0xFFFFFFFF).astype(np.uint32)
            bucket, checksum = pcg(word + bucket), xxhash(word + checksum)
        low = np.maximum(checksum, np.uint32(1)).astype(np.uint64)
        both: Hashes = (bucket.astype(np.uint64) << np.uint64(32)) | low
        return both

    def same(self, other: "Keys") -> Masks:
        """Row by row, (N,): whether all fields agree; equal hashes do not say so."""
        fields = ("level", "x", "y", "z", "facing")
        equal = [getattr(self, f) == getattr(other, f) for f in fields]
        found: Masks = np.all(equal, axis=0)
        return found


def keys_of(lattice: Lattice, position: Vec3s, normal: Vec3s) -> Keys:
    """Cells of points.

    Parameters
    ----------
    position : (N, 3) float64, m; the points
    normal : (N, 3) float64; unit normals
    """
    return keys_at(levels(lattice, position), position, normal, lattice.facings)


def keys_at(level: Indices, position: Vec3s, normal: Vec3s, parts: int) -> Keys:
    """Cells of points whose level is known.

    Parameters
    ----------
    level : (N,) int64; from 0
    position : (N, 3) float64, m; the points
    normal : (N, 3) float64; unit normals
    parts : int; of each component of the normal that are told apart
    """
    return keys_in(level, edges(level), position, normal, parts)


def keys_in(
    level: Indices, edge: Scalars, position: Vec3s, normal: Vec3s, parts: int
) -> Keys:
    """Cells of points whose edge is known, too.

    Parameters
    ----------
    level : (N,) int64; from 0
    edge : (N,) float64, m; of each point's cell
    position : (N, 3) float64, m; the points
    normal : (N, 3) float64; unit normals
    parts : int; of each component of the normal that are told apart
    """
    scaled = np.floor(position / edge[:, None])
    x, y, z = np.clip(scaled, -FARTHEST, FARTHEST).astype(np.int64).T
    part = np.clip(np.floor((normal + 1.0) * (parts / 2)), 0, parts - 1)
    a, b, c = part.astype(np.int64).T
    facing = (a + parts * (b + parts * c)).astype(np.int16)
    return Keys(level.astype(np.int16), x, y, z, facing)


# ------------------------- its hashes, fixed by the contract: a shader finds the same


def pcg(x: UInts) -> UInts:
    """PCG's output permutation as a hash of one word [Jarzynski20].

    Parameters
    ----------
    x : (N,) uint32; the word

    Returns
    -------
    (N,) uint32; arithmetic is modulo 2^32
    """
    state = x * np.uint32(747796405) + np.uint32(2891336453)
    word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(
        277803737
    )
    mixed: UInts = (word >> np.uint32(22)) ^ word
    return mixed


def xxhash(x: UInts) -> UInts:
    """XxHash32 of one word [Jarzynski20], (N,) uint32; arithmetic is modulo 2^32.

    Parameters
    ----------
    x : (N,) uint32; the word
    """
    h = x + np.uint32(374761393)
    h = ((h << np.uint32(17)) | (h >> np.uint32(15))) * np.uint32(668265263)
    h = (h ^ (h >> np.uint32(15))) * np.uint32(2246822519)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(3266489917)
    mixed: UInts = h ^ (h >> np.uint32(16))
    return mixed


# ------------------------------------------------------------------------ Algorithm 2


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """C cells in the order of their slots, and the vertices in each.

    Attributes
    ----------
    cells : Keys; C rows, no two alike
    slot : (C,) int32; bucket · 16 + slot in the bucket
    index_buffer : (C + 1,) int64
        Exclusive prefix sum of the counters: the vertices of cell c are those from
        index_buffer[c] to index_buffer[c + 1].
    cell_storage : (index_buffer[C],) int64
        Rows of the frame, cell by cell, in rising order within each.
    lost : int; vertices whose bucket was full
    hashes : (C,) uint64; of the cells, in rising order
    by_hash : (C,) int32; cells in that order
    """

    buckets: int
    cells: Keys
    slot: Indices
    index_buffer: Indices
    cell_storage: Indices
    lost: int
    hashes: Hashes
    by_hash: Indices

    def __len__(self) -> int:
        """Number of cells."""
        return len(self.slot)

    @property
    def counters(self) -> Indices:
        """(C,): vertices of each cell."""
        return np.diff(self.index_buffer)


def build_grid(keys: Keys, active: Masks, buckets: int = BUCKETS) -> Grid:
    """Sort vertices into cells, as if they came one after the other.

    [Boisse21, Alg. 2], whose prefix sum leaves the cell itself out.  On a GPU the order
    of atomic additions decides; here the number of the vertex does.

    Parameters
    ----------
    active : (N,) bool; which are inserted
    buckets : int; how many of 16 slots each, at most 2²⁷

    Returns
    -------
    Grid
        A cell takes the first free slot of its bucket; where there is none, its
        vertices are lost, and counted.
    """
    # Line 1: foreach vertex.
    v = np.flatnonzero(active)
    # Line 4: FindOrInsertCell.  The vertices of a cell now follow each other.
    inserted = take(keys, v)
    order, head, slot = find_or_insert(inserted.hashes, inserted, buckets)
    v, size = v[order], np.diff(np.append(head, len(order)))
    kept = np.flatnonzero(slot != NOWHERE)
    kept = kept[np.argsort(slot[kept], kind="stable")]
    cell = np.full(len(slot), NOWHERE)
    cell[kept] = np.arange(len(kept))
    cell_index = np.repeat(cell, size)
    # Line 5: atom_inc, for what has found a cell.
    found = cell_index != NOWHERE
    cell_counters, index_in_cell = atom_inc(cell_index[found], len(kept))
    # Line 6: it is appended.
    append_buffer = v[found], cell_index[found], index_in_cell
    # Line 7: ParallelPrefixSum.
    index_buffer = prefix_sum(cell_counters)
    # Lines 8 to 11: foreach triplet.
    cell_storage = scatter_by_cell(index_buffer, *append_buffer)
    cells = take(keys, v[head[kept]])
    by_hash = np.argsort(cells.hashes, kind="stable")
    return Grid(
        buckets=buckets,
        cells=cells,
        slot=slot[kept].astype(np.int32),
        index_buffer=index_buffer,
        cell_storage=cell_storage,
        lost=len(v) - len(cell_storage),
        hashes=cells.hashes[by_hash],
        by_hash=by_hash.astype(np.int32),
    )


def atom_inc(cell: Indices, cells: int) -> tuple[Indices, Indices]:
    """Counters of cells, and what they were when each vertex came.

    Parameters
    ----------
    cell : (N,) int; of each vertex
    cells : int; how many, C

    Returns
    -------
    (C,) int64, (N,) int64; vertices of each cell; how many of them came before each
    """
    counters = np.bincount(cell, minlength=cells)
    index_in_cell = np.empty(len(cell), np.int64)
    first = np.repeat(prefix_sum(counters)[:-1], counters)
    index_in_cell[np.argsort(cell, kind="stable")] = np.arange(len(cell)) - first
    return counters, index_in_cell


def prefix_sum(counters: Indices) -> Indices:
    """Exclusive prefix sum, (C + 1,) int64: of all counters before each; last, of all.

    Parameters
    ----------
    counters : (C,) int
    """
    return np.concatenate([[0], np.cumsum(counters)])


def scatter_by_cell(
    index_buffer: Indices, vertex: Indices, cell: Indices, index_in_cell: Indices
) -> Indices:
    """Vertices cell by cell, (N,) int64.

    Parameters
    ----------
    index_buffer : (C + 1,) int64; where the vertices of each cell begin
    vertex, cell, index_in_cell : (N,) int; who goes where
    """
    scatter_offset = index_buffer[cell] + index_in_cell
    cell_storage = np.empty(len(scatter_offset), np.int64)
    cell_storage[scatter_offset] = vertex
    return cell_storage


def find_or_insert(
    hashes: Hashes, keys: Keys, buckets: int
) -> tuple[Indices, Indices, Indices]:
    """Cells of vertices that come one after the other, and the slots that they find.

    Parameters
    ----------
    hashes : (N,) uint64; of the keys, the bucket's above

    Returns
    -------
    order : (N,) int; vertices cell by cell, in rising order within each
    head : (C,) int; where in this order a cell begins
    slot : (C,) int64
        Bucket · 16 + slot in the bucket, or ``NOWHERE`` where it was full.
    """
    order = np.argsort(hashes, kind="stable")
    first = _first_of_each(take(keys, order))
    if np.any(first[1:] & (np.diff(hashes[order]) == 0)):
        # Other cells of one hash: so rare that only then all fields are sorted.
        fields = (keys.facing, keys.z, keys.y, keys.x, keys.level, hashes)
        order = np.lexsort((np.arange(len(order)), *fields))
        first = _first_of_each(take(keys, order))
    head = np.flatnonzero(first)
    # A cell takes the next slot of its bucket when its first vertex comes.
    came = order[head]
    bucket = (hashes[came] >> np.uint64(32)).astype(np.int64) % buckets
    turn = np.lexsort((came, bucket))
    fresh = np.append(True, np.diff(bucket[turn]) != 0)[: len(turn)]
    begin = np.flatnonzero(fresh)
    rank = np.arange(len(turn)) - begin[np.cumsum(fresh) - 1]
    slot = np.empty(len(head), np.int64)
    slot[turn] = np.where(rank < BUCKET, bucket[turn] * BUCKET + rank, NOWHERE)
    return order, head, slot


def _first_of_each(keys: Keys) -> Masks:
    """Whether a row is of another cell than the one before it."""
    first, last = np.ones(len(keys.x), bool), max(len(keys.x) - 1, 0)
    first[1:] = ~cut(keys, slice(1, None)).same(cut(keys, slice(0, last)))
    return first


@dataclass(frozen=True, slots=True, eq=False)
class Cache:
    """Reservoirs of V vertices in the cells of a grid.

    Attributes
    ----------
    world : World; in which they were made
    lattice : Lattice; by whose cells they are found
    points : SurfacePoints; the V vertices
    reservoirs : Reservoirs; V rows: Paths[v] of line 3, to which the cells point
    """

    world: World
    lattice: Lattice
    grid: Grid
    points: SurfacePoints
    reservoirs: Reservoirs


def insert(
    world: World,
    lattice: Lattice,
    points: SurfacePoints,
    reservoirs: Reservoirs,
    active: Masks,
    uniforms: Uniforms,
) -> Cache:
    """Build the grid of a frame's vertices, each jittered, for the next frame.

    Parameters
    ----------
    active : (V,) bool
        Which are inserted.  If a sample decides that, what is found is biased.
    """
    u = uniforms.draw(INSERTION)
    moved = jittered(lattice, points.position, points.normal, u)
    grid = build_grid(keys_of(lattice, moved, points.normal), active)
    return Cache(world, lattice, grid, points, reservoirs)


# ------------------------------------------------------------------------ the look-up


def look_up(
    cache: Cache, points: SurfacePoints, uniforms: Uniforms, cells: int, most: int
) -> list[tuple[Indices, Scalars]]:
    """Vertices of the frame before that surface points find around them.

    Parameters
    ----------
    cells : int
        How many cells each looks into: each look-up has a jitter of its own, and leads
        to another cell as a rule.
    most : int; how many vertices each takes from a cell

    Returns
    -------
    list of (K,) int64, (K,) float64
        Rows of the cache, or ``NONE``, and the random number that decides whether the
        neighbour's sample is kept.  Vertices that face elsewhere are left out.  No
        sample decides who is found.  Nothing at all where the cache is empty.
    """
    found: list[tuple[Indices, Scalars]] = []
    if len(cache.points) == 0:
        return found
    for number in range(cells):
        u = uniforms.draw(LOOK_UP + number)
        moved = jittered(cache.lattice, points.position, points.normal, u)
        cell = find_cells(cache.grid, keys_of(cache.lattice, moved, points.normal))
        cell = np.where(points.hit, cell, NOWHERE)
        for row in visits(cache.grid, cell, u[2], most):
            normal = take(cache.points.normal, np.maximum(row, 0))
            alike = (row != NONE) & faces_alike(normal, points.normal)
            k = len(found) + 1  # 0 is the vertex's own candidate
            choice = uniforms.draw(CHOICE + k // 4)[k % 4]
            found.append((np.where(alike, row, NONE), choice))
    return found


def faces_alike(a: Vec3s, b: Vec3s) -> Masks:
    """Whether neighbours face alike, (N,) bool: max(n · n', 0)⁴ ≥ 1/2.

    Parameters
    ----------
    a, b : (N, 3) float; unit normals
    """
    alike: Masks = dot(a, b) >= ALIKE
    return alike


def find_cells(grid: Grid, keys: Keys) -> Indices:
    """Cells that points lie in, (Q,) int64; row of the cell, or ``NOWHERE``.

    Parameters
    ----------
    grid : Grid; built before
    keys : Keys; of Q points, by the grid's own lattice
    """
    return search(grid, keys.hashes, keys)


def search(grid: Grid, wanted: Hashes, keys: Keys) -> Indices:
    """Cells of keys and their hashes, (Q,) int64; row of the cell, or ``NOWHERE``.

    Parameters
    ----------
    wanted : (Q,) uint64; hashes of the keys
    """
    found, at = np.full(len(wanted), NOWHERE), np.searchsorted(grid.hashes, wanted)
    # Cells of one hash follow each other: as a rule there is one.
    open_rows = np.flatnonzero(at < len(grid.hashes))
    while len(open_rows):
        here = grid.by_hash[at[open_rows]]
        alike = grid.hashes[at[open_rows]] == wanted[open_rows]
        same = alike & take(grid.cells, here).same(take(keys, open_rows))
        found[open_rows[same]] = here[same]
        open_rows = open_rows[alike & ~same]
        at[open_rows] += 1
        open_rows = open_rows[at[open_rows] < len(grid.hashes)]
    return found


def visits(grid: Grid, cells: Indices, u: Scalars, most: int) -> list[Indices]:
    """Draw some of the vertices of cells, no one twice.

    Strides of n / most, rounded down, from a place that is drawn evenly: places differ
    as long as there are enough of them, and all have the same chance.

    Parameters
    ----------
    cells : (Q,) int64; rows of the grid, or ``NOWHERE``
    u : (Q,) float64; in [0, 1): where the walk begins

    Returns
    -------
    list of (Q,) int64
        Rows of the frame, or ``NONE`` where there is no more.  Each vertex of a cell is
        taken with the same probability, min(most / n, 1).
    """
    if len(grid.cell_storage) == 0:
        return [np.full(len(cells), NONE)] * most
    cell = np.maximum(cells, 0)
    first = grid.index_buffer[cell]
    count = np.where(cells == NOWHERE, 0, grid.index_buffer[cell + 1] - first)
    offset = np.minimum((u * count).astype(np.int64), np.maximum(count - 1, 0))
    found = []
    for k in range(most):
        place = (offset + k * count // most) % np.maximum(count, 1)
        # Of fewer than that, each once.
        place = np.where(count <= most, k, place)
        taken = k < count
        vertex = grid.cell_storage[np.where(taken, first + place, 0)]
        found.append(np.where(taken, vertex, NONE))
    return found


# --------------------------------------------------------- random numbers of a vertex


def vertex_uniforms(
    frame: FrameContext[object], pixel: Indices, vertex: int | Indices, stream: Stream
) -> KeyedUniforms:
    """Random numbers of vertices x_v, from the key 32 · frame + v.

    Parameters
    ----------
    frame : FrameContext; whose number is below 2²²
    pixel : (K,) int64; whose paths
    vertex : int or (K,) int64; v, of all of them or of each
    """
    key = frame.number * VERTICES + vertex
    return KeyedUniforms(pixel.astype(np.uint32), key, frame.seed, stream)
