"""The hash grid: the same as a slow and obvious one, and nobody lost or mixed up."""

from dataclasses import dataclass, fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from restir_gi.hashgrid.grid import (
    BUCKET,
    NOWHERE,
    Keys,
    Lattice,
    build_grid,
    edges,
    find_cells,
    jittered,
    keys_of,
    lattice_of,
    levels,
    pcg,
    visits,
    xxhash,
)
from restir_gi.hashgrid.report import occupancy
from restir_gi.reference.numerics.arrays import dot, normalize
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.scene.camera import Camera

LATTICE = Lattice((0.0, 0.0, 0.0), 0.05)
UP = np.array([[0.0, 1.0, 0.0]])


def points(count, seed=0, scale=3.0, offset=0.0):
    rng = np.random.default_rng(seed)
    return rng.normal(scale=scale, size=(count, 3)) + offset


def keys_at(position, lattice=LATTICE):
    return keys_of(lattice, position, np.broadcast_to(UP, position.shape))


def everyone(keys):
    return np.ones(len(keys), bool)


def buckets_of(keys):
    """Hashes whose remainders are the buckets."""
    return (keys.hashes >> np.uint64(32)).tolist()


def checksums(keys):
    return keys.hashes.astype(np.uint32).tolist()


# ------------------------------------------------------------ a slow, obvious twin


@dataclass
class Slow:
    """Buckets of places, filled by one vertex after the other."""

    buckets: int
    table: dict
    lost: int = 0

    def insert(self, vertex, cell, place, checksum):
        """Probe the bucket; take the first free place."""
        bucket = place % self.buckets
        for slot in range(BUCKET):
            at = bucket * BUCKET + slot
            if at not in self.table:
                self.table[at] = (cell, checksum, [])
            if self.table[at][0] == cell:
                self.table[at][2].append(vertex)
                return
        self.lost += 1

    def find(self, cell, place):
        """Place of a cell, or none."""
        bucket = place % self.buckets
        for slot in range(BUCKET):
            at = bucket * BUCKET + slot
            if at in self.table and self.table[at][0] == cell:
                return at
        return None


def tuples(keys):
    columns = [getattr(keys, field.name).tolist() for field in fields(Keys)]
    return list(zip(*columns, strict=True))


def slow_grid(keys, active, buckets):
    grid = Slow(buckets, {})
    rows = zip(tuples(keys), buckets_of(keys), checksums(keys), strict=True)
    for vertex, (cell, place, checksum) in enumerate(rows):
        if active[vertex]:
            grid.insert(vertex, cell, place, checksum)
    return grid


def assert_same(grid, slow):
    table = sorted(slow.table.items())
    assert grid.slot.tolist() == [at for at, _ in table]
    assert tuples(grid.cells) == [cell for _, (cell, _, _) in table]
    assert checksums(grid.cells) == [checksum for _, (_, checksum, _) in table]
    lists = [v for _, (_, _, vertices) in table for v in vertices]
    assert grid.cell_storage.tolist() == lists
    counts = [len(vertices) for _, (_, _, vertices) in table]
    assert grid.index_buffer.tolist() == [0, *np.cumsum(counts)]
    assert grid.counters.tolist() == counts
    assert grid.lost == slow.lost


@pytest.mark.parametrize("buckets", [1, 2, 7, 64, 4096])
@pytest.mark.parametrize("scale", [0.001, 0.1, 3.0])
def test_it_is_the_slow_grid(buckets, scale):
    keys = keys_at(points(800, buckets, scale))
    active = np.random.default_rng(1).random(len(keys)) < 0.8
    grid, slow = build_grid(keys, active, buckets), slow_grid(keys, active, buckets)
    assert_same(grid, slow)
    asked = keys_at(np.concatenate([points(800, buckets, scale), points(400, 9)]))
    found = find_cells(grid, asked)
    rows = zip(tuples(asked), buckets_of(asked), strict=True)
    wanted = [slow.find(cell, place) for cell, place in rows]
    assert [None if c == NOWHERE else grid.slot[c] for c in found] == wanted


cell = st.integers(-3, 3)
cells = st.lists(st.tuples(st.integers(0, 2), cell, cell, cell), max_size=60)


@given(rows=cells, buckets=st.integers(1, 4))
@settings(max_examples=60, deadline=None)
def test_it_is_the_slow_grid_for_any_cells(rows, buckets):
    columns = np.array([(*row, 0) for row in rows], np.int64).reshape(-1, 5).T
    keys = Keys(*columns)
    grid = build_grid(keys, everyone(keys), buckets)
    assert_same(grid, slow_grid(keys, everyone(keys), buckets))


def test_nobody_is_lost_or_twice_there():
    keys = keys_at(points(5000))
    grid = build_grid(keys, everyone(keys), 64)
    assert len(set(grid.cell_storage.tolist())) == len(grid.cell_storage)
    assert len(grid.cell_storage) + grid.lost == len(keys)
    assert grid.lost > 0
    wide = build_grid(keys, everyone(keys), 1 << 16)
    assert wide.lost == 0
    assert sorted(wide.cell_storage.tolist()) == list(range(len(keys)))


@pytest.fixture
def alike(monkeypatch):
    """All cells have one bucket, and one checksum."""
    one = np.uint64((5 << 32) | 77)
    same = property(lambda keys: np.full(len(keys), one))
    monkeypatch.setattr(Keys, "hashes", same)


@pytest.mark.usefixtures("alike")
def test_cells_of_one_bucket_and_checksum_are_not_mixed_up():
    few = np.arange(10) // 2
    none = np.zeros(10, np.int64)
    keys = Keys(none, few, none, none, none)
    grid = build_grid(keys, everyone(keys), 8)
    assert len(grid) == 5
    assert_same(grid, slow_grid(keys, everyone(keys), 8))
    found = find_cells(grid, keys)
    assert (grid.cells.x[found] == few).all()
    assert occupancy(grid).shared == 4
    stranger = Keys(none[:1], few[:1] + 99, none[:1], none[:1], none[:1])
    assert find_cells(grid, stranger).tolist() == [NOWHERE]


def test_the_same_cells_whatever_the_order_of_look_ups():
    keys = keys_at(points(3000))
    grid = build_grid(keys, everyone(keys), 4096)
    whole = find_cells(grid, keys)
    for rows in (slice(0, 700), slice(700, 3000)):
        part = take(keys, np.arange(3000)[rows])
        np.testing.assert_array_equal(find_cells(grid, part), whole[rows])


# ------------------------------------------------------------ extremes


def test_a_grid_without_anybody():
    keys = keys_at(points(10))
    grid = build_grid(keys, np.zeros(10, bool), 4)
    assert len(grid) == 0
    assert set(find_cells(grid, keys)) == {NOWHERE}
    assert set(
        np.concatenate(visits(grid, find_cells(grid, keys), np.zeros(10), 3))
    ) == {NONE}
    assert occupancy(grid).vertices == 0


def test_one_cell_that_holds_everything():
    position = np.full((5000, 3), 0.3)
    keys = keys_at(position)
    grid = build_grid(keys, everyone(keys), 4)
    assert len(grid) == 1
    assert grid.cell_storage.tolist() == list(range(5000))
    assert occupancy(grid).longest == 5000


def test_a_table_far_too_small_counts_what_it_loses():
    keys = keys_at(points(4000, scale=30.0))
    grid = build_grid(keys, everyone(keys), 1)
    assert len(grid) == BUCKET
    assert grid.lost == 4000 - grid.index_buffer[-1] > 3000
    assert_same(grid, slow_grid(keys, everyone(keys), 1))


@pytest.mark.parametrize("offset", [0.0, 1e6, -1e6])
def test_cells_do_not_depend_on_where_the_scene_lies(offset):
    """Their edges do not; and no point is farther from its cell than rounding."""
    eye = (offset, offset, offset)
    position = points(1000, offset=offset)
    keys = keys_at(position, Lattice(eye, 0.05))
    size = edges(keys.level)
    low = np.stack([keys.x, keys.y, keys.z], axis=1) * size[:, None]
    # One rounding of the quotient, which is below |p| / size.
    room = 4 * 2.0**-53 * np.abs(position).max() + 0 * size[:, None]
    assert (position >= low - room).all()
    assert (position < low + size[:, None] + room).all()


def test_cells_on_both_sides_of_zero_are_of_one_size():
    """Not cut towards zero, where one cell would be two."""
    x = np.linspace(-0.1, 0.1, 4001)
    position = np.stack([x, 0 * x + 5.0, 0 * x], axis=1)
    keys = keys_at(position, Lattice((0.0, 0.0, 0.0), 0.002))
    size = edges(keys.level)[0]
    assert len(np.unique(keys.x)) > 20
    assert (edges(keys.level) == size).all()
    inner = np.unique(keys.x, return_counts=True)[1][1:-1]
    assert np.ptp(inner) <= 2  # on either border a point may fall to either side


@pytest.mark.parametrize("distance", [0.0, 1e-30, 1e-6, 1.0, 1e9, 1e30, 1e300])
def test_any_distance_has_a_level(distance):
    position = np.array([[distance, 0.0, 0.0]])
    keys = keys_at(position)
    assert keys.level[0] >= 0
    wanted = 0.05 * distance
    if 1e-3 <= wanted < 1e15:
        assert edges(keys.level)[0] <= wanted < 2 * edges(keys.level)[0]
    grid = build_grid(keys, everyone(keys), 4)
    assert find_cells(grid, keys).tolist() == [0]


def test_levels_are_those_of_the_formula():
    position = points(2000, scale=20.0)
    distance = np.linalg.norm(position, axis=1)
    ratio = 1e3 * distance * 0.05
    expected = np.maximum(np.floor(np.log2(ratio)), 0)
    away = np.abs(np.log2(ratio) - np.rint(np.log2(ratio))) > 1e-9
    np.testing.assert_array_equal(levels(LATTICE, position)[away], expected[away])


def test_a_cell_is_some_pixels_wide():
    camera = Camera((0, 0, 0), (0, 0, -1), fov=60.0, width=640, height=480)
    lattice = lattice_of(camera)
    pixel = 2 * np.tan(np.radians(30)) / 640
    size = edges(levels(lattice, np.array([[0.0, 0.0, -7.0]])))[0] / 7.0
    assert 6 * pixel < size < 20 * pixel


def test_normals_tell_cells_apart_where_they_are_asked_for():
    position = np.tile([[1.0, 2.0, 3.0]], (2, 1))
    normal = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    alike = keys_of(LATTICE, position, normal)
    apart = keys_of(Lattice((0.0, 0.0, 0.0), 0.05, 3), position, normal)
    assert tuples(alike)[0] == tuples(alike)[1]
    assert tuples(apart)[0] != tuples(apart)[1]
    assert set(alike.facing) == {0}


def test_jitter_stays_in_the_tangent_plane():
    position, normal = points(500), normalize(points(500, 1))
    u = np.random.default_rng(2).random((4, 500))
    moved = jittered(LATTICE, position, normal, tuple(u)) - position
    size = edges(levels(LATTICE, position))
    assert np.abs(dot(moved, normal)).max() < 1e-12
    length = np.linalg.norm(moved, axis=1) / size
    assert length.max() <= 2.0
    assert 0.9 < length.mean() < 1.3  # a square of half side √2: 0.765 · √2 = 1.08
    with_middle = jittered(LATTICE, position, normal, tuple(0 * u + 0.5))
    np.testing.assert_allclose(with_middle, position, atol=1e-12)


# ------------------------------------------------------------ hashes


def test_hashes_are_known():
    """Calculated by hand, in whole numbers without a limit."""

    def by_hand_pcg(v):
        state = (v * 747796405 + 2891336453) % 2**32
        word = (((state >> ((state >> 28) + 4)) ^ state) * 277803737) % 2**32
        return (word >> 22) ^ word

    def by_hand_xx(v):
        h = (v + 374761393) % 2**32
        h = (((h << 17) | (h >> 15)) % 2**32 * 668265263) % 2**32
        h = ((h ^ (h >> 15)) * 2246822519) % 2**32
        h = ((h ^ (h >> 13)) * 3266489917) % 2**32
        return h ^ (h >> 16)

    words = np.array([0, 1, 2, 12345, 2**31, 2**32 - 1], np.uint32)
    assert pcg(words).tolist() == [by_hand_pcg(int(w)) for w in words]
    assert xxhash(words).tolist() == [by_hand_xx(int(w)) for w in words]
    keys = keys_at(np.concatenate([points(50), -1e12 * points(50)]))
    for by_hand, found in ((by_hand_pcg, buckets_of), (by_hand_xx, checksums)):
        for cell, nested in zip(tuples(keys), found(keys), strict=True):
            wanted = 0
            for word in reversed(cell):
                wanted = by_hand((word + wanted) % 2**32)
            assert nested == wanted


def test_no_checksum_is_that_of_a_free_slot():
    assert min(checksums(keys_at(points(5000)))) >= 1


# ------------------------------------------------------------ visits


def visited(count, most, u):
    keys = keys_at(np.full((count, 3), 0.3))
    grid = build_grid(keys, everyone(keys), 4)
    cells = np.zeros(len(u), np.int64)
    return np.stack(visits(grid, cells, u, most))


@pytest.mark.parametrize("most", [1, 3, 4])
@pytest.mark.parametrize("count", [1, 2, 4, 5, 6, 7, 30])
def test_a_look_up_takes_no_vertex_twice_and_all_alike(count, most):
    """Over a lattice of starts that meets each place as often."""
    u = (np.arange(count * 8) + 0.5) / (count * 8)
    found = visited(count, most, u)
    for column in found.T:
        taken = column[column != NONE]
        assert len(set(taken)) == len(taken) == min(count, most)
    times = np.bincount(found[found != NONE], minlength=count)
    assert np.ptp(times) == 0


def test_a_vertex_of_nowhere_is_none():
    keys = keys_at(points(5))
    grid = build_grid(keys, everyone(keys), 4)
    assert (np.stack(visits(grid, np.full(3, NOWHERE), np.zeros(3), 2)) == NONE).all()


# ------------------------------------------------------------ time and memory


@pytest.mark.slow
@pytest.mark.parametrize("scale", [3.0, 3000.0])
def test_a_million_vertices_take_no_more_memory_than_they_may(scale):
    """Of the second scale nearly each is alone in its cell."""
    keys = keys_at(points(1_000_000, scale=scale))
    grid = build_grid(keys, everyone(keys), 1 << 20)
    assert grid.lost == 0
    held = [grid.slot, grid.index_buffer, grid.cell_storage]
    held += [grid.hashes, grid.by_hash]
    held += [getattr(grid.cells, field.name) for field in fields(Keys)]
    assert sum(a.nbytes for a in held) <= 64 * len(keys)
