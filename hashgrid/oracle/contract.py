"""Passes of the contract: a hash grid of cells, light in its cells, paths in its cells.

The order is that of a frame: the cell of a vertex, its hashes, Algorithm 2 line by
line, the look-up; then what a cell is looked up for.
"""

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Pass,
    Setting,
    bits,
    given_with,
    index,
    real,
    vector,
)

COLUMNS = 8
"""Most vertices that a look-up takes from a cell."""

LEVEL = index("level", "of detail, from 0: the edge of the cell is 0.001 · 2^level m")
SIZE = Setting(
    "size",
    "level",
    "what is given of the size of a cell; by another rule than pass cell_level's: edge",
    more=("edge",),
    default="level",
)
SIZES = (
    *given_with("size", ("level",), (LEVEL,)),
    *given_with("size", ("edge",), (real("edge", "of the cell, m"),)),
)
HASHES = (
    bits("bucket_hash", "h₁ of pass cell_hash"),
    bits("checksum", "h₂ of pass cell_hash, at least 1"),
)
BUCKETS = Setting("buckets", "whole number above 0", "of 16 slots each")
SLOT = "bucket · 16 + place in the bucket"


def _along_axes(name: str, meaning: str) -> tuple[Setting, ...]:
    return tuple(Setting(f"{name}_{axis}", "number", meaning) for axis in "xyz")


CELL_BASE = Pass(
    name="cell_base",
    summary="How large cells are, over their distance: some 16 pixels of a camera",
    formula=(
        "base = tan(min(fov_y · 16 · max(1 / height, height / width²), π / 4)); "
        "a row is a camera"
    ),
    inputs=(
        real("fov_y", "field of view from below to above, radians"),
        index("width", "of the picture, pixels"),
        index("height", "the same"),
    ),
    outputs=(real("base", "edge of a cell over its distance, at most 1"),),
    source="[Boisse21], with the numbers of the author's later renderer",
    clauses=(
        "the whole field of view, in radians",
        "the larger of the two quotients counts",
        "the height is told from the width",
        "a cell is seen under 45 degrees at most",
    ),
)

CELL_LEVEL = Pass(
    name="cell_level",
    summary="Level of detail of the cell that a point lies in",
    formula=(
        "when = insertion: e = eye, b = base; look-up: e = eye_before, "
        "b = base_before, those of the frame that built the grid;\n"
        "level = max(⌊log2(1000 · |position − e| · b)⌋, 0)"
    ),
    inputs=(vector("position", "of a point, m"),),
    outputs=(LEVEL,),
    settings=(
        Setting(
            "when", "insertion or look-up", "which grid: this frame's, or the last"
        ),
        *_along_axes("eye", "pinhole of this frame's camera, m"),
        *_along_axes("eye_before", "pinhole of the last frame's camera, m"),
        Setting("base", "number above 0", "edge of a cell over its distance, now"),
        Setting("base_before", "number above 0", "the same of the last frame"),
    ),
    source=(
        "[Boisse21], with the numbers of the author's later renderer. Where rounding "
        "leaves open which of two levels it is, both are right"
    ),
    clauses=(
        "the level is rounded down",
        "the smallest cells have an edge of a millimetre",
        "no level is below 0",
        "the distance is that from the eye",
        "a look-up has the eye and the base of the frame that built the grid",
    ),
)

CELL_JITTER = Pass(
    name="cell_jitter",
    summary="A point moved at random in its tangent plane",
    formula=(
        "edge = 0.001 · 2^level, or as it is given; r = √2 · edge;\n"
        "moved = position + (2 u₀ − 1) r t + (2 u₁ − 1) r b; t and b are unit vectors "
        "orthogonal to the normal and to each other, any that hang on the normal alone"
    ),
    inputs=(
        vector("position", "of a point, m"),
        vector("normal", "its unit normal"),
        *SIZES,
        real("u", "in [0, 1)", 2),
    ),
    outputs=(vector("moved", "the point that the cell is taken of, m"),),
    settings=(SIZE,),
    source="[Boisse21; Binder18], at insertion and at look-up",
    clauses=(
        "the point stays in its tangent plane",
        "it moves by up to √2 edges",
        "it moves to both sides",
        "each tangent has a number of its own",
    ),
)

CELL_KEY = Pass(
    name="cell_key",
    summary="The cell that a point lies in: a cube, and a part of the normal's sphere",
    formula=(
        "edge = 0.001 · 2^level, or as it is given; "
        "(x, y, z) = ⌊position / edge⌋, each rounded down;\n"
        "p = facings; "
        "(a, b, c) = min(max(⌊(normal + 1) · p / 2⌋, 0), p − 1);\n"
        "facing = a + p (b + p c)"
    ),
    inputs=(
        vector("position", "of a point, m; moved before, as a rule"),
        vector("normal", "its unit normal"),
        *SIZES,
    ),
    outputs=(
        index("x", "position in units of the edge, rounded down"),
        index("y", "the same"),
        index("z", "the same"),
        index("facing", "part of the normal's sphere; 0 where facings is 1"),
    ),
    settings=(
        SIZE,
        Setting("facings", "whole number, 1 to 16", "parts of each component of n"),
    ),
    source="[Boisse21]. Where rounding leaves open which side it is, both are right",
    clauses=(
        "positions are rounded down, below 0 too",
        "the edge is a millimetre times a power of two",
        "the normal is told apart in as many parts as are asked for",
        "the x of the normal counts in units, the z in squares",
    ),
)

CELL_HASH = Pass(
    name="cell_hash",
    summary="Hash of the bucket, and checksum, of a cell",
    formula=(
        "words are the lower 32 bits of the fields, two's complement; "
        "all arithmetic is modulo 2³²;\n"
        "bucket_hash = h₁(level + h₁(x + h₁(y + h₁(z + h₁(facing)))));\n"
        "checksum = max(h₂(level + h₂(x + h₂(y + h₂(z + h₂(facing))))), 1);\n"
        "h₁(v), PCG: s = v · 747796405 + 2891336453; "
        "w = ((s >> ((s >> 28) + 4)) ^ s) · 277803737; (w >> 22) ^ w;\n"
        "h₂(v), xxHash32: s = v + 374761393; s = rotl(s, 17) · 668265263; "
        "s = (s ^ (s >> 15)) · 2246822519; s = (s ^ (s >> 13)) · 3266489917; "
        "s ^ (s >> 16)"
    ),
    inputs=(
        index("level", "fields of the cell, as pass cell_key gives them"),
        *(index(name, "the same") for name in ("x", "y", "z", "facing")),
    ),
    outputs=(
        bits("bucket_hash", "modulo the number of buckets it is the bucket"),
        bits("checksum", "tells the cells of a bucket apart; 0 is a free slot"),
    ),
    source="[Jarzynski20]; the nesting is that of the author's later renderer",
    clauses=(
        "the fields are nested in their order",
        "negative coordinates keep their bits",
        "the checksum is another hash",
        "the checksum is at least 1",
    ),
)

CELL_INSERT = Pass(
    name="cell_insert",
    summary="Algorithm 2, FindOrInsertCell: the slots of vertices in an empty table",
    formula=(
        "each active vertex, in any order: the slots of bucket bucket_hash mod buckets "
        "are looked at from the first on; the first that is free becomes the cell's, "
        "and holds its checksum; the first that holds its checksum is its own;\n"
        "−1 where all 16 hold others, and where the vertex is not active"
    ),
    inputs=(*HASHES, bits("active", "1 where the vertex is inserted, else 0")),
    outputs=(index("slot", f"{SLOT}, or −1"),),
    settings=(BUCKETS,),
    source=(
        "[Boisse21, Alg. 2, line 4]. Who comes first is left open: what is compared is "
        "which vertices share a slot, and which slots are taken. No two cells of a "
        "bucket have the same checksum here"
    ),
    clauses=(
        "the vertices of a cell share a slot",
        "cells of a bucket have slots of their own",
        "all 16 slots of a bucket are used, without holes",
        "a vertex is lost where its bucket is full, and nowhere else",
        "vertices that are not active have no slot",
    ),
)

COUNTER = index("counter", "vertices of the cell in the slot of this row")
PLACE = index("place", "of the vertex in its cell, from 0; −1 where it has no slot")

CELL_COUNT = Pass(
    name="cell_count",
    summary="Algorithm 2, atom_inc: how many vertices a cell has, and their places",
    formula=(
        "counter_c = vertices with slot c, counted from 0 whatever left_c is;\n"
        "place = counter_slot before this vertex was counted, in any order: "
        "the places of a cell are 0 to n − 1, each once; −1 where slot is −1"
    ),
    inputs=(
        index("slot", "of a vertex, below the number of rows; or −1"),
        index("left", "what the last frame has left in the counter of this row's slot"),
    ),
    outputs=(COUNTER, PLACE),
    source="[Boisse21, Alg. 2, line 5]; a row is a vertex, and a slot",
    clauses=(
        "counters begin at 0",
        "places begin at 0",
        "each place is given once",
        "vertices without a slot are not counted",
    ),
)

CELL_SCAN = Pass(
    name="cell_scan",
    summary="Algorithm 2, ParallelPrefixSum: where the vertices of each cell begin",
    formula="start_c = counter_0 + ⋯ + counter_(c−1); start_0 = 0",
    inputs=(COUNTER,),
    outputs=(index("start", "of the vertices of this row's slot in the storage"),),
    source="[Boisse21, Alg. 2, line 7]; the article does not say that c is left out",
    clauses=("the cell itself is left out", "the sum goes on over all rows"),
)

CELL_SCATTER = Pass(
    name="cell_scatter",
    summary="Algorithm 2, the last loop: vertices cell by cell",
    formula=(
        "storage at start_slot + place = number of the vertex, which is its row; "
        "nothing for vertices without a slot"
    ),
    inputs=(
        index("slot", "of a vertex, or −1"),
        PLACE,
        index("start", "where the vertices of this row's slot begin"),
    ),
    outputs=(index("storage", "vertices; beyond the last one it is not looked at"),),
    source="[Boisse21, Alg. 2, lines 8 to 11]",
    clauses=(
        "the base is that of the cell",
        "vertices are numbered by their rows",
        "vertices without a slot are not stored",
    ),
)

CELL_FIND = Pass(
    name="cell_find",
    summary="The slot in which a look-up finds its cell",
    formula=(
        "of the 16 slots of bucket bucket_hash mod buckets the one that holds the "
        "checksum; −1 where none does. Whether a free slot ends the search is left open"
    ),
    inputs=(
        bits("table", "checksum in the slot of this row; 0: it is free"),
        *HASHES,
    ),
    outputs=(index("slot", f"{SLOT}, or −1"),),
    settings=(BUCKETS,),
    source="[Boisse21]; rows are slots, and look-ups",
    clauses=(
        "all 16 slots are looked at",
        "the checksum decides",
        "nothing is found where the cell is not there",
    ),
)

CELL_VISIT = Pass(
    name="cell_visit",
    summary="Some of the vertices of a cell, no one twice",
    formula=(
        "n = counter_slot, s = start_slot; min(n, most) of the vertices storage_s to "
        "storage_(s+n−1), in any order; −1 in the columns after them, and everywhere "
        "where slot is −1;\n"
        "all n have the same chance, if u is drawn evenly: as those at (⌊u n⌋ + "
        "⌊k n / most⌋) mod n have, k = 0 to most − 1"
    ),
    inputs=(
        index("slot", "of the cell that is looked up, or −1"),
        index("start", "where the vertices of this row's slot begin"),
        COUNTER,
        index("storage", "vertices, cell by cell"),
        real("u", "in [0, 1): where the walk begins"),
    ),
    outputs=(index("vertex", "that is found, or −1", COLUMNS),),
    settings=(Setting("most", "whole number, 1 to 8", "vertices that are taken"),),
    source=(
        "[Boisse21]. Rows that ask for one cell have numbers u that cover [0, 1) "
        "evenly, so that how often each vertex is found tells its chance"
    ),
    clauses=(
        "vertices are those of the cell",
        "no vertex is taken twice",
        "as many are taken as are asked for, or as there are",
        "all vertices of a cell have the same chance",
        "an empty look-up finds nobody",
    ),
)

CELL_SIMILAR = Pass(
    name="cell_similar",
    summary="Whether two vertices of a cell face alike",
    formula="similar = 1 where max(normal_a · normal_b, 0)⁴ ≥ 1/2, else 0",
    inputs=(
        vector("normal_a", "unit normal of one"),
        vector("normal_b", "unit normal of the other"),
    ),
    outputs=(bits("similar", "1 or 0"),),
    source="as in the renderer of the author of [Boisse21]",
    clauses=(
        "who faces alike is a neighbour",
        "the cosine stands in its fourth power",
        "who faces the other way is none",
    ),
)

LIGHT_TARGET = Pass(
    name="light_target",
    summary="What a surface point reflects of a point on a light, shadows left out",
    formula=(
        "v = light_position − visible_position, d² = v·v, "
        "cos θ = max(visible_normal·v, 0) / d, cos φ = max(−light_normal·v, 0) / d;\n"
        "value = albedo / π · radiance · cos θ · cos φ / d² · area: over the density "
        "1 / area of the place on the light"
    ),
    inputs=(
        vector("visible_position", "surface point, m"),
        vector("visible_normal", "its unit normal"),
        vector("albedo", "of the Lambertian surface"),
        vector("light_position", "point on a light, m"),
        vector("light_normal", "unit normal of the light, on the side that emits"),
        vector("radiance", "emitted by it, W/(m² sr)"),
        real("area", "of the light, m²"),
    ),
    outputs=(vector("value", "f L_e cos θ cos φ / d² · area, W/(m² sr)"),),
    source="[Boisse21, section 3], of which p̂ is the luminance",
    clauses=(
        "the surface has its cosine",
        "the light has its cosine",
        "the distance is squared",
        "the reflectance is albedo / π",
        "the area of the light is in it",
        "0 where the light is below the horizon",
        "0 where the light shows its back",
    ),
    joins=(("visible_position", "light_position"),),
)

STREAM = (
    "the first slot is kept, then slot k in its place where u_k · (w_0 + ⋯ + w_k) < w_k"
)

LIGHT_CANDIDATES = Pass(
    name="light_candidates",
    summary="Algorithm 1: of K points on lights that were drawn one is kept",
    formula=(
        "w_k = p_hat_k / (choice_k · density_k);\n"
        f"{STREAM}; s is what is kept in the end;\n"
        "W = Σw_k / (K · p_hat_s), 0 where Σw_k = 0; M = K"
    ),
    inputs=(
        real("p_hat", "target of what was drawn; 0: a null", "K"),
        real("choice", "probability of its light", "K"),
        real("density", "of the place on the light, in the measure of p_hat", "K"),
        real("u", "in [0, 1); the first decides nothing", "K"),
    ),
    outputs=(
        index("slot", "that is kept; not asked for where W = 0"),
        real("W", "unbiased contribution weight"),
        real("M", "confidence: how many were drawn"),
    ),
    source="[Boisse21, Alg. 1; Talbot05]",
    clauses=(
        "w is divided by the probability of the light",
        "w is divided by the density on the light",
        "nulls count",
        "the sum is divided by K",
        "W is divided by the target of what is kept",
        "u decides as in every stream",
        "W = 0 where no weight arrives",
    ),
)


def _reused() -> tuple[Field, ...]:
    return (
        real("W", "of the reservoirs; slot 0 is the vertex's own", "K"),
        real("M", "their confidences", "K"),
        bits("there", "1 where a vertex was found at all, else 0", "K"),
        real("target_base", "p̂ of a sample where it was kept", "K"),
        real("target_here", "p̂ of it at the vertex that looks up", "K"),
        real("target_at", "row s, column k: p̂ of sample s where k was kept", "K", "K"),
        real("u", "in [0, 1); the first decides nothing", "K"),
    )


LIGHT_REUSE = Pass(
    name="light_reuse",
    summary="Light reservoirs of a cell's vertices meet the vertex's own",
    formula=(
        "pass path_reuse with canonical = 0 and all Jacobians 1, since a point on a "
        "light is the same seen from anywhere: in short\n"
        "M_k = 0 where there_k = 0; w_k = m_k · target_here_k · W_k; "
        f"{STREAM};\n"
        "mis = 1/M: m_k = M_k, Z = ΣM_k, biased where targets differ in where they are "
        "0; 1/Z: Z = Σ M_k of those with p_k(s) > 0; "
        "balance: Z = Σ M_k p_k(s) / p_s(s);\n"
        "W = Σw_k / (Z · target_here_s), M = min(ΣM_k, cap); W = 0 where Σw_k = 0"
    ),
    inputs=_reused(),
    outputs=(
        index("slot", "that is kept; not asked for where W = 0"),
        real("p_hat", "target_here_s, of what is kept; not asked for where W = 0"),
        real("W", "unbiased contribution weight"),
        real("M", "confidence"),
    ),
    settings=(
        Setting("mis", "1/M, 1/Z, balance, pairwise or defensive", "the weights"),
        Setting("cap", "number, 1 upwards", "limit of M, on the way out"),
    ),
    source="[Boisse21, section 3], with the MIS weights of [Lin22]",
    clauses=(
        "the vertex's own reservoir competes",
        "the target is that at the vertex that looks up",
        "nulls count",
        "look-ups that found nobody do not count",
        "the sum is divided as it is asked for",
        "M is capped on the way out",
        "W = 0 where no weight arrives",
    ),
)

BOUNCE_RESERVOIR = Pass(
    name="bounce_reservoir",
    summary="The suffix of a path from x_v on: it ends at x_(v+1), or goes on there",
    formula=(
        "value_longer = weight · value_suffix, channel by channel; "
        "w_longer = Y(value_longer) · W_suffix, "
        "luminance Y = 0.2126 R + 0.7152 G + 0.0722 B;\n"
        "longer = 1 where u · (w_end + w_longer) < w_longer; value is what is kept;\n"
        "W = (w_end + w_longer) / Y(value), 0 where both weights are 0; "
        "M = 1, null or not"
    ),
    inputs=(
        vector("value_end", "f / p of the path that ends at x_(v+1), W/(m² sr)"),
        real("w_end", "its resampling weight; 0 where it has no light"),
        vector("weight", "f cos θ / p of the step from x_v to x_(v+1)"),
        vector("value_suffix", "f / p of the suffix of x_(v+1)"),
        real("W_suffix", "its weight, which a cell may have improved"),
        real("u", "in [0, 1)"),
    ),
    outputs=(
        bits("longer", "1 where the path goes on; not asked for where W = 0"),
        vector("value", "of what is kept, at x_v; not asked for where W = 0"),
        real("W", "unbiased contribution weight"),
        real("M", "confidence"),
    ),
    source="[ZyanideND], as a recursion from the end of the path",
    clauses=(
        "the longer path has the weight of the step",
        "the suffix has its W",
        "paths that end at the next vertex compete",
        "a path without light counts",
        "W is divided by the target of what is kept",
        "u decides as in every stream",
        "W = 0 where no weight arrives",
    ),
)

PATH_CACHE = Pass(
    name="path_cache",
    summary="What is stored of a path's suffix in the cell of its first vertex",
    formula=(
        "stored = 1 where rough is 1, whatever the suffix is worth; else 0;\n"
        "W stays where joint is 2, and becomes 0 where it is not: such a suffix cannot "
        "be joined at once, and counts as a null; M stays"
    ),
    inputs=(
        bits("rough", "1 where paths may be joined to the vertex, else 0"),
        index("joint", "first point of the suffix that is joined: 2 is its second one"),
        real("W", "of the suffix; 0: a null"),
        real("M", "its confidence"),
    ),
    outputs=(
        bits("stored", "1 where the vertex is inserted into the grid, else 0"),
        real("W", "as it is stored; not asked for where stored is 0"),
        real("M", "the same"),
    ),
    source="[ZyanideND], step 1; the article drops nulls, which is biased",
    clauses=(
        "nulls are stored",
        "a suffix that cannot be joined is stored as a null",
        "vertices that are not rough are not stored",
        "M of nulls stays",
    ),
)

SUFFIX_REACH = Pass(
    name="suffix_reach",
    summary="Suffixes from a cell that would make a path longer than is asked for",
    formula=(
        "the last point of a suffix has index end, its first one index 1, which is "
        "x_v of the path that takes it over;\n"
        "value and jacobian stay where end ≤ bounces + 2 − v, and become 0 where not"
    ),
    inputs=(
        index("end", "index of the last surface point of the suffix"),
        index("v", "number of the vertex that takes it over, from 1"),
        vector("value", "f / p of the suffix there, W/(m² sr)"),
        real("jacobian", "of its shift there"),
    ),
    outputs=(
        vector("value", "as it competes, W/(m² sr)"),
        real("jacobian", "as it competes"),
    ),
    settings=(Setting("bounces", "whole number, 1 to 30", "of indirect light"),),
    source="[ZyanideND], whose cells hold vertices of all bounces; MIS weights ask it",
    clauses=(
        "longer paths do not exist",
        "the longest path exists",
        "the bounces before the vertex count",
    ),
)

HASH_GRID_PASSES = (
    CELL_BASE,
    CELL_LEVEL,
    CELL_JITTER,
    CELL_KEY,
    CELL_HASH,
    CELL_INSERT,
    CELL_COUNT,
    CELL_SCAN,
    CELL_SCATTER,
    CELL_FIND,
    CELL_VISIT,
    CELL_SIMILAR,
    LIGHT_TARGET,
    LIGHT_CANDIDATES,
    LIGHT_REUSE,
    BOUNCE_RESERVOIR,
    PATH_CACHE,
    SUFFIX_REACH,
)
