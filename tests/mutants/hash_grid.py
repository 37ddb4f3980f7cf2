"""Mistakes in the kernels of the hash grid, of light in cells and of suffixes.

In the manner of :mod:`tests.mutants.catalogue`: edits that the passes of the contract
have to see.  Those that whole frames refute stand in :mod:`tests.mutants.grid`.
"""

from tests.mutants.catalogue import Mutant
from tests.mutants.grid import GRID, LIGHTS, REGIR, SETTINGS, WORLD

SAMPLING = "restir_gi.reference.scene.light_sampling"

OFFSET = "offset = np.clip(position - np.asarray(lattice.eye), -FARTHEST, FARTHEST)"
WANTED = "wanted = np.maximum(distance * lattice.base / SMALLEST, 1.0)"
EXPONENT = "np.frexp(wanted)[1].astype(np.int64) - 1"
REACH = "reach = np.sqrt(2.0) * edge"
SIDES = "a, b = ((2.0 * lane - 1.0) * reach for lane in u[:2])"
MOVED = "moved: Vec3s = position + a[:, None] * across + b[:, None] * along"
FRAME = "across, along = normal_frames(normal)"
SCALED = "scaled = np.floor(position / edge[:, None])"
PART = "part = np.clip(np.floor((normal + 1.0) * (parts / 2)), 0, parts - 1)"
FACING = "facing = (a + parts * (b + parts * c)).astype(np.int16)"
ORDER = "(self.facing, self.z, self.y, self.x, self.level)"
WORD = "word = (field.astype(np.int64) & 0xFFFFFFFF).astype(np.uint32)"
BOTH = "bucket, checksum = pcg(word + bucket), xxhash(word + checksum)"
LOW = "low = np.maximum(checksum, np.uint32(1)).astype(np.uint64)"
HIGH = "both: Hashes = (bucket.astype(np.uint64) << np.uint64(32)) | low"
COUNTERS = "counters = np.bincount(cell, minlength=cells)"
FIRST = "first = np.repeat(prefix_sum(counters)[:-1], counters)"
PLACES = 'index_in_cell[np.argsort(cell, kind="stable")] = np.arange(len(cell)) - first'
SUM = "return np.concatenate([[0], np.cumsum(counters)])"
SCATTER = "scatter_offset = index_buffer[cell] + index_in_cell"
STORED = "cell_storage[scatter_offset] = vertex"
SORTED = 'order = np.argsort(hashes, kind="stable")'
HEAD = "first = _first_of_each(take(keys, order))"
CAME = "bucket = (hashes[came] >> np.uint64(32)).astype(np.int64) % buckets"
RANK = "rank = np.arange(len(turn)) - begin[np.cumsum(fresh) - 1]"
SLOT = "np.where(rank < BUCKET, bucket[turn] * BUCKET + rank, NOWHERE)"
ALIKE = "alike: Masks = dot(a, b) >= ALIKE"
SAME = "same = alike & take(grid.cells, here).same(take(keys, open_rows))"
HASHED = "alike = grid.hashes[at[open_rows]] == wanted[open_rows]"
COUNT = "count = np.where(cells == NOWHERE, 0, grid.index_buffer[cell + 1] - first)"
BEGIN = "offset = np.minimum((u * count).astype(np.int64), np.maximum(count - 1, 0))"
PLACE = "place = (offset + k * count // most) % np.maximum(count, 1)"
FEW = "place = np.where(count <= most, k, place)"
TAKEN = "taken = k < count"
BASE = "first = grid.index_buffer[cell]\n"


def _mutant(module, name, old, new, *expected, kind="bias", ids=()):
    return Mutant(name, ids, module, old, new, expected, kind)


WIDE = "wide = fov_y * PIXELS * np.maximum(1 / h, h / w**2)"
BOUND = "base: Scalars = np.tan(np.minimum(wide, np.pi / 4))"

BASES = [
    _mutant(
        GRID,
        "the base is of degrees",
        WIDE,
        WIDE.replace("fov_y *", "np.degrees(fov_y) *"),
        "cell-base-in-degrees",
    ),
    _mutant(
        GRID,
        "the base is of half the field of view",
        WIDE,
        WIDE.replace("fov_y *", "fov_y / 2 *"),
        "cell-base-of-half-the-field",
    ),
    _mutant(
        GRID,
        "the base is of the smaller quotient",
        WIDE,
        WIDE.replace("maximum", "minimum"),
        "cell-base-of-the-smaller-quotient",
    ),
    _mutant(
        GRID,
        "the base has width and height exchanged",
        "w, h = width, height",
        "h, w = width, height",
        "cell-base-of-the-other-side",
    ),
    _mutant(
        GRID,
        "the base is not bounded",
        BOUND,
        "base: Scalars = np.tan(wide)",
        "cell-base-not-bounded",
    ),
    _mutant(GRID, "the base is an angle", BOUND, BOUND.replace("np.tan", "")),
    _mutant(GRID, "the base is of 8 pixels", "PIXELS = 16.0", "PIXELS = 8.0"),
    _mutant(
        GRID,
        "the base has the width once",
        WIDE,
        WIDE.replace("w**2", "w"),
    ),
]

CELLS = [
    _mutant(
        GRID,
        "cells are as large as seen from the origin",
        OFFSET,
        "offset = np.clip(position, -FARTHEST, FARTHEST)",
        "cell-level-from-the-origin",
    ),
    _mutant(
        GRID,
        "levels are one too high",
        EXPONENT,
        "np.frexp(wanted)[1].astype(np.int64)",
    ),
    _mutant(
        GRID,
        "levels count metres",
        "SMALLEST = 1e-3",
        "SMALLEST = 1.0",
        "cell-level-in-metres",
        "cell-key-in-metres",
    ),
    _mutant(
        GRID, "levels are of squares", WANTED, WANTED.replace("distance", "distance**2")
    ),
    _mutant(
        GRID,
        "levels go below 0",
        WANTED,
        "wanted = np.where(distance > 0, distance * lattice.base / SMALLEST, 1.0)",
        "cell-level-below-0",
    ),
    _mutant(
        GRID,
        "edges grow by four",
        "np.ldexp(SMALLEST, level.astype(np.int32))",
        "np.ldexp(SMALLEST, 2 * level.astype(np.int32))",
    ),
    _mutant(
        GRID,
        "the jitter goes to one side",
        SIDES,
        "a, b = (lane * reach for lane in u[:2])",
        "cell-jitter-one-sided",
    ),
    _mutant(
        GRID,
        "the jitter is one edge wide",
        REACH,
        "reach = edge",
        "cell-jitter-without-root-2",
    ),
    _mutant(
        GRID,
        "the jitter is half as wide",
        REACH,
        "reach = np.sqrt(0.5) * edge",
        "cell-jitter-by-half",
    ),
    _mutant(
        GRID,
        "the jitter goes along a diagonal",
        SIDES,
        "a, b = ((2.0 * lane - 1.0) * reach for lane in (u[0], u[0]))",
        "cell-jitter-along-a-diagonal",
    ),
    _mutant(
        GRID, "the jitter leaves the plane", MOVED, MOVED.replace("* along", "* normal")
    ),
    _mutant(
        GRID, "the jitter has one tangent", MOVED, MOVED.replace("* along", "* across")
    ),
    _mutant(
        GRID,
        "the sides of the jitter are absolute",
        SIDES,
        "a, b = (abs(2.0 * lane - 1.0) * reach for lane in u[:2])",
    ),
    _mutant(
        GRID,
        "places are truncated",
        SCALED,
        SCALED.replace("floor", "trunc"),
        "cell-key-truncated",
        ids=("HG-09",),
    ),
    _mutant(
        GRID,
        "places are rounded",
        SCALED,
        SCALED.replace("floor", "rint"),
        "cell-key-rounded",
    ),
    _mutant(
        GRID,
        "places are multiplied by the edge",
        SCALED,
        SCALED.replace("/ edge", "* edge"),
    ),
    _mutant(GRID, "facings are rounded", PART, PART.replace("np.floor", "np.rint")),
    _mutant(
        GRID, "facings are not bounded", PART, PART.replace("parts - 1)", "parts)")
    ),
    _mutant(
        GRID, "facings see one half", PART, PART.replace("(normal + 1.0)", "normal")
    ),
    _mutant(
        GRID,
        "facings are turned",
        FACING,
        "facing = (c + parts * (b + parts * a)).astype(np.int16)",
        "cell-key-normal-turned",
    ),
    _mutant(
        GRID,
        "facings collide",
        FACING,
        "facing = (a + parts * (b + c)).astype(np.int16)",
    ),
]

WORDS = [
    _mutant(
        GRID,
        "z and x change places in the hash",
        ORDER,
        "(self.facing, self.x, self.y, self.z, self.level)",
        "cell-hash-z-y-x",
    ),
    _mutant(
        GRID,
        "the hash has no level",
        ORDER,
        "(self.facing, self.z, self.y, self.x)",
        "cell-hash-without-level",
    ),
    _mutant(
        GRID,
        "the hash has no facing",
        ORDER,
        "(self.z, self.y, self.x, self.level)",
        "cell-hash-without-facing",
    ),
    _mutant(
        GRID,
        "negative places are 0 in the hash",
        WORD,
        "word = np.maximum(field, 0).astype(np.uint32)",
        "cell-hash-of-negatives-as-0",
    ),
    _mutant(
        GRID,
        "the hash has 16 bits of a place",
        WORD,
        WORD.replace("0xFFFFFFFF", "0xFFFF"),
    ),
    _mutant(
        GRID,
        "one hash for both",
        BOTH,
        "bucket, checksum = pcg(word + bucket), pcg(word + checksum)",
        "cell-checksum-is-the-hash",
    ),
    _mutant(
        GRID,
        "words replace the hash",
        BOTH,
        BOTH.replace("word + bucket", "word ^ bucket"),
    ),
    _mutant(
        GRID,
        "a checksum may be 0",
        LOW,
        "low = checksum.astype(np.uint64)",
        "cell-checksum-may-be-0",
    ),
    _mutant(
        GRID,
        "a checksum is at least 2",
        LOW,
        LOW.replace("np.uint32(1)", "np.uint32(2)"),
    ),
    _mutant(
        GRID,
        "PCG without its last step",
        "mixed: UInts = (word >> np.uint32(22)) ^ word",
        "mixed: UInts = word",
    ),
    _mutant(GRID, "PCG with another constant", "2891336453", "2891336454"),
    _mutant(
        GRID,
        "PCG shifts by 5",
        "(state >> np.uint32(28)) + np.uint32(4)",
        "(state >> np.uint32(28)) + np.uint32(5)",
    ),
    _mutant(
        GRID,
        "xxHash turns by 16",
        "(h << np.uint32(17)) | (h >> np.uint32(15))",
        "(h << np.uint32(16)) | (h >> np.uint32(16))",
    ),
    _mutant(GRID, "xxHash with a factor too many", "2246822519", "3266489917 * 1 + 0"),
    _mutant(
        GRID,
        "xxHash without its last step",
        "mixed: UInts = h ^ (h >> np.uint32(16))",
        "mixed: UInts = h",
    ),
]

TABLES = [
    _mutant(GRID, "buckets of 8", "BUCKET = 16", "BUCKET = 8"),
    _mutant(
        GRID,
        "a full bucket runs over",
        SLOT,
        "bucket[turn] * BUCKET + rank",
        ids=("HG-19",),
    ),
    _mutant(
        GRID,
        "the last slot stays free",
        SLOT,
        SLOT.replace("rank < BUCKET", "rank < BUCKET - 1"),
        "cell-insert-leaves-out-the-last-slot",
    ),
    _mutant(
        GRID,
        "one cell a bucket",
        SLOT,
        SLOT.replace("rank < BUCKET", "rank < 1"),
        "cell-insert-tries-one-slot",
    ),
    _mutant(
        GRID,
        "a full bucket shares its last slot",
        SLOT,
        "bucket[turn] * BUCKET + np.minimum(rank, BUCKET - 1)",
        "cell-insert-into-the-last-slot",
    ),
    _mutant(
        GRID, "slots begin at 1", SLOT, SLOT.replace("+ rank", "+ (rank + 1) % BUCKET")
    ),
    _mutant(
        GRID,
        "slots without their bucket",
        SLOT,
        "np.where(rank < BUCKET, rank, NOWHERE)",
    ),
    _mutant(
        GRID,
        "buckets by the upper bits",
        CAME,
        CAME.replace("% buckets", "* buckets >> 32"),
    ),
    _mutant(
        GRID,
        "buckets by the checksum",
        CAME,
        CAME.replace(">> np.uint64(32)", "& np.uint64(0xFFFFFFFF)"),
    ),
    _mutant(
        GRID,
        "cells are told apart by their buckets alone",
        "first[1:] = ~cut(keys, slice(1, None)).same(cut(keys, slice(0, last)))",
        "first[1:] = cut(keys, slice(1, None)).x != cut(keys, slice(0, last)).x",
    ),
    _mutant(GRID, "ranks go on over buckets", RANK, "rank = np.arange(len(turn))"),
    _mutant(
        GRID,
        "places begin with 1",
        PLACES,
        PLACES.replace("- first", "- first + 1"),
        "cell-places-from-1",
    ),
    _mutant(GRID, "places go on over cells", PLACES, PLACES.replace(" - first", "")),
    _mutant(
        GRID,
        "places of unsorted vertices",
        PLACES,
        "index_in_cell[:] = np.arange(len(cell)) - first",
    ),
    _mutant(
        GRID,
        "counters say whether",
        COUNTERS,
        "counters = np.minimum(np.bincount(cell, minlength=cells), 1)",
    ),
    _mutant(
        GRID,
        "the sum has the cell in it",
        SUM,
        "return np.append(np.cumsum(counters), np.sum(counters))",
        "cell-scan-inclusive",
        ids=("HG-03",),
    ),
    _mutant(GRID, "the sum begins with 1", SUM, SUM.replace("[[0]", "[[1]")),
    _mutant(
        GRID,
        "the sum restarts every 256",
        SUM,
        "c = np.append(0, np.cumsum(counters)); k = np.arange(len(c)) // 256 * 256;"
        " return c - c[k]",
        "cell-scan-restarts-every-256",
    ),
    _mutant(
        GRID,
        "bases are those of the cell before",
        SCATTER,
        SCATTER.replace("[cell]", "[np.maximum(cell - 1, 0)]"),
    ),
    _mutant(
        GRID, "lists are turned", STORED, "cell_storage[scatter_offset] = vertex[::-1]"
    ),
    _mutant(
        GRID,
        "slots are stored",
        STORED,
        "cell_storage[scatter_offset] = cell",
        "cell-scatter-of-slots",
    ),
    _mutant(
        GRID,
        "numbers of appending are stored",
        STORED,
        "cell_storage[scatter_offset] = np.arange(len(vertex))",
        "cell-scatter-of-append-numbers",
    ),
]

LOOK_UPS = [
    _mutant(
        GRID,
        "whoever has these hashes or more is found",
        SAME,
        "same = np.ones(len(open_rows), bool)",
    ),
    _mutant(GRID, "nobody is found", SAME, "same = alike & False"),
    _mutant(
        GRID,
        "the cell after it is found",
        "found[open_rows[same]] = here[same]",
        "found[open_rows[same]] = (here[same] + 1) % len(grid.slot)",
    ),
    _mutant(
        GRID,
        "walks begin with the first vertex",
        BEGIN,
        "offset = np.zeros(len(u), np.int64)",
        "cell-visit-from-the-first",
    ),
    _mutant(
        GRID,
        "walks never begin with the last vertex",
        BEGIN,
        "offset = (u * np.maximum(count - 1, 0)).astype(np.int64)",
    ),
    _mutant(
        GRID,
        "walks go beyond",
        PLACE,
        "place = offset + k * count // most",
        "cell-visit-beyond-the-cell",
    ),
    _mutant(GRID, "walks stand still", PLACE, PLACE.replace("k * count // most", "0")),
    _mutant(
        GRID,
        "walks do not come to the end",
        PLACE,
        PLACE.replace("np.maximum(count, 1)", "np.maximum(count - 1, 1)"),
    ),
    _mutant(
        GRID,
        "of few vertices the first is taken",
        FEW,
        FEW.replace("k, place", "0, place"),
    ),
    _mutant(
        GRID,
        "of a few vertices the list is read beyond",
        TAKEN,
        "taken = count > 0",
    ),
    _mutant(GRID, "one vertex too few", TAKEN, "taken = k < count - 1"),
    _mutant(
        GRID, "lists begin one later", BASE, "first = grid.index_buffer[cell] + 1\n"
    ),
    _mutant(
        GRID,
        "who found no cell has the first",
        COUNT,
        "count = grid.index_buffer[cell + 1] - first",
    ),
    _mutant(
        GRID,
        "neighbours by the cosine",
        "ALIKE = 0.5**0.25",
        "ALIKE = 0.5",
        "cell-similar-by-the-cosine",
    ),
    _mutant(
        GRID,
        "neighbours by the square of the cosine",
        "ALIKE = 0.5**0.25",
        "ALIKE = 0.5**0.5",
        "cell-similar-by-the-square",
    ),
    _mutant(
        GRID,
        "neighbours on both sides",
        ALIKE,
        "alike: Masks = abs(dot(a, b)) >= ALIKE",
        "cell-similar-on-both-sides",
    ),
    _mutant(
        GRID,
        "neighbours face elsewhere",
        ALIKE,
        "alike: Masks = dot(a, b) < ALIKE",
        "cell-similar-inverted",
    ),
]

COSINE = "cos_light = np.maximum(-dot(n_to, wi), 0.0)"
PDF = "pdf = divide_or_zero(density * distance * distance, cos_light)"
FOUND = "found: Vec3s = scattering(materials, points, light.wi) * light.weight"

LIGHT = [
    _mutant(
        SAMPLING,
        "lights shine from both sides",
        COSINE,
        "cos_light = abs(dot(n_to, wi))",
        "light-target-lit-from-behind",
    ),
    _mutant(
        SAMPLING,
        "lights shine from their backs alone",
        COSINE,
        "cos_light = np.maximum(dot(n_to, wi), 0.0)",
    ),
    _mutant(
        SAMPLING,
        "lights have no cosine",
        COSINE,
        "cos_light = (dot(n_to, wi) < 0) * 1.0",
        "light-target-without-the-lights-cosine",
    ),
    _mutant(
        SAMPLING,
        "the density has the distance once",
        PDF,
        "pdf = divide_or_zero(density * distance, cos_light)",
        "light-target-distance-once",
    ),
    _mutant(
        SAMPLING,
        "the density is that of an area",
        PDF,
        "pdf = divide_or_zero(density, cos_light)",
        "light-target-without-distance",
    ),
    _mutant(
        SAMPLING,
        "the density is multiplied by the cosine",
        PDF,
        "pdf = density * distance * distance * cos_light",
    ),
    _mutant(
        SAMPLING,
        "the density has no area",
        PDF,
        "pdf = divide_or_zero(distance * distance, cos_light)",
        "light-target-without-area",
    ),
    _mutant(
        LIGHTS, "light is not scattered", FOUND, "found: Vec3s = 1.0 * light.weight"
    ),
    _mutant(
        LIGHTS,
        "light is scattered twice",
        FOUND,
        FOUND + " * scattering(materials, points, light.wi)",
    ),
    _mutant(
        WORLD,
        "the sum of candidates stays whole",
        "finalize(r, r.M)",
        "finalize(r, 0 * r.M + 1)",
        "light-candidates-not-divided",
    ),
    _mutant(
        WORLD,
        "one candidate too few is counted",
        "finalize(r, r.M)",
        "finalize(r, r.M - 1)",
    ),
    _mutant(
        WORLD,
        "a candidate without light is none",
        "r = merge(r, candidate, u)",
        "r = merge(r, replace(candidate, M=(candidate.w > 0) * 1.0), u)",
    ),
    _mutant(
        WORLD,
        "the first candidate is kept",
        "r = merge(r, candidate, u)",
        "r = merge(r, candidate, 0 * u + 2)",
    ),
    _mutant(
        WORLD,
        "u decides the other way round",
        "r = merge(r, candidate, u)",
        "r = merge(r, candidate, 1 - u)",
        "light-candidates-u-turned",
        kind="equivalent",
    ),
]

SUFFIXES = [
    _mutant(
        REGIR,
        "W of the suffix is forgotten",
        "Candidates(y, p_hat, p_hat * W, 0 * p_hat)",
        "Candidates(y, p_hat, p_hat * (W > 0), 0 * p_hat)",
        "bounce-without-the-suffixes-weight",
    ),
    _mutant(
        REGIR,
        "the suffix has W twice",
        "Candidates(y, p_hat, p_hat * W, 0 * p_hat)",
        "Candidates(y, p_hat, p_hat * W * W, 0 * p_hat)",
    ),
    _mutant(
        REGIR,
        "the target of the suffix is its W",
        "Candidates(y, p_hat, p_hat * W, 0 * p_hat)",
        "Candidates(y, W, p_hat * W, 0 * p_hat)",
    ),
    _mutant(
        REGIR,
        "paths that end are forgotten",
        "return merge(found, Candidates",
        "return merge(replace(found, w=0 * found.w), Candidates",
        "bounce-ends-forgotten",
    ),
    _mutant(
        REGIR,
        "nulls are no samples",
        "return finalize(replace(found, M=ones), ones)",
        "return finalize(replace(found, M=(found.w > 0) * ones), ones)",
        "bounce-nulls-not-counted",
    ),
    _mutant(
        REGIR,
        "two parts are averaged",
        "return finalize(replace(found, M=ones), ones)",
        "return finalize(replace(found, M=2 * ones), 2 * ones)",
        "bounce-averaged",
    ),
    _mutant(
        REGIR,
        "the sum of two parts is not closed",
        "return finalize(replace(found, M=ones), ones)",
        "return Reservoirs(found.y, found.w, ones)",
    ),
    _mutant(
        REGIR,
        "suffixes keep their weight wherever they are joined",
        "return np.where(joint == 2, W, 0.0)",
        "return np.where(joint > 0, W, 0.0)",
    ),
    _mutant(
        REGIR,
        "suffixes keep their weight",
        "return np.where(joint == 2, W, 0.0)",
        "return 1.0 * W",
        "path-cache-joint-not-asked",
    ),
    _mutant(
        SETTINGS,
        "useful suffixes alone are stored",
        '(W > 0) | (self.nulls == "counted")',
        "W > 0",
        "path-cache-of-useful-paths",
    ),
    _mutant(
        REGIR,
        "long suffixes keep their value",
        "return np.where(fits[:, None], value, 0.0), np.where(fits, jacobian, 0.0)",
        "return value, np.where(fits, jacobian, 0.0)",
    ),
    _mutant(
        REGIR,
        "long suffixes keep their Jacobian",
        "return np.where(fits[:, None], value, 0.0), np.where(fits, jacobian, 0.0)",
        "return np.where(fits[:, None], value, 0.0), jacobian",
    ),
    _mutant(
        REGIR,
        "suffixes may be of any length",
        "return np.where(fits[:, None], value, 0.0), np.where(fits, jacobian, 0.0)",
        "return value, jacobian",
        "suffix-reach-not-asked",
    ),
]

HASH_GRID_MUTANTS = [*BASES, *CELLS, *WORDS, *TABLES, *LOOK_UPS, *LIGHT, *SUFFIXES]
EQUIVALENT = [m for m in HASH_GRID_MUTANTS if m.kind == "equivalent"]
