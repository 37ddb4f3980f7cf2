"""Passes of the hash grid by hand, row by row, as a renderer might write them.

In plain numbers of the backend's type, inserted in another order than ours, in another
tangent frame; and each with the mistakes that it may have.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from restir_gi.reference.oracle.contract.fields import dtype_of
from tests.contracts.test_oracle_reuse import row_by_row

WORD = 2**32
REAL = {"float32": np.float32, "float64": np.float64}


@dataclass(frozen=True)
class HashGridByHand:
    """A backend of the hash grid.

    ``mistake`` is the name of a hypothesis, or nothing.
    """

    precision: str
    mistake: str = ""

    def __call__(self, pass_name, **given):
        """Outputs of a pass."""
        real = REAL[self.precision]
        with np.errstate(all="ignore"):
            given |= in_halves(self.mistake, given, real)
            found = globals()[pass_name](real, self.mistake, **given)
            found |= in_halves(self.mistake, found, real)
        kinds = KINDS[pass_name]
        return {
            name: np.ascontiguousarray(array, dtype_of(kinds[name], self.precision))
            for name, array in found.items()
        }


def answer_by_hand(mistake):
    """What a plant answers in single precision."""
    return lambda case: HashGridByHand("float32", mistake)(
        case.pass_name, **case.inputs, **case.settings
    )


def in_halves(mistake, buffers, real):
    """W and M as they come out of 16 bits, if that is what a backend stores them in."""
    _, stored, how = mistake.rpartition("-in-halves")
    if not stored:
        return {}
    held = {}
    for name in {"W", "M"} & {*buffers}:
        wide = np.asarray(buffers[name], real)
        half = (wide if how == "-infinite" else np.minimum(wide, 65504)).astype("f2")
        if how == "-cut":
            half = np.where(half > wide, np.nextafter(half, np.float16(0)), half)
        held[name] = half.astype(real)
    return held


KINDS = {
    "cell_base": {"base": "real"},
    "cell_level": {"level": "index"},
    "cell_jitter": {"moved": "real"},
    "cell_key": dict.fromkeys(("x", "y", "z", "facing"), "index"),
    "cell_hash": dict.fromkeys(("bucket_hash", "checksum"), "bits"),
    "cell_insert": {"slot": "index"},
    "cell_count": {"counter": "index", "place": "index"},
    "cell_scan": {"start": "index"},
    "cell_scatter": {"storage": "index"},
    "cell_find": {"slot": "index"},
    "cell_visit": {"vertex": "index"},
    "cell_similar": {"similar": "bits"},
    "light_target": {"value": "real"},
    "light_candidates": {"slot": "index", "W": "real", "M": "real"},
    "light_reuse": {"slot": "index", "p_hat": "real", "W": "real", "M": "real"},
    "bounce_reservoir": {"longer": "bits", "value": "real", "W": "real", "M": "real"},
    "path_cache": {"stored": "bits", "W": "real", "M": "real"},
    "suffix_reach": {"value": "real", "jacobian": "real"},
}


def dots(a, b):
    """Inner products, summed backwards."""
    return a[..., 2] * b[..., 2] + a[..., 1] * b[..., 1] + a[..., 0] * b[..., 0]


# ---------------------------------------------------------------- the cell of a point


def cell_base(real, mistake, fov_y, width, height):
    """By products, and a bound on the tangent."""
    w, h = width.astype(real), height.astype(real)
    if mistake == "cell-base-of-the-other-side":
        w, h = h, w
    most = np.minimum if mistake == "cell-base-of-the-smaller-quotient" else np.maximum
    fov_y = fov_y * {
        "cell-base-in-degrees": real(180 / pi),
        "cell-base-of-half-the-field": real(0.5),
    }.get(mistake, real(1))
    angle = fov_y * (16 * most(1 / h, h / w / w))
    if mistake == "cell-base-not-bounded":
        return {"base": np.tan(angle)}
    return {"base": np.where(angle < pi / 4, np.tan(angle), 1)}


def cell_level(real, mistake, position, when, **s):
    """By a logarithm."""
    now = when == "insertion" or mistake == "cell-level-by-this-eye"
    end = "" if now else "_before"
    eye = np.array([s[f"eye{end}_{axis}"] for axis in "xyz"], real)
    if mistake == "cell-level-from-the-origin":
        eye = eye * 0
    offset = position - eye
    distance = np.sqrt(dots(offset, offset))
    if mistake == "cell-level-of-another-rule":
        # Of the largest component, in cells that grow by 1.5.
        far = abs(offset).max(axis=1) * real(s[f"base{end}"]) * 200
        return {"level": np.floor(np.log(np.maximum(far, 1)) / np.log(real(1.5)))}
    smallest = real(1 if mistake == "cell-level-in-metres" else 1e-3)
    exact = np.log2(distance * (real(s[f"base{end}"]) / smallest))
    whole = {
        "cell-level-rounded-up": np.ceil,
        "cell-level-to-the-nearest": np.rint,
    }.get(mistake, np.floor)
    level = np.where(distance > 0, whole(exact), 0)
    return {"level": level if mistake == "cell-level-below-0" else np.maximum(level, 0)}


def cell_jitter(
    real, mistake, position, normal, u, level=None, edge=None, size="level"
):
    """Tangents by vector products with an axis that is far enough away."""
    axis = np.where((abs(normal[:, :1]) < real(0.9)), [1, 0, 0], [0, 1, 0])
    t = np.cross(axis.astype(real), normal)
    t = t / np.sqrt(dots(t, t))[:, None]
    b = np.cross(normal, t)
    if mistake == "cell-jitter-in-the-ground-plane":
        t, b = np.eye(3, dtype=real)[[0, 2]]
    reach = {
        "cell-jitter-without-root-2": 1.0,
        "cell-jitter-by-half": sqrt(0.5),
    }.get(mistake, sqrt(2))
    r = (np.ldexp(real(1e-3), level) if edge is None else edge) * real(reach)
    if mistake == "cell-jitter-along-a-diagonal":
        u = u[:, [0, 0]]
    if mistake != "cell-jitter-one-sided":
        u = u * 2 - 1
    aside = (u[:, 0] * r)[:, None] * t + (u[:, 1] * r)[:, None] * b
    return {"moved": position + aside}


def cell_key(
    real, mistake, position, normal, facings, level=None, edge=None, size="level"
):
    """By a reciprocal of the edge."""
    if edge is None:
        edge = np.ldexp(real(1e-3), level)
        if mistake == "cell-key-in-metres":
            edge = np.ldexp(real(1), level)
        if mistake == "cell-key-edge-grows-evenly":
            edge = real(1e-3) * np.maximum(level, 1).astype(real)
    scaled = position * (1 / edge)[:, None]
    whole = {"cell-key-truncated": np.trunc, "cell-key-rounded": np.rint}
    x, y, z = whole.get(mistake, np.floor)(scaled).T
    parts = 1 if mistake == "cell-key-without-normal" else facings
    digits = np.floor(normal * real(parts / 2) + real(parts / 2)).clip(0, parts - 1)
    if mistake == "cell-key-normal-turned":
        digits = digits[:, ::-1]
    return {"x": x, "y": y, "z": z, "facing": digits @ [1, parts, parts**2]}


# ---------------------------------------------------------------- its hashes


def pcg(v):
    """One word."""
    s = (v * 747796405 + 2891336453) % WORD
    w = ((s >> ((s >> 28) + 4)) ^ s) * 277803737 % WORD
    return w >> 22 ^ w


def xxhash(v):
    """One word."""
    s = (v + 374761393) % WORD
    s = (s << 17 | s >> 15) % WORD * 668265263 % WORD
    s = (s ^ s >> 15) * 2246822519 % WORD
    s = (s ^ s >> 13) * 3266489917 % WORD
    return s ^ s >> 16


ORDERS = {
    "cell-hash-z-y-x": ("facing", "x", "y", "z", "level"),
    "cell-hash-without-level": ("facing", "z", "y", "x"),
    "cell-hash-without-facing": ("z", "y", "x", "level"),
}


def by_fnv(**fields):
    """FNV-1a of the bytes of a cell, with two seeds."""
    names = ("x", "y", "z", "level", "facing")
    rows = np.stack([fields[n].astype("<i4") for n in names], axis=1)
    found = []
    for seed in (2166136261, 40389):
        words = np.full(len(rows), seed, np.uint64)
        for byte in rows.view(np.uint8).T:
            words = (words ^ byte) * np.uint64(16777619) & np.uint64(WORD - 1)
        found.append(words.astype(np.uint32))
    return {"bucket_hash": found[0], "checksum": np.maximum(found[1], 1)}


def cell_hash(real, mistake, **fields):
    """In Python's whole numbers."""
    if mistake == "cell-hash-of-another-kind":
        return by_fnv(**fields)
    names = ORDERS.get(mistake, ("facing", "z", "y", "x", "level"))
    one, two = (xxhash, pcg) if mistake == "cell-hashes-exchanged" else (pcg, xxhash)
    bucket, checksum = [], []
    for row in zip(*(fields[n].tolist() for n in names), strict=True):
        words = [max(v, 0) if mistake.endswith("as-0") else v for v in row]
        found = []
        for mix in (one, two):
            h = 0
            for word in words:
                if mistake == "cell-hash-combined":
                    h ^= mix(word % WORD)
                else:
                    h = mix((word + h) % WORD)
            found.append(h)
        bucket.append(found[0])
        check = found[0] if mistake == "cell-checksum-is-the-hash" else found[1]
        checksum.append(check if mistake == "cell-checksum-may-be-0" else max(check, 1))
    return {
        "bucket_hash": np.array(bucket, np.uint32),
        "checksum": np.array(checksum, np.uint32),
    }


# ---------------------------------------------------------------- Algorithm 2


def bucket_of(mistake, word, buckets):
    """Of one hash."""
    upper = mistake.endswith("-by-upper-bits")
    return int(word) * buckets >> 32 if upper else int(word) % buckets


def cell_insert(real, mistake, bucket_hash, checksum, active, buckets):
    """The last vertex comes first."""
    table, slots = [0] * (buckets * 16), [-1] * len(active)
    tried = {
        "cell-insert-tries-one-slot": 1,
        "cell-insert-leaves-out-the-last-slot": 15,
        "cell-insert-goes-on-in-the-next-bucket": buckets * 16,
    }.get(mistake, 16)
    for v in reversed(range(len(active))):
        if not active[v] and mistake != "cell-insert-of-everybody":
            continue
        first, check = (
            bucket_of(mistake, bucket_hash[v], buckets) * 16,
            int(checksum[v]),
        )
        for k in range(tried):
            at = (first + k) % (buckets * 16)
            if table[at] == 0:
                table[at], slots[v] = check, at
                break
            if mistake == "cell-insert-a-slot-each":
                continue
            same = table[at] == check
            if mistake == "cell-insert-of-winners-alone":
                if same:
                    break
                continue
            if same or mistake == "cell-insert-without-checksum":
                slots[v] = at
                break
        else:
            if mistake == "cell-insert-into-the-last-slot":
                slots[v] = first + 15
    return {"slot": slots}


def cell_count(real, mistake, slot, left):
    """The last vertex comes first."""
    counter = (
        left.tolist() if mistake == "cell-counters-not-cleared" else [0] * len(left)
    )
    place = [-1] * len(slot)
    for v in reversed(range(len(slot))):
        if slot[v] >= 0:
            counter[slot[v]] += 1
            place[v] = counter[slot[v]] - (mistake != "cell-places-from-1")
    return {"counter": counter, "place": place}


def cell_scan(real, mistake, counter):
    """In blocks, and then their sums."""
    rows = int(mistake.rpartition("-")[2]) if "restarts" in mistake else 200
    start, base = [], 0
    for first in range(0, len(counter), rows):
        block = counter[first : first + rows].tolist()
        sums = [sum(block[:k]) for k in range(len(block))]
        if mistake == "cell-scan-inclusive":
            sums = [s + n for s, n in zip(sums, block, strict=True)]
        start += [base + s for s in sums]
        base += 0 if "restarts" in mistake else sum(block)
    return {"start": start}


def cell_scatter(real, mistake, slot, place, start):
    """Beyond the last vertex lies what lay there."""
    storage, appended = [-7] * len(slot), 0
    for v in range(len(slot)):
        if slot[v] >= 0:
            number = {
                "cell-scatter-of-append-numbers": appended,
                "cell-scatter-of-slots": slot[v],
            }.get(mistake, v)
            storage[start[slot[v]] + place[v]] = number
            appended += 1
    return {"storage": storage}


def cell_find(real, mistake, table, bucket_hash, checksum, buckets):
    """A free slot ends the search."""
    last = {
        "cell-find-in-the-first-slot": 1,
        "cell-find-leaves-out-the-last-slot": 15,
        "cell-find-goes-on-in-the-next-bucket": 32,
    }.get(mistake, 16)
    slots = []
    for q in range(len(checksum)):
        first, found = bucket_of(mistake, bucket_hash[q], buckets) * 16, -1
        for k in range(last):
            at = (first + k) % (buckets * 16)
            if table[at] == 0:
                found = at if mistake == "cell-find-ends-in-a-free-slot" else -1
                break
            if table[at] == checksum[q] or mistake == "cell-find-without-checksum":
                found = at
                break
        slots.append(found)
    return {"slot": slots}


def cell_visit(real, mistake, slot, start, counter, storage, u, most):
    """Consecutive vertices, from the place that u says."""
    found = np.full((len(slot), 8), -1)
    for q in range(len(slot)):
        if slot[q] < 0:
            continue
        n, first = int(counter[slot[q]]), int(start[slot[q]])
        offset = min(int(u[q] * n), n - 1)
        if mistake == "cell-visit-from-the-first":
            offset = 0
        if mistake == "cell-visit-of-the-next-cell":
            first += n
        count = most if mistake == "cell-visit-twice" else min(n, most)
        for k in range(count):
            known = mistake.startswith("cell-visit")
            place = offset + (k * n // most if known else k)
            if mistake != "cell-visit-beyond-the-cell":
                place %= n
            if known and mistake != "cell-visit-twice" and n <= most:
                place = k
            found[q, k] = storage[min(first + place, len(storage) - 1)]
    return {"vertex": found}


def cell_similar(real, mistake, normal_a, normal_b):
    """Against the root of the threshold."""
    cosine = dots(normal_a, normal_b)
    if mistake == "cell-similar-on-both-sides":
        cosine = abs(cosine)
    power = {"cell-similar-by-the-cosine": 1, "cell-similar-by-the-square": 2}
    alike = cosine >= real(0.5 ** (1 / power.get(mistake, 4)))
    return {"similar": alike != (mistake == "cell-similar-inverted")}


# ---------------------------------------------------------------- light in cells


def light_target(
    real,
    mistake,
    visible_position,
    visible_normal,
    albedo,
    light_position,
    light_normal,
    radiance,
    area,
):
    """A unit direction, and a density in solid angle."""
    v = light_position - visible_position
    squared = dots(v, v)
    d = np.sqrt(squared)
    wi = v / d[:, None]
    theta, phi = dots(visible_normal, wi), -dots(light_normal, wi)
    lit = (theta > 0) & (phi > 0)
    if mistake == "light-target-lit-from-behind":
        phi, lit = abs(phi), theta > 0
    if mistake == "light-target-below-the-horizon":
        theta, lit = abs(theta), phi > 0
    if mistake == "light-target-without-the-surfaces-cosine":
        theta = theta * 0 + 1
    if mistake == "light-target-without-the-lights-cosine":
        phi = phi * 0 + 1
    squared = {
        "light-target-distance-once": d,
        "light-target-without-distance": d * 0 + 1,
    }.get(mistake, squared)
    size = area * 0 + 1 if mistake == "light-target-without-area" else area
    pdf = squared / (phi * size)
    f = albedo * 0 + 1 if mistake == "light-target-without-albedo" else albedo
    f = f if mistake == "light-target-without-pi" else f * real(1 / pi)
    value = f * radiance * (theta / pdf)[:, None]
    return {"value": np.where(lit[:, None], value, 0)}


def decides(mistake, u, before, w):
    """Whether a candidate is kept."""
    if w <= 0:
        return False
    if before <= 0:
        return True
    if mistake.endswith("kept-by-the-sum-before"):
        return u * before < w
    if mistake.endswith("u-turned"):
        u = 1 - u
    return u * (before + w) < w


def light_candidates(real, mistake, p_hat, choice, density, u):
    """One after the other."""
    rows, count = p_hat.shape
    slots, weights, trusts = [], [], []
    short = mistake.removeprefix("light-candidates-")
    for i in range(rows):
        total, kept, useful = real(0), 0, 0
        for k in range(count):
            pdf = choice[i, k] * density[i, k]
            w = {
                "without-the-choice": p_hat[i, k] / density[i, k],
                "without-the-density": p_hat[i, k] / choice[i, k],
                "without-pdf": p_hat[i, k],
                "times-pdf": p_hat[i, k] * pdf,
            }.get(short, p_hat[i, k] / pdf)
            useful += w > 0
            if decides(mistake, u[i, k], total, w):
                kept = k
            total += w
        M = useful if short == "without-nulls" else count
        target = p_hat[i, 0 if short == "target-of-the-first" else kept]
        divisor = target * (1 if short == "not-divided" else M)
        slots.append(kept)
        weights.append(total / divisor if total > 0 and divisor > 0 else 0)
        trusts.append(1 if short == "count-once" else M)
    return {"slot": slots, "W": weights, "M": trusts}


def light_reuse(real, mistake, mis, cap, **tables):
    """As reuse of paths by hand, with Jacobians of 1."""
    ones = np.ones_like(tables["W"])
    precision = "float32" if real is np.float32 else "float64"
    return row_by_row(precision, mis, 0, cap, jacobian=ones, **tables)


# ---------------------------------------------------------------- suffixes of paths

LUMINANCE = (0.2126, 0.7152, 0.0722)


def bounce_reservoir(
    real, mistake, value_end, w_end, weight, value_suffix, W_suffix, u
):
    """One row at a time."""
    short = mistake.removeprefix("bounce-")
    found = {"longer": [], "value": [], "W": [], "M": []}
    for i in range(len(u)):
        ends = 0 * w_end[i] if short == "ends-forgotten" else w_end[i]
        step = weight[i] * 0 + 1 if short == "without-the-step" else weight[i]
        longer = step * value_suffix[i]
        worth = value_suffix[i] if short == "target-of-the-suffix" else longer
        worth = sum(real(c) * v for c, v in zip(LUMINANCE, worth, strict=True))
        one = real(W_suffix[i] > 0)
        w = worth * (one if short == "without-the-suffixes-weight" else W_suffix[i])
        takes = decides(mistake, u[i], ends, w)
        value, total = longer if takes else value_end[i], ends + w
        p_hat = sum(real(c) * v for c, v in zip(LUMINANCE, value, strict=True))
        W, M = (total / p_hat, 1) if total > 0 else (0, 1)
        if short == "averaged":
            W, M = W / 2, 2
        if short == "nulls-not-counted" and total == 0:
            M = 0
        for name, part in (("longer", takes), ("value", value), ("W", W), ("M", M)):
            found[name].append(part)
    return found


def path_cache(real, mistake, rough, joint, W, M):
    """Selects."""
    if mistake != "path-cache-joint-not-asked":
        W = np.where(joint == 2, W, 0)
    if mistake == "path-cache-nulls-without-confidence":
        M = np.where(W > 0, M, 0)
    stored = {
        "path-cache-of-useful-paths": (rough == 1) & (W > 0),
        "path-cache-of-joined-paths": (rough == 1) & (joint == 2),
        "path-cache-of-smooth-vertices": rough >= 0,
    }.get(mistake, rough == 1)
    return {"stored": stored, "W": np.where(stored, W, 0), "M": np.where(stored, M, 0)}


def suffix_reach(real, mistake, end, v, value, jacobian, bounces):
    """Counts what the whole path would have."""
    v = 1 if mistake == "suffix-reach-from-the-pixel" else v
    length = end + v - 1 + (mistake == "suffix-reach-one-less")
    fits = (length <= bounces + 1) | (mistake == "suffix-reach-not-asked")
    return {"value": value * fits[:, None], "jacobian": jacobian * fits}
