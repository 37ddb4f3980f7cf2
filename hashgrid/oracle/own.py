"""The project's own passes of the hash grid: the production functions, as they are."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.extensions.oracle.reuse.own import OWN as REUSE_OWN
from restir_gi.hashgrid.grid import (
    BUCKET,
    NOWHERE,
    Grid,
    Hashes,
    Keys,
    Lattice,
    atom_inc,
    base_of,
    edges,
    faces_alike,
    find_or_insert,
    keys_in,
    levels,
    moved_in_plane,
    prefix_sum,
    scatter_by_cell,
    search,
    visits,
)
from restir_gi.hashgrid.lights import from_light
from restir_gi.hashgrid.oracle.contract import COLUMNS
from restir_gi.hashgrid.path_settings import CellSettings
from restir_gi.hashgrid.regir_gi import (
    one_suffix,
    only_where,
    weight_in_cell,
    with_longer,
)
from restir_gi.hashgrid.world_reservoirs import resampled
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.oracle.builtin.buffers import Array, as_real
from restir_gi.reference.oracle.builtin.world import surface_of, world_of
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.resampling.reservoir import Candidates, initial_candidates
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.light_sampling import seen_on_area


def _wide(values: Array) -> Array:
    return values.astype(np.int64)


def _rows(values: Array) -> Array:
    return values.astype(np.int32)


# ---------------------------------------------------------------- the cell of a point


def _cell_base(
    precision: Precision, fov_y: Array, width: Array, height: Array
) -> dict[str, Array]:
    base = base_of(fov_y.astype(float), _wide(width), _wide(height))
    return {"base": as_real(precision, base)}


def _cell_level(
    precision: Precision, position: Array, when: str, **settings: Any
) -> dict[str, Array]:
    end = "_before" if when == "look-up" else ""
    x, y, z = (float(settings[f"eye{end}_{axis}"]) for axis in "xyz")
    lattice = Lattice((x, y, z), float(settings[f"base{end}"]))
    return {"level": _rows(levels(lattice, position.astype(float)))}


def _edges_of(size: Array, given: str) -> Array:
    """Edges of cells, (N,) float64, m."""
    return size.astype(float) if given == "edge" else edges(_wide(size))


def _cell_jitter(
    precision: Precision,
    position: Array,
    normal: Array,
    u: Array,
    size: str = "level",
    **sizes: Array,
) -> dict[str, Array]:
    lanes = u[:, 0], u[:, 1], u[:, 0], u[:, 1]
    edge = _edges_of(sizes[size], size).astype(position.dtype)
    moved = moved_in_plane(position, normal, edge, lanes)
    return {"moved": as_real(precision, moved)}


def _cell_key(
    precision: Precision,
    position: Array,
    normal: Array,
    facings: int,
    size: str = "level",
    **sizes: Array,
) -> dict[str, Array]:
    level = np.zeros(len(position), np.int64)
    edge = _edges_of(sizes[size], size)
    place, facing = position.astype(float), normal.astype(float)
    keys = keys_in(level, edge, place, facing, facings)
    return {n: _rows(getattr(keys, n)) for n in ("x", "y", "z", "facing")}


def _cell_hash(
    precision: Precision, level: Array, x: Array, y: Array, z: Array, facing: Array
) -> dict[str, Array]:
    hashes = Keys(level, _wide(x), _wide(y), _wide(z), facing).hashes
    return {
        "bucket_hash": (hashes >> np.uint64(32)).astype(np.uint32),
        "checksum": hashes.astype(np.uint32),
    }


# ---------------------------------------------------------------- Algorithm 2


def _cells(bucket: Array, checksum: Array) -> tuple[Hashes, Keys]:
    """Cells that are told apart by these two words alone."""
    high = bucket.astype(np.uint64) << np.uint64(32)
    none = np.zeros(len(bucket), np.int64)
    keys = Keys(none, _wide(bucket), _wide(checksum), none, none)
    return high | checksum.astype(np.uint64), keys


def _cell_insert(
    precision: Precision,
    bucket_hash: Array,
    checksum: Array,
    active: Array,
    buckets: int,
) -> dict[str, Array]:
    v = np.flatnonzero(active)
    order, head, slot = find_or_insert(*_cells(bucket_hash[v], checksum[v]), buckets)
    found = np.full(len(active), NOWHERE)
    found[v[order]] = np.repeat(slot, np.diff(np.append(head, len(order))))
    return {"slot": _rows(found)}


def _cell_count(precision: Precision, slot: Array, left: Array) -> dict[str, Array]:
    has = slot != NOWHERE
    counters, index_in_cell = atom_inc(slot[has], len(slot))
    place = np.full(len(slot), NOWHERE)
    place[has] = index_in_cell
    return {"counter": _rows(counters), "place": _rows(place)}


def _cell_scan(precision: Precision, counter: Array) -> dict[str, Array]:
    return {"start": _rows(prefix_sum(_wide(counter))[:-1])}


def _cell_scatter(
    precision: Precision, slot: Array, place: Array, start: Array
) -> dict[str, Array]:
    v = np.flatnonzero(slot != NOWHERE)
    stored = scatter_by_cell(_wide(start), v, slot[v], _wide(place[v]))
    return {"storage": _rows(np.append(stored, np.zeros(len(slot) - len(stored))))}


# ---------------------------------------------------------------- the look-up


def _grid(cells: Keys, hashes: Hashes, index_buffer: Array, storage: Array) -> Grid:
    by_hash = np.argsort(hashes)
    return Grid(
        buckets=1,
        cells=cells,
        slot=np.arange(len(hashes), dtype=np.int32),
        index_buffer=index_buffer,
        cell_storage=storage,
        lost=0,
        hashes=hashes[by_hash],
        by_hash=by_hash.astype(np.int32),
    )


def _cell_find(
    precision: Precision,
    table: Array,
    bucket_hash: Array,
    checksum: Array,
    buckets: int,
) -> dict[str, Array]:
    taken = np.flatnonzero(table[: buckets * BUCKET])
    hashes, cells = _cells(taken // BUCKET, table[taken])
    none = np.zeros(len(taken) + 1, np.int64)
    grid = _grid(cells, hashes, none, none[:0])
    wanted = _cells(_wide(bucket_hash) % buckets, checksum)
    found = search(grid, *wanted)
    return {
        "slot": _rows(np.where(found == NOWHERE, NOWHERE, np.append(taken, 0)[found]))
    }


def _cell_visit(
    precision: Precision,
    slot: Array,
    start: Array,
    counter: Array,
    storage: Array,
    u: Array,
    most: int,
) -> dict[str, Array]:
    hashes, cells = _cells(np.arange(len(slot)), np.ones(len(slot)))
    # A GPU reads base and counter of a cell; here the next base tells both.
    index_buffer = np.append(_wide(start), start[-1] + counter[-1])
    grid = _grid(cells, hashes, index_buffer, _wide(storage))
    found = np.full((len(slot), COLUMNS), NONE)
    found[:, :most] = np.stack(visits(grid, _wide(slot), u.astype(float), most), axis=1)
    return {"vertex": _rows(found)}


def _cell_similar(
    precision: Precision, normal_a: Array, normal_b: Array
) -> dict[str, Array]:
    return {"similar": faces_alike(normal_a, normal_b).astype(np.uint32)}


# ---------------------------------------------------------------- light in cells


def _light_target(
    precision: Precision,
    visible_position: Array,
    visible_normal: Array,
    albedo: Array,
    light_position: Array,
    light_normal: Array,
    radiance: Array,
    area: Array,
) -> dict[str, Array]:
    points = surface_of(visible_position, visible_normal, albedo)
    light = seen_on_area(
        visible_position, light_position, light_normal, radiance, 1 / area
    )
    value = from_light(world_of().materials, points, light)
    return {"value": as_real(precision, value)}


def _light_candidates(
    precision: Precision, p_hat: Array, choice: Array, density: Array, u: Array
) -> dict[str, Array]:
    def drawn(k: int) -> tuple[Candidates, Scalars]:
        slot = np.full(len(u), k)
        pdf = choice[:, k] * density[:, k]
        return initial_candidates(slot, p_hat[:, k], pdf), u[:, k]

    r = resampled(map(drawn, range(u.shape[1])))
    return {
        "slot": _rows(r.y),
        "W": as_real(precision, r.W),
        "M": as_real(precision, r.M),
    }


def _light_reuse(precision: Precision, W: Array, **given: Any) -> dict[str, Array]:
    """The engine itself: the shift of a point on a light is the identity."""
    found: dict[str, Array] = REUSE_OWN["path_reuse"](
        precision, W=W, jacobian=np.ones_like(W), canonical=0, **given
    )
    return found


# ---------------------------------------------------------------- suffixes of paths


@dataclass(frozen=True, slots=True)
class _Ways:
    """Suffixes by their values, and whether they go on."""

    longer: Indices
    value: Vec3s


def _bounce_reservoir(
    precision: Precision,
    value_end: Array,
    w_end: Array,
    weight: Array,
    value_suffix: Array,
    W_suffix: Array,
    u: Array,
) -> dict[str, Array]:
    ones = np.ones(len(u), np.int64)
    end = _Ways(0 * ones, value_end)
    found = Candidates(end, luminance(value_end), w_end, np.ones_like(w_end))
    onward: Any = _Ways(ones, weight * value_suffix)
    r = one_suffix(with_longer(found, onward, W_suffix, u))
    return {
        "longer": r.y.longer.astype(np.uint32),
        "value": as_real(precision, r.y.value),
        "W": as_real(precision, r.W),
        "M": as_real(precision, r.M),
    }


def _path_cache(
    precision: Precision, rough: Array, joint: Array, W: Array, M: Array
) -> dict[str, Array]:
    kept = weight_in_cell(joint, W)
    stored = (rough == 1) & CellSettings().inserts(kept)
    return {
        "stored": stored.astype(np.uint32),
        "W": as_real(precision, kept),
        "M": as_real(precision, M),
    }


def _suffix_reach(
    precision: Precision,
    end: Array,
    v: Array,
    value: Array,
    jacobian: Array,
    bounces: int,
) -> dict[str, Array]:
    there, factor = only_where(end <= bounces + 2 - v, (value, jacobian))
    return {"value": as_real(precision, there), "jacobian": as_real(precision, factor)}


HASH_GRID_OWN: Mapping[str, Callable[..., dict[str, Array]]] = {
    "cell_base": _cell_base,
    "cell_level": _cell_level,
    "cell_jitter": _cell_jitter,
    "cell_key": _cell_key,
    "cell_hash": _cell_hash,
    "cell_insert": _cell_insert,
    "cell_count": _cell_count,
    "cell_scan": _cell_scan,
    "cell_scatter": _cell_scatter,
    "cell_find": _cell_find,
    "cell_visit": _cell_visit,
    "cell_similar": _cell_similar,
    "light_target": _light_target,
    "light_candidates": _light_candidates,
    "light_reuse": _light_reuse,
    "bounce_reservoir": _bounce_reservoir,
    "path_cache": _path_cache,
    "suffix_reach": _suffix_reach,
}
"""The passes of this part."""
