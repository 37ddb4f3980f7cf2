"""Replay of the passes of the hash grid: cells in exact words and bounded numbers.

Nothing here calls what renders.  Where atomics decide, what is compared is what any
order of them leaves: who shares a slot, which places are given, not in which order.
"""

from collections.abc import Callable, Mapping
from math import log

import numpy as np
from numpy.typing import NDArray

from restir_gi.hashgrid.oracle.contract import COLUMNS
from restir_gi.hashgrid.oracle.rules import (
    CONTRACT_GRID,
    SLOTS,
    CellRules,
    HashRules,
    TableRules,
    gridded,
    whole_setting,
)
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.further.numbers import setting
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    between,
    exactly,
    in_rows,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import square_root

Words = NDArray[np.uint64]
NOBODY = -1
MOST_BUCKETS = 2**16
"""That anybody asks for here."""

# ---------------------------------------------------------------- the cell of a point


TANGENT = 4.0
"""Roundings of a tangent: a few units in the last place."""


def judge_cell_base(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_base``."""
    rounding, part = rounding_of(precision), gridded(rules).cell
    fov_y, w, h = (
        exact(case.inputs[n], rounding) for n in ("fov_y", "width", "height")
    )
    if part.quotients == "turned":
        w, h = h, w
    one = constant(1.0, fov_y)
    quotients = one / h, h / (w * w)
    larger = np.maximum if part.quotients != "smaller" else np.minimum
    a, b = (q.value for q in quotients)
    error = np.maximum(*(q.error for q in quotients))
    of_pixels = Bounded(larger(a, b), error, rounding) * constant(16.0, one)
    angle = fov_y * of_pixels
    if part.fov_scale != 1:
        angle = angle * constant(part.fov_scale, angle)
    bound = constant(part.widest, one)
    least = np.minimum(angle.value, bound.value)
    error = np.where(angle.value < bound.value - angle.error, angle.error, bound.error)
    base = np.tan(least)
    # Its slope is 1 + base², and grows no more than twice within the error.
    error = 2 * (1 + base * base) * error + TANGENT * rounding.unit * np.abs(base)
    return Judgement(
        (Compared("base", outputs["base"], base, error),),
        {"angle of a cell": angle.value},
    )


LOGARITHM = 2.0
"""Roundings of a binary logarithm, in units of the larger of 1 and the result: shaders
have it to 3 units in the last place of the result, and to 2⁻²¹ near 0."""


def judge_cell_level(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_level``."""
    rounding, part = rounding_of(precision), gridded(rules).cell
    if part.levels == "own":
        return _own_levels(case, outputs["level"].astype(np.int64))
    wanted = _wanted_level(case, part, rounding)
    with np.errstate(divide="ignore"):
        log2 = np.log2(wanted.value)
        own = LOGARITHM * rounding.unit * np.maximum(np.abs(log2), 1.0)
        error = np.divide(
            wanted.error,
            wanted.value * log(2),
            out=np.zeros_like(log2),
            where=wanted.value > 0,
        )
    error = error + np.where(np.isfinite(log2), own, 0.0)
    whole = {"down": np.floor, "up": np.ceil, "nearest": np.rint}[part.rounding]
    least, own_level, most = (
        _from_0(whole(log2 + k * error), part.least_level) for k in (-1, 0, 1)
    )
    found = outputs["level"]
    return Judgement(
        (between("level", found, least, most),),
        {"1000 · distance · base": wanted.value, "log2 of it": log2},
        _open(found, own_level, least, most, 2 * error),
        case.random,
    )


NEARER = 0.99
"""Share of a distance that no rounding takes for all of it."""


def _own_levels(case: Case, found: Indices) -> Judgement:
    """Levels of a rule that only the backend knows.

    The same point has the same level; and who goes straight away from the eye of the
    grid, along an axis, comes to no smaller cells.
    """
    position = case.inputs["position"].astype(float)
    _, point = np.unique(position, axis=0, return_inverse=True)
    everyone = np.ones(case.rows, bool)
    alike = found[_first_row(point.ravel(), everyone)]
    end = "_before" if case.settings["when"] == "look-up" else ""
    eye = [float(case.settings[f"eye{end}_{axis}"]) for axis in "xyz"]
    aside = position - eye
    least = np.full(case.rows, np.iinfo(np.int64).min)
    on_axis = (aside != 0).sum(axis=1) == 1
    for axis in range(3):
        for sign in (1, -1):
            ray = np.flatnonzero(on_axis & (sign * aside[:, axis] > 0))
            ray = ray[np.argsort(abs(aside[ray, axis]), kind="stable")]
            t = abs(aside[ray, axis])
            largest = np.maximum.accumulate(np.append(least[0], found[ray]))
            least[ray] = largest[np.searchsorted(t, NEARER * t)]
    return Judgement(
        (
            exactly("level of the same point", found, alike),
            exactly("smaller than nearer to the eye", found < least, 0 * everyone),
        )
    )


def _wanted_level(case: Case, part: CellRules, rounding: Rounding) -> Bounded:
    """Distance, in edges of the smallest cells that appear under the base, (N,)."""
    before = case.settings["when"] == "look-up" and not part.eye_of_now
    prefix, base = ("eye_before", "base_before") if before else ("eye", "base")
    position = exact(case.inputs["position"], rounding)
    total: Bounded | None = None
    for axis in range(3):
        eye = setting(case.settings[f"{prefix}_{'xyz'[axis]}"], rounding)
        along = position[:, axis] if part.eye_forgotten else position[:, axis] - eye
        total = along * along if total is None else total + along * along
    assert total is not None
    scale = constant(1 / part.smallest, total)
    return square_root(total) * setting(case.settings[base], rounding) * scale


def _from_0(level: Scalars, least: bool) -> Scalars:
    bounded = np.where(np.isfinite(level), level, 0.0)
    return np.maximum(bounded, 0.0) if least else bounded


def _open(
    found: Indices, own: Scalars, least: Scalars, most: Scalars, share: Scalars
) -> Decisions:
    """Whole numbers that rounding leaves open: how many differ, and are open."""
    inside = (found >= least) & (found <= most)
    differing = int(((found != own) & inside).sum())
    none = np.zeros(len(found), bool)
    mean = float(np.minimum(share, 1.0).sum())
    return Decisions(none, differing, mean, "which side of a border it is")


FRAME = 32.0
"""Roundings of a tangent: of a vector product with an axis that is up to 0.999 along
the normal some 22 are left."""


def judge_cell_jitter(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_jitter``, in whatever frame a backend has about its normals.

    Inner products do not know the frame: of a row with its normal, with itself, and
    with the first two rows of the same normal.
    """
    rounding, part = rounding_of(precision), gridded(rules).cell
    position = case.inputs["position"].astype(float)
    moved = outputs["moved"].astype(float) - position
    a, b = _sides(case, part, rounding)
    reach = part.reach * _edges(case)
    frame = FRAME * reach[:, None]
    room = rounding.unit * (2 * (np.abs(position) + reach[:, None]) + frame)
    loose = np.sqrt((room * room).sum(axis=1))
    if part.plane == "ground":
        wanted = np.stack([a.value, np.zeros(case.rows), b.value], axis=1)
        return Judgement((Compared("moved", moved, wanted, room),))
    normal = case.inputs["normal"].astype(float)
    compared = [
        Compared(
            "along the normal",
            (moved * normal).sum(axis=1),
            np.zeros(case.rows),
            (np.abs(normal) * room).sum(axis=1) + FRAME * rounding.unit * reach,
        )
    ]
    names = "length²", "with the first of its normal", "with the second of its normal"
    for name, base in zip(names, _bases(normal), strict=True):
        product = a * a[base] + b * b[base]
        size, other = (
            np.hypot(s.value, t.value) for s, t in ((a, b), (a[base], b[base]))
        )
        allowed = size * loose[base] + other * loose + loose * loose[base]
        compared.append(
            Compared(
                name,
                (moved * moved[base]).sum(axis=1),
                product.value,
                product.error + 2 * allowed,
            )
        )
    return Judgement(tuple(compared), {"reach": reach})


def _sides(case: Case, part: CellRules, rounding: Rounding) -> tuple[Bounded, Bounded]:
    """How far points move along their tangents, (N,) each."""
    u = exact(case.inputs["u"], rounding)
    edge = exact(_edges(case), rounding)
    reach = edge * constant(part.reach, edge)
    numbers = [u[:, 0], u[:, 0] if part.one_number else u[:, 1]]
    one, two = constant(1.0, edge), constant(2.0, edge)
    if not part.one_sided:
        numbers = [two * each - one for each in numbers]
    return numbers[0] * reach, numbers[1] * reach


def _edges(case: Case) -> Scalars:
    """Edges of cells, (N,), m; as given, or a thousandth of a power of two."""
    if case.settings.get("size") == "edge":
        return case.inputs["edge"].astype(float)
    return np.ldexp(1e-3, case.inputs["level"].astype(np.int32))


def _bases(normal: Vec3s) -> tuple[Indices, Indices, Indices]:
    """The row itself, and the first and second row of the same normal, (N,) each."""
    # By their bits: a frame may turn where a component is −0.
    bits = np.ascontiguousarray(normal).view(np.int64)
    _, first, group = np.unique(bits, axis=0, return_index=True, return_inverse=True)
    group = group.ravel()
    row, second = np.arange(len(normal)), first.copy()
    later = row[row != first[group]][::-1]
    second[group[later]] = later
    return row, first[group], second[group]


def judge_cell_key(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_key``."""
    rounding, part = rounding_of(precision), gridded(rules).cell
    edge = _edge_of_key(case, part, rounding)
    whole = {"floor": np.floor, "trunc": np.trunc, "round": np.rint}[part.cut]
    compared, differing, left_open = [], 0, 0.0
    for axis, name in enumerate("xyz"):
        q = exact(case.inputs["position"][:, axis], rounding) / edge
        least, own, most = (whole(q.value + k * q.error) for k in (-1, 0, 1))
        found = outputs[name]
        compared.append(between(name, found, least, most))
        told = _open(found, own, least, most, 2 * q.error)
        differing, left_open = differing + told.differing, left_open + told.expected
    digits = _facing(case, outputs["facing"], part, rounding)
    none = np.zeros(case.rows, bool)
    decisions = Decisions(none, differing, left_open, "which side of a border it is")
    return Judgement((*compared, digits), {"edge": edge.value}, decisions, case.random)


def _edge_of_key(case: Case, part: CellRules, rounding: Rounding) -> Bounded:
    """Edges of cells, (N,), m."""
    if case.settings.get("size") == "edge":
        return exact(case.inputs["edge"], rounding)
    level = case.inputs["level"].astype(np.int32)
    factor = np.ldexp(1.0, level) if part.edge_doubles else np.maximum(level, 1) * 1.0
    edge = exact(factor, rounding)
    return edge * constant(part.smallest, edge)


def _facing(
    case: Case, found: Indices, part: CellRules, rounding: Rounding
) -> Compared:
    """Part of the normal's sphere, digit by digit."""
    parts = whole_setting(case, "facings", 16) if part.parts else 1
    normal = exact(case.inputs["normal"], rounding)
    half = constant(parts / 2, normal)
    t = (normal + constant(1.0, normal)) * half
    least, most = (
        np.clip(np.floor(t.value + k * t.error), 0, parts - 1) for k in (-1, 1)
    )
    number = found.astype(np.int64)
    digits = [number % parts, number // parts % parts, number // parts**2]
    if part.parts_turned:
        digits = digits[::-1]
        # The digit that is not cut off stands above.
        digits = [number // parts**2, number // parts % parts, number % parts]
    return between("facing", np.stack(digits, axis=1), least, most)


# ---------------------------------------------------------------- its hashes

LOWER = np.uint64(0xFFFFFFFF)


def _times(x: Words, factor: int) -> Words:
    return (x * np.uint64(factor)) & LOWER


def _pcg(x: Words) -> Words:
    s = (_times(x, 747796405) + np.uint64(2891336453)) & LOWER
    turn = (s >> np.uint64(28)) + np.uint64(4)
    w = _times((s >> turn) ^ s, 277803737)
    return (w >> np.uint64(22)) ^ w


def _xxhash(x: Words) -> Words:
    s = (x + np.uint64(374761393)) & LOWER
    s = ((s << np.uint64(17)) | (s >> np.uint64(15))) & LOWER
    s = _times(s, 668265263)
    s = _times(s ^ (s >> np.uint64(15)), 2246822519)
    s = _times(s ^ (s >> np.uint64(13)), 3266489917)
    return s ^ (s >> np.uint64(16))


def judge_cell_hash(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_hash``: words, to the last bit."""
    part = gridded(rules).words
    hashes = (_xxhash, _pcg) if part.exchanged else (_pcg, _xxhash)
    bucket = _nested(case, hashes[0], part)
    checksum = bucket if part.one_hash else _nested(case, hashes[1], part)
    if part.lifted == "least":
        checksum = np.maximum(checksum, np.uint64(1))
    if part.own:
        contracts = (outputs["bucket_hash"] == bucket) & (
            outputs["checksum"] == checksum
        )
        return _own_words(case, outputs, contracts)
    return Judgement(
        (
            exactly("bucket_hash", outputs["bucket_hash"], bucket),
            exactly("checksum", outputs["checksum"], checksum),
        )
    )


def _own_words(case: Case, outputs: Buffers, contracts: Masks) -> Judgement:
    """Words of a hash that only the backend knows: they tell the cells apart.

    Of 64 bits no right hash has two of a few hundred cells alike; of 48, as with a
    checksum of 16, once in 10⁹ runs.  A hash that is the contract's in some cells is
    that with a mistake in the others, and no hash of another kind.
    """
    bucket, checksum = (
        outputs[n].astype(np.int64) for n in ("bucket_hash", "checksum")
    )
    fields = np.stack([case.inputs[n] for n in CONTRACT_GRID.words.order], axis=1)
    _, cell = np.unique(fields, axis=0, return_inverse=True)
    everyone, none = np.ones(case.rows, bool), np.zeros(case.rows)
    cell = cell.ravel()
    first = _first_row(cell, everyone)
    _, word = np.unique(
        np.stack([bucket, checksum], axis=1), axis=0, return_inverse=True
    )
    shared = cell != cell[_first_row(word.ravel(), everyone)]
    return Judgement(
        (
            exactly("bucket_hash of the same cell", bucket, bucket[first]),
            exactly("checksum of the same cell", checksum, checksum[first]),
            exactly("words of another cell", shared, none),
            exactly("checksums of 0", checksum == 0, none),
            exactly("checksums that are the hash", checksum == bucket, none),
            exactly("words of the contract's hash", contracts, none),
        )
    )


def _nested(case: Case, mix: Callable[[Words], Words], part: HashRules) -> Words:
    found = np.zeros(case.rows, np.uint64)
    for name in part.order:
        number = case.inputs[name].astype(np.int64)
        if part.saturates and name in "xyz":
            number = np.maximum(number, 0)
        word = (number & 0xFFFFFFFF).astype(np.uint64)
        found = mix((word + found) & LOWER) if part.nested else found ^ mix(word)
    return found


# ---------------------------------------------------------------- Algorithm 2


def judge_cell_insert(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_insert``: what a table holds, whoever came first.

    A row is wrong whose vertex is not with its cell, or with another, or beyond a slot
    that is free, or lost where there was room.
    """
    part, buckets = gridded(rules).table, whole_setting(case, "buckets", MOST_BUCKETS)
    slot = outputs["slot"].astype(np.int64)
    bucket = _buckets(case, buckets, part)
    active = (case.inputs["active"] == 1) | part.inactive_too
    cell = _cells_of(case, bucket, active, part)
    there = active & (slot != NOBODY)
    place, of_slot = slot % SLOTS, slot // SLOTS
    inside = (slot >= 0) & (slot < buckets * SLOTS)
    known = there & inside
    # Slots in use, and cells that want them, bucket by bucket.
    used = np.zeros((buckets, SLOTS), bool)
    used[of_slot[known], place[known]] = True
    full = used.sum(axis=1)
    wanted = np.bincount(bucket[_firsts(cell, active)], minlength=buckets)
    everyone = np.zeros(case.rows)
    compared = [
        exactly(
            "of the vertices that are not active",
            np.where(active, -1, slot),
            -1 + everyone,
        ),
        in_rows(there, exactly("below the last slot", known, np.ones(case.rows))),
        in_rows(known, _in_its_bucket(case, of_slot, bucket, full, part)),
        in_rows(
            known,
            between(
                "without a hole",
                place,
                everyone,
                full[np.where(known, of_slot, 0)] - 1.0,
            ),
        ),
        in_rows(known, _alone(cell, slot, known, place, part)),
        in_rows(active, _together(cell, slot, active, part)),
        in_rows(active, _lost(slot, bucket, full, wanted, part)),
    ]
    return Judgement(tuple(compared), {"cells of the bucket": wanted[bucket]})


def _buckets(case: Case, buckets: int, part: TableRules) -> Indices:
    """Bucket of each row, (N,)."""
    hash_ = case.inputs["bucket_hash"].astype(np.int64)
    upper = part.bucket_of == "upper bits"
    found: Indices = (hash_ * buckets) >> 32 if upper else hash_ % buckets
    return found


def _cells_of(case: Case, bucket: Indices, active: Masks, part: TableRules) -> Indices:
    """Who is of one cell, (N,): numbers from 0 on; meaningless where not active."""
    if part.told_apart == "each vertex":
        return np.arange(case.rows)
    check = case.inputs["checksum"].astype(np.uint64)
    both = bucket.astype(np.uint64) << np.uint64(32) | check
    if part.told_apart == "never":
        both = bucket.astype(np.uint64)
    _, cell = np.unique(both, return_inverse=True)
    found: Indices = cell.ravel()
    return found


def _firsts(group: Indices, of: Masks) -> Indices:
    """First row of each group, among some rows."""
    rows = np.flatnonzero(of)
    _, first = np.unique(group[rows], return_index=True)
    found: Indices = rows[first]
    return found


def _first_row(group: Indices, of: Masks) -> Indices:
    """First row of a row's group, (N,), among some rows; 0 elsewhere."""
    first = np.zeros(group.max(initial=0) + 1, np.int64)
    rows = np.flatnonzero(of)[::-1]
    first[group[rows]] = rows
    return np.where(of, first[np.where(of, group, 0)], 0)


def _in_its_bucket(
    case: Case, of_slot: Indices, bucket: Indices, full: Indices, part: TableRules
) -> Compared:
    """Whether the bucket is that of the hash, or one that full ones lead to."""
    if part.overflow != "next bucket":
        return exactly("bucket", of_slot, bucket)
    buckets = len(full)
    gaps = np.concatenate([[0], np.cumsum(np.tile(full < SLOTS, 2))])
    steps = (of_slot - bucket) % buckets
    between_them = gaps[bucket + steps] - gaps[bucket]
    return exactly("free slots on the way", between_them, np.zeros(case.rows))


def _alone(
    cell: Indices, slot: Indices, known: Masks, place: Indices, part: TableRules
) -> Compared:
    """Whether the cell is that of the first vertex with its slot."""
    other = cell[_first_row(np.where(known, slot, 0), known)]
    found = exactly("cell of the slot", cell, other)
    if part.overflow == "last slot":
        return in_rows(place < SLOTS - 1, found)
    return found


def _together(
    cell: Indices, slot: Indices, active: Masks, part: TableRules
) -> Compared:
    """Whether the slot is that of the other vertices of the cell."""
    if part.winners_alone:
        stored = active & (slot != NOBODY)
        count = np.bincount(cell[stored], minlength=cell.max(initial=0) + 1)
        none = np.zeros(len(slot))
        return between(
            "vertices with the slot of the cell", count[cell], none, none + 1.0
        )
    return exactly("slot of the cell", slot, slot[_first_row(cell, active)])


def _lost(
    slot: Indices, bucket: Indices, full: Indices, wanted: Indices, part: TableRules
) -> Compared:
    """Whether a vertex is lost where its bucket is not full of other cells."""
    lost = slot == NOBODY
    room = min(part.probes, SLOTS)
    may = full[bucket] >= room
    if part.overflow == "last slot":
        may = np.zeros(len(slot), bool)
    elif part.overflow == "next bucket":
        # However many buckets are tried: the next one is.
        crowded = full >= SLOTS
        may = (crowded & np.roll(crowded, -1))[bucket]
    elif part.winners_alone:
        stored = np.bincount(bucket[~lost], minlength=len(full))
        may = stored[bucket] >= np.minimum(wanted, room)[bucket]
    # Whoever tries fewer slots takes no more.
    too_many = full[bucket] > room
    return exactly(
        "lost though there is room", lost & ~may | too_many, np.zeros(len(slot))
    )


def judge_cell_count(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_count``: places are those of any order."""
    part, slot = gridded(rules).table, case.inputs["slot"].astype(np.int64)
    has = slot != NOBODY
    left = np.zeros(case.rows) if part.cleared else case.inputs["left"].astype(float)
    counter = left + np.bincount(slot[has], minlength=case.rows)
    place = outputs["place"].astype(np.int64)
    wanted = np.full(case.rows, -1.0)
    order = np.lexsort((place, slot))
    order = order[has[order]]
    begin = np.concatenate(
        [[0], np.cumsum(np.bincount(slot[has], minlength=case.rows))]
    )
    rank = np.arange(len(order)) - begin[slot[order]]
    wanted[order] = rank + left[slot[order]] + part.first_place
    return Judgement(
        (
            exactly("counter", outputs["counter"], counter),
            exactly("place", place, wanted),
        )
    )


def judge_cell_scan(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_scan``."""
    part, counter = gridded(rules).table, case.inputs["counter"].astype(np.int64)
    start = np.cumsum(counter) - (0 if part.inclusive else counter)
    if part.restarts:
        block = np.arange(case.rows) // part.restarts * part.restarts
        start = start - (np.cumsum(counter) - counter)[block]
    return Judgement((exactly("start", outputs["start"], start),))


def judge_cell_scatter(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_scatter``; what lies beyond the last vertex is left open."""
    part = gridded(rules).table
    slot, place, start = (
        case.inputs[n].astype(np.int64) for n in ("slot", "place", "start")
    )
    vertex = np.flatnonzero(slot != NOBODY)
    number = {
        "rows": vertex,
        "appended": np.arange(len(vertex)),
        "slots": slot[vertex],
    }[part.numbers]
    storage, filled = np.zeros(case.rows), np.zeros(case.rows, bool)
    at = start[np.minimum(slot[vertex], case.rows - 1)] + place[vertex]
    inside = (at >= 0) & (at < case.rows)
    storage[at[inside]], filled[at[inside]] = number[inside], True
    return Judgement(
        (in_rows(filled, exactly("storage", outputs["storage"], storage)),)
    )


# ---------------------------------------------------------------- the look-up


def judge_cell_find(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_find``."""
    part, buckets = gridded(rules).table, whole_setting(case, "buckets", MOST_BUCKETS)
    table = case.inputs["table"].astype(np.int64)[: buckets * SLOTS]
    beyond = np.zeros(buckets * SLOTS - len(table), np.int64)
    held = np.concatenate([table, beyond]).reshape(buckets, SLOTS)
    checksum = case.inputs["checksum"].astype(np.int64)
    bucket = _buckets(case, buckets, part)
    slot = np.full(case.rows, NOBODY)
    for step in range(2 if part.looks_further else 1):
        here = (bucket + step) % buckets
        row = held[here][:, : part.looked_at]
        alike = row == checksum[:, None] if part.checksum_compared else row > 0
        free = row == 0
        found = alike.any(axis=1)
        at = np.where(found, alike.argmax(axis=1), NOBODY)
        if part.gives_free_slot:
            at = np.where(~found & free.any(axis=1), free.argmax(axis=1), at)
        # A bucket that is not full ends the search.
        going = step == 0 or (held[bucket] > 0).all(axis=1)
        slot = np.where(
            (slot == NOBODY) & (at != NOBODY) & going, here * SLOTS + at, slot
        )
    return Judgement((exactly("slot", outputs["slot"], slot),))


ALARM = 1e-12
"""Probability that a right walk, by whatever random numbers, is held for uneven."""


def judge_cell_visit(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_visit``: any walk that takes no vertex twice, and is even."""
    part, most = gridded(rules).table, whole_setting(case, "most", COLUMNS)
    slot = case.inputs["slot"].astype(np.int64)
    has = slot != NOBODY
    cell = np.where(has, np.clip(slot, 0, case.rows - 1), 0)
    first = case.inputs["start"].astype(np.int64)[cell]
    n = np.where(has, case.inputs["counter"].astype(np.int64)[cell], 0)
    found = outputs["vertex"].astype(np.int64)
    if part.walk != "any":
        rounding = rounding_of(precision)
        return _one_walk(case, found, first, n, part.walk, rounding)
    storage = case.inputs["storage"].astype(np.int64)
    where = np.full(int(storage.max(initial=0)) + 1, -1)
    where[storage] = np.arange(case.rows)
    stored = (found >= 0) & (found < len(where))
    place = np.where(stored, where[np.where(stored, found, 0)], -1) - first[:, None]
    taken = np.minimum(n, most)
    column = np.arange(COLUMNS)
    asked = column < taken[:, None]
    inside = (place >= 0) & (place < n[:, None])
    ordered = np.sort(np.where(asked, place, -1 - column), axis=1)
    twice = (np.diff(ordered, axis=1) == 0).any(axis=1)
    none = np.zeros(found.shape)
    return Judgement(
        (
            exactly("vertices of the cell", np.where(asked, inside, 1), none + 1),
            exactly("after them", np.where(asked, -1, found), none - 1),
            exactly("vertices that are taken twice", twice, none[:, 0]),
            _even(case, place, asked & inside, n, taken, cell),
        ),
        {"n": n},
    )


def _even(
    case: Case, place: Indices, seen: Masks, n: Indices, taken: Indices, cell: Indices
) -> Compared:
    """How often the rarest and the commonest vertex of a cell are found, (N, 2)."""
    rows = np.bincount(cell, n > 0, minlength=case.rows)
    begin = np.concatenate([[0], np.cumsum(case.inputs["counter"].astype(np.int64))])
    total = int(begin[-1])
    at = (begin[cell][:, None] + place)[seen]
    count = np.bincount(at, minlength=max(total, 1))[: max(total, 1)].astype(float)
    lowest, highest = np.zeros(case.rows), np.zeros(case.rows)
    filled = np.flatnonzero(case.inputs["counter"] > 0)
    if len(filled):
        lowest[filled] = np.minimum.reduceat(count, begin[filled])
        highest[filled] = np.maximum.reduceat(count, begin[filled])
    share = np.divide(taken, n, out=np.zeros(case.rows), where=n > 0)
    mean = rows[cell] * share
    # Of numbers that cover [0, 1) evenly each place is hit once more or less; those of
    # a generator that begins with u deviate by no more than Hoeffding's bound.
    random = np.sqrt(rows[cell] / 2 * log(2 * max(total, 1) / ALARM))
    allowed = np.where(share < 1, 2 * taken + random, 0.0)
    both = np.stack([lowest[cell], highest[cell]], axis=1)
    both = np.where(n[:, None] > 0, both, 0.0)
    return Compared(
        "how often the rarest and the commonest vertex of the cell are found",
        both,
        np.stack([mean, mean], axis=1),
        np.stack([allowed, allowed], axis=1),
    )


def _one_walk(
    case: Case,
    found: Indices,
    first: Indices,
    n: Indices,
    walk: str,
    rounding: Rounding,
) -> Judgement:
    """A known walk, which is not right, from either place that rounding leaves open."""
    most, k = whole_setting(case, "most", COLUMNS), np.arange(COLUMNS)
    storage = case.inputs["storage"].astype(np.int64)
    u = case.inputs["u"].astype(float) * n
    expected = np.full(found.shape, NOBODY)
    for nudge in (1, -1, 0):
        offset = np.floor(u + nudge * rounding.unit * u).astype(np.int64)
        offset = np.clip(offset, 0, np.maximum(n - 1, 0))
        if walk == "from the first":
            offset = offset * 0
        stride = k * n[:, None] // most
        place = offset[:, None] + stride
        if walk != "beyond":
            place = place % np.maximum(n, 1)[:, None]
        few = (n <= most)[:, None] & (walk != "twice")
        place = np.where(few, k, place)
        begin = first + n if walk == "next cell" else first
        taken = (k < most) & (n > 0)[:, None]
        if walk != "twice":
            taken &= k < n[:, None]
        at = np.clip(begin[:, None] + place, 0, case.rows - 1)
        vertices = np.where(taken, storage[at], NOBODY)
        same = (vertices == found).all(axis=1)
        expected = np.where(same[:, None] | (nudge == 1), vertices, expected)
    return Judgement((exactly("vertex", found, expected),))


Judged = Callable[[Case, Buffers, Rules, Precision], Judgement]

GRID_JUDGES: Mapping[str, Judged] = {
    "cell_base": judge_cell_base,
    "cell_level": judge_cell_level,
    "cell_jitter": judge_cell_jitter,
    "cell_key": judge_cell_key,
    "cell_hash": judge_cell_hash,
    "cell_insert": judge_cell_insert,
    "cell_count": judge_cell_count,
    "cell_scan": judge_cell_scan,
    "cell_scatter": judge_cell_scatter,
    "cell_find": judge_cell_find,
    "cell_visit": judge_cell_visit,
}
