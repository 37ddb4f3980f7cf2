"""Cases of the hash grid: made here, without a scene, the same for a seed."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from restir_gi.hashgrid.oracle.rules import SLOTS
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.draws import (
    about,
    ends_of_u,
    spread,
    unit_vectors,
)
from restir_gi.reference.oracle.parts import SEED

ROWS = 512
Parts = tuple[str, dict[str, Value], dict[str, Any]]

UNEVEN = {"scan-null", "level-equal", "key-borders"}
"""Cases whose decisions do not hang on numbers that were drawn."""


def hash_grid_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases of all passes, in the order of the contract.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given: numbers that float32 holds.
    seed : int; of all rows that are random
    """
    rng = np.random.default_rng([2031, seed])
    makers = (
        ("cell_base", _bases),
        ("cell_level", _levels),
        ("cell_jitter", _jitters),
        ("cell_key", _keys),
        ("cell_hash", _hashes),
        ("cell_insert", _inserts),
        ("cell_count", _counts),
        ("cell_scan", _scans),
        ("cell_scatter", _scatters),
        ("cell_find", _finds),
        ("cell_visit", _visits),
        ("cell_similar", _similar),
        ("light_target", _targets),
        ("light_candidates", _candidates),
        ("light_reuse", _reuses),
        ("bounce_reservoir", _bounces),
        ("path_cache", _caches),
        ("suffix_reach", _reaches),
    )
    return [
        _case(pass_name, name, settings, inputs, precision)
        for pass_name, maker in makers
        for name, settings, inputs in maker(rng)
    ]


def cases_of_edges(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases of passes that are given the edges of cells, by whatever rule."""
    rng = np.random.default_rng([2032, seed])
    found = []
    for pass_name, maker in (("cell_jitter", _jitters), ("cell_key", _keys)):
        for name, settings, inputs in maker(rng):
            level = inputs.pop("level")
            edge = {"edge": 0.0125 * 1.5 ** (level - 6.0) * rng.uniform(1, 1.4, ROWS)}
            settings |= {"size": "edge"}
            made = _case(pass_name, name, settings, inputs | edge, precision)
            found.append(replace(made, name=f"{made.name}-edges"))
    return found


def _case(
    pass_name: str,
    name: str,
    settings: dict[str, Value],
    inputs: dict[str, Any],
    precision: Precision,
) -> Case:
    # A frame about a normal is as orthogonal as that is a unit vector.
    whole = {"normal"} if pass_name == "cell_jitter" else set()
    held = {
        n: v.astype(np.float32) if v.dtype.kind == "f" and n not in whole else v
        for n, v in inputs.items()
    }
    is_random = name not in UNEVEN
    return Case(f"grid-{name}", pass_name, settings, given(held, precision), is_random)


# ---------------------------------------------------------------- the cell of a point

EYES = ((1.5, 2.0, -3.0), (-2.5, 1.0, 4.5))
BEFORE = ((-4.0, 0.5, 1.0), (3.0, -2.0, 0.25))
BASES = ((0.03125, 0.0625), (0.1875, 0.046875))


def _bases(rng: Generator) -> Iterator[Parts]:
    width, height = (spread(rng, 1, 3.7, ROWS).astype(int) for _ in range(2))
    # A few pixels, of which 16 are seen under a large angle; and one row or column.
    few = rng.integers(1, 40, (2, ROWS // 4))
    width[::4], height[::4] = few
    inputs = {
        "fov_y": rng.uniform(0.1, 2.6, ROWS),
        "width": width,
        "height": height,
    }
    yield "base", {}, inputs


def _rays(rng: Generator, eye: tuple[float, ...]) -> Vec3s:
    """Points along the axes through an eye, each twice, (N, 3)."""
    t = 1.25 ** (np.arange(-12, 26) + rng.random())
    sides = np.concatenate([np.eye(3), -np.eye(3)])
    once = np.asarray(eye) + (t[:, None, None] * sides).reshape(-1, 3)
    return np.concatenate([once, once])


def _levels(rng: Generator) -> Iterator[Parts]:
    for when in ("insertion", "look-up"):
        for k in range(2):
            settings: dict[str, Value] = {"when": when}
            for name, eye in (("eye", EYES[k]), ("eye_before", BEFORE[k])):
                settings |= dict(zip((f"{name}_{a}" for a in "xyz"), eye, strict=True))
            settings |= {"base": BASES[k][0], "base_before": BASES[k][1]}
            looked_from = EYES[k] if when == "insertion" else BEFORE[k]
            distance = spread(rng, -1.5, 2.5, ROWS)
            distance[::8] = spread(rng, -3.5, -2.0, ROWS // 8)
            position = looked_from + distance[:, None] * unit_vectors(rng, ROWS)
            yield f"level-{when}-{k}", settings, {"position": position}
    # At the very borders, and beside them; the eye in the origin.
    power = np.arange(0, 24)
    border = 2.0**power / (1000 * 0.03125)
    near = (
        np.array([1, 1 - 1e-4, 1 + 1e-4, 1 - 1e-6, 1 + 1e-6]) * border[:, None]
    ).ravel()
    position = np.zeros((len(near) + 1, 3))
    position[: len(near), 1] = near
    settings = {"when": "insertion", "base": 0.03125, "base_before": 1.0}
    for name in ("eye", "eye_before"):
        settings |= {f"{name}_{a}": 0.0 for a in "xyz"}
    yield "level-equal", settings, {"position": position}

    # Past the eye of the other frame, and close by the origin.
    eye, before = (1.5, 0.0625, 0.0), (-2.5, 0.0625, 0.0)
    for when, e in (("insertion", eye), ("look-up", before)):
        settings = {"when": when, "base": 0.0625, "base_before": 0.09375}
        for name, place in (("eye", eye), ("eye_before", before)):
            settings |= dict(zip((f"{name}_{a}" for a in "xyz"), place, strict=True))
        ending = "-before" if when == "look-up" else ""
        yield f"level-rays{ending}", settings, {"position": _rays(rng, e)}


def _jitters(rng: Generator) -> Iterator[Parts]:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    normals = np.concatenate([unit_vectors(rng, 58), axes])
    normal = normals[rng.integers(0, len(normals), ROWS)]
    level = rng.integers(0, 14, ROWS)
    edge = np.ldexp(1e-3, level)
    far = edge * spread(rng, -1, 3, ROWS)
    yield (
        "jitter",
        {},
        {
            "position": far[:, None] * unit_vectors(rng, ROWS),
            "normal": normal,
            "level": level,
            "u": ends_of_u(rng, 2 * ROWS).reshape(ROWS, 2),
        },
    )


def _keys(rng: Generator) -> Iterator[Parts]:
    for facings in (1, 3, 16):
        level = rng.integers(0, 15, ROWS)
        edge = np.ldexp(1e-3, level)
        units = rng.normal(size=(ROWS, 3)) * spread(rng, -0.5, 4, ROWS)[:, None]
        normal = unit_vectors(rng, ROWS)
        normal[1::8] = np.eye(3)[rng.integers(0, 3, ROWS // 8)] * rng.choice(
            [-1.0, 1.0], (ROWS // 8, 1)
        )
        inputs = {"position": units * edge[:, None], "normal": normal, "level": level}
        yield f"key-{facings}", {"facings": facings}, inputs
    # Beside the borders of cells, on them, and about 0.
    aside = rng.choice([1e-3, -1e-3, 0.0], (ROWS, 3))
    units = rng.integers(-30, 30, (ROWS, 3)) + aside
    level = rng.integers(0, 15, ROWS)
    position = units * np.ldexp(1e-3, level)[:, None]
    normal = np.clip(rng.integers(-2, 3, (ROWS, 3)) / 2 + aside, -1, 1)
    inputs = {"position": position, "normal": normal, "level": level}
    yield "key-borders", {"facings": 4}, inputs


# ---------------------------------------------------------------- its hashes

WORD = 2**32


def _hashes(rng: Generator) -> Iterator[Parts]:
    size = 384
    fields: dict[str, Indices] = {
        "level": rng.integers(0, 40, size),
        "facing": rng.integers(0, 4096, size) * (rng.random(size) < 0.6),
    }
    for n in "xyz":
        number = np.rint(rng.normal(size=size) * spread(rng, 0, 8, size))
        fields[n] = np.clip(number, -(2**31), 2**31 - 1).astype(np.int64)
    for row, cell in enumerate(np.ndindex(2, 2, 2, 2)):
        for name, part in zip("xyz", cell[1:], strict=True):
            fields[name][row] = part
        fields["level"][row], fields["facing"][row] = cell[0], 0
    # x of cells whose checksum would be 0.
    rest: Indices = np.zeros(48, np.int64)
    for name in ("facing", "z", "y"):
        rest = _mixed((fields[name][-48:] + rest) % WORD)
    wanted = (_unmixed(np.zeros(48, np.int64)) - fields["level"][-48:]) % WORD
    x = (_unmixed(wanted) - rest) % WORD
    fields["x"][-48:] = np.where(x < WORD // 2, x, x - WORD)
    yield "hash", {}, {n: np.concatenate([a, _of_pairs(n)]) for n, a in fields.items()}


PAIRS = {
    "level": [3, 3, 3, 3, 3, 4, 3, 3, 3],
    "facing": [5, 5, 5, 5, 5, 5, 6, 0, 0],
    "x": [-3, -4, -3, -3, 0, -3, -3, 7, -7],
    "y": [-9, -9, -9, -9, -9, -9, -9, 8, -8],
    "z": [11, 11, 11, 12, 11, 11, 11, 9, -9],
}
"""Cells that have all but one field, or their sizes, in common; the first is twice."""


def _of_pairs(name: str) -> Indices:
    """A field of such cells, and of as many beside them."""
    each = 20 * np.arange(24)[:, None] * (name in "xyz")
    return (
        np.array(PAIRS[name]) + np.where(np.array(PAIRS[name]) < 0, -1, 1) * each
    ).ravel()


STEPS = ((15, 2246822519), (13, 3266489917))
FIRST, FACTOR = 374761393, 668265263


def _mixed(word: Indices) -> Indices:
    """xxHash32 of words, in whole numbers without a limit."""
    return np.array([_mix(int(v)) for v in word], np.int64)


def _mix(v: int) -> int:
    s = (v + FIRST) % WORD
    s = (s << 17 | s >> 15) % WORD * FACTOR % WORD
    for shift, factor in STEPS:
        s = (s ^ s >> shift) * factor % WORD
    return s ^ s >> 16


def _unmixed(word: Indices) -> Indices:
    """Words that have given hashes: each step of it can be undone."""
    return np.array([_unmix(int(v)) for v in word], np.int64)


def _unmix(s: int) -> int:
    s = _unshifted(s, 16)
    for shift, factor in reversed(STEPS):
        s = _unshifted(s * pow(factor, -1, WORD) % WORD, shift)
    s = s * pow(FACTOR, -1, WORD) % WORD
    return ((s >> 17 | s << 15) % WORD - FIRST) % WORD


def _unshifted(s: int, shift: int) -> int:
    found = s
    for _ in range(32 // shift + 1):
        found = s ^ found >> shift
    return found


# ---------------------------------------------------------------- Algorithm 2


def _inserts(rng: Generator) -> Iterator[Parts]:
    # Few cells a bucket, many, too many, and as many as there are slots.
    kinds = (61, 400, 1024), (11, 150, 700), (7, 160, 700), (13, 13 * SLOTS, 600)
    for buckets, cells, rows in kinds:
        bucket = rng.integers(0, buckets, cells)
        if cells == buckets * SLOTS:
            # Each bucket is just full.
            bucket = np.arange(cells) % buckets
        if buckets == 11:
            # Beside buckets that are too full there is room.
            bucket = np.where(rng.random(cells) < 0.7, bucket // 2 * 2, bucket)
        table = _distinct_cells(rng, bucket, buckets, shared=buckets == 61)
        which = np.concatenate([np.arange(cells), rng.integers(0, cells, rows - cells)])
        which = rng.permutation(which)
        inputs = {
            "bucket_hash": table[0][which].astype(np.uint32),
            "checksum": table[1][which].astype(np.uint32),
            "active": (rng.random(rows) < 0.85).astype(np.uint32),
        }
        yield f"insert-{buckets}", {"buckets": buckets}, inputs


def _distinct_cells(
    rng: Generator, bucket: Indices, buckets: int, shared: bool
) -> tuple[Indices, Indices]:
    """Hashes and checksums of cells, of which those of a bucket have different ones.

    If they are shared, some checksums are the same in several buckets.
    """
    cells = len(bucket)
    # Some cells of a bucket have the same hash, whose checksums differ all the same.
    above = rng.integers(0, WORD // buckets - 1, max(cells // 4, 3))
    hash_ = bucket + buckets * above[rng.integers(0, len(above), cells)]
    checksum = rng.integers(1, WORD, cells)
    if shared:
        few = rng.choice(checksum, 24, replace=False)
        checksum[::2] = few[rng.integers(0, 24, len(checksum[::2]))]
    # Neither in the bucket of the remainder, nor in that of the upper bits.
    for of in (bucket, hash_ * buckets // WORD):
        _, first = np.unique(of * WORD + checksum, return_index=True)
        again = np.setdiff1d(np.arange(cells), first)
        checksum[again] = rng.integers(1, WORD, len(again))
    return hash_, checksum


def _lists(rng: Generator, rows: int) -> dict[str, Indices]:
    """Vertices in slots: slot and place of each, counters and bases."""
    cells = rng.choice(rows, rows // 5, replace=False)
    slot = cells[(rng.random(rows) ** 2 * len(cells)).astype(int)]
    slot = np.where(rng.random(rows) < 0.1, -1, slot)
    counter = np.bincount(slot[slot >= 0], minlength=rows)
    start = np.cumsum(counter) - counter
    turn = rng.permutation(rows)
    order = turn[np.argsort(slot[turn], kind="stable")]
    order = order[slot[order] >= 0]
    place = np.full(rows, -1)
    place[order] = np.arange(len(order)) - start[slot[order]]
    return {"slot": slot, "place": place, "counter": counter, "start": start}


def _counts(rng: Generator) -> Iterator[Parts]:
    for name in ("count", "count-again"):
        slot = _lists(rng, ROWS)["slot"]
        left = rng.integers(0, 40, ROWS) * (rng.random(ROWS) < 0.7)
        yield name, {}, {"slot": slot, "left": left}


def _scans(rng: Generator) -> Iterator[Parts]:
    counter = rng.integers(0, 6, 2500) * (rng.random(2500) < 0.4)
    counter[rng.integers(0, 2500, 4)] = 1000
    yield "scan", {}, {"counter": counter}
    yield "scan-null", {}, {"counter": np.zeros(300, np.int64)}


def _scatters(rng: Generator) -> Iterator[Parts]:
    for name in ("scatter", "scatter-again"):
        lists = _lists(rng, ROWS)
        yield name, {}, {n: lists[n] for n in ("slot", "place", "start")}


# ---------------------------------------------------------------- the look-up


def _finds(rng: Generator) -> Iterator[Parts]:
    for buckets, rows in ((40, 640), (29, 512)):
        filled = rng.choice([0, 3, 9, 15, 16, 16, 16], buckets)
        held = rng.integers(1, WORD, (buckets, SLOTS))
        held[np.arange(SLOTS) >= filled[:, None]] = 0
        table = np.zeros(rows, np.int64)
        table[: buckets * SLOTS] = held.ravel()
        bucket = rng.integers(0, buckets, rows)
        checksum = rng.integers(1, WORD, rows)
        # Cells that are there, many of them last in their bucket; and, in full buckets,
        # cells that are in the next bucket alone.
        place = np.where(
            rng.random(rows) < 0.3, filled[bucket] - 1, rng.integers(0, SLOTS, rows)
        )
        there = held[bucket, np.maximum(place, 0)]
        kind = rng.random(rows)
        checksum = np.where((kind < 0.6) & (there > 0), there, checksum)
        nearby = held[(bucket + 1) % buckets, rng.integers(0, SLOTS, rows)]
        full = filled[bucket] == SLOTS
        checksum = np.where((kind > 0.75) & full & (nearby > 0), nearby, checksum)
        hash_ = bucket + buckets * rng.integers(0, WORD // buckets - 1, rows)
        # Of some the upper bits tell the bucket.
        upper = (bucket + rng.uniform(0.01, 0.99, rows)) / buckets * WORD
        hash_ = np.where(rng.random(rows) < 0.4, upper.astype(np.int64), hash_)
        inputs = {
            "table": table.astype(np.uint32),
            "bucket_hash": hash_.astype(np.uint32),
            "checksum": checksum.astype(np.uint32),
        }
        yield f"find-{buckets}", {"buckets": buckets}, inputs


SIZES = (1, 2, 3, 5, 8, 13, 40, 90)
ASKED, NOWHERE = 192, 64
"""Look-ups of each cell, and those that have found none."""


def _visits(rng: Generator) -> Iterator[Parts]:
    for most in (1, 3, 4, 8):
        rows = len(SIZES) * ASKED + NOWHERE
        cell = np.sort(rng.choice(rows - 1, len(SIZES), replace=False))
        cell[0] = 0
        sizes = rng.permutation(SIZES)
        counter = np.zeros(rows, np.int64)
        counter[cell] = sizes
        u = (np.arange(ASKED) + rng.random(ASKED)) / ASKED
        u = np.minimum(
            np.concatenate([np.tile(u, len(SIZES)), rng.random(NOWHERE)]), 1 - 2.0**-24
        )
        slot = np.concatenate([np.repeat(cell, ASKED), np.full(NOWHERE, -1)])
        turn = rng.permutation(rows)
        inputs = {
            "slot": slot[turn],
            "start": np.cumsum(counter) - counter,
            "counter": counter,
            "storage": rng.permutation(rows),
            "u": u[turn],
        }
        yield f"visit-{most}", {"most": most}, inputs


def _similar(rng: Generator) -> Iterator[Parts]:
    normal = unit_vectors(rng, ROWS)
    cosine = rng.uniform(-1, 1, ROWS)
    least = 0.5**0.25
    cosine[::4] = least + rng.choice([-1, 1], ROWS // 4) * spread(
        rng, -4, -1, ROWS // 4
    )
    other = about(rng, normal, np.clip(cosine, -1, 1))
    yield "similar", {}, {"normal_a": normal, "normal_b": other}


# ---------------------------------------------------------------- light in cells


def _turned(rng: Generator, axis: Vec3s) -> Vec3s:
    """Normals that see an axis, most of them, under any angle."""
    cosine = rng.uniform(0.02, 1, len(axis)) * np.where(
        rng.random(len(axis)) < 0.75, 1, -1
    )
    return about(rng, axis, cosine)


def _targets(rng: Generator) -> Iterator[Parts]:
    for name, near, far in (("room", -1.5, 1), ("hall", 0.5, 2.5)):
        x, axis = rng.normal(size=(ROWS, 3)), unit_vectors(rng, ROWS)
        d = spread(rng, near, far, ROWS)
        dark = rng.random((ROWS, 1)) < 0.05
        inputs = {
            "visible_position": x,
            "visible_normal": _turned(rng, axis),
            "albedo": rng.uniform(0.02, 0.98, (ROWS, 3)),
            "light_position": x + d[:, None] * axis,
            "light_normal": _turned(rng, -axis),
            "radiance": np.where(dark, 0.0, 10.0 ** rng.uniform(-2, 3, (ROWS, 3))),
            "area": spread(rng, -3, 1.5, ROWS),
        }
        yield f"light-{name}", {}, inputs


def _candidates(rng: Generator) -> Iterator[Parts]:
    for count in (8, 3, 24):
        shape = (ROWS, count)
        p_hat = 10.0 ** rng.normal(0, 0.7, shape) * (rng.random(shape) < 0.6)
        p_hat[::9] = 0.0
        choice = rng.uniform(1e-3, 1, shape) ** 2
        # Lights among very many: of weights that no half holds.
        choice[1::8] *= 1e-4
        inputs = {
            "p_hat": p_hat,
            "choice": choice,
            "density": 10.0 ** rng.normal(0, 0.7, shape),
            "u": ends_of_u(rng, ROWS * count).reshape(shape),
        }
        yield f"drawn-{count}", {}, inputs


def _reuses(rng: Generator) -> Iterator[Parts]:
    for mis in ("1/M", "1/Z", "balance", "pairwise", "defensive"):
        # The last is below the confidence of what the vertex itself has drawn.
        for cap in (20.0, 44.0, 4.0):
            word = mis.replace("/", "-over-")
            inputs = _light_tables(rng, 5, int(cap))
            yield f"reuse-{word}-{cap:.0f}", {"mis": mis, "cap": cap}, inputs


def _light_tables(rng: Generator, slots: int, cap: int) -> dict[str, NDArray[Any]]:
    """What the vertex itself drew, in slot 0, and what vertices of its cells kept."""
    shape = (ROWS, slots)

    def targets(*more: int) -> Scalars:
        found: Scalars = 10.0 ** rng.normal(0, 0.6, (*shape, *more))
        return found

    own = np.arange(slots) == 0
    there = (rng.random(shape) > 0.15) | own
    full = there & (rng.random(shape) > 0.25)
    base = np.where(full, targets(), 0.0)
    here = np.where(full & (rng.random(shape) > 0.2), targets(), 0.0)
    here[:, 0] = base[:, 0]
    usable = here > 0
    known = rng.random((*shape, slots)) > 0.3
    # Of lights that are found seldom: a half holds these weights, and no larger ones.
    seldom = np.where(np.arange(ROWS) % 8 == 1, 1e5, 1.0)[:, None]
    return {
        "W": np.minimum(np.where(full, targets(), 0.0) * seldom, 6e4),
        "M": np.where(own, 8.0, rng.integers(1, cap + 1, shape)),
        "there": there.astype(np.uint32),
        "target_base": base,
        "target_here": here,
        "target_at": np.where(known & usable[:, :, None], targets(slots), 0.0),
        "u": ends_of_u(rng, ROWS * slots).reshape(shape),
    }


# ---------------------------------------------------------------- suffixes of paths

Y = np.array([0.2126, 0.7152, 0.0722])


def _bounces(rng: Generator) -> Iterator[Parts]:
    def light(share: float) -> Vec3s:
        found: Vec3s = 10.0 ** rng.normal(0, 0.7, (ROWS, 3))
        return found * (rng.random((ROWS, 1)) < share)

    for name, scale in (("bounce", 1.0), ("bounce-dim", 1e-3)):
        end = scale * light(0.6)
        # Two techniques may have found it: its weight is not its target alone.
        w_end = (end @ Y) * rng.uniform(0.5, 3, ROWS)
        suffix = scale * light(0.6)
        inputs = {
            "value_end": end,
            "w_end": w_end,
            "weight": rng.uniform(0.05, 1.5, (ROWS, 3)),
            "value_suffix": suffix,
            "W_suffix": np.where(suffix.any(axis=1), spread(rng, -1, 1, ROWS), 0.0),
            "u": ends_of_u(rng, ROWS),
        }
        yield name, {}, inputs


def _caches(rng: Generator) -> Iterator[Parts]:
    inputs = {
        "rough": (rng.random(ROWS) < 0.75).astype(np.uint32),
        "joint": rng.choice([0, 2, 2, 2, 3, 4], ROWS),
        "W": spread(rng, -2, 6, ROWS) * (rng.random(ROWS) < 0.6),
        "M": rng.integers(1, 21, ROWS).astype(float),
    }
    yield "cache", {}, inputs


def _reaches(rng: Generator) -> Iterator[Parts]:
    for bounces in (3, 6):
        inputs = {
            "end": rng.integers(2, bounces + 3, ROWS),
            "v": rng.integers(1, bounces + 1, ROWS),
            "value": 10.0 ** rng.normal(0, 0.7, (ROWS, 3)),
            "jacobian": spread(rng, -1, 1, ROWS),
        }
        yield f"reach-{bounces}", {"bounces": bounces}, inputs
