"""Known mistakes in hash grids, and in the light and the paths of their cells."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf, pi
from typing import Any, cast

from restir_gi.extensions.oracle.reuse.mistakes import REUSE_MISTAKES
from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.hashgrid.oracle.rules import (
    CONTRACT_GRID,
    CellRules,
    GridRules,
    HashRules,
    LightRules,
    SuffixRules,
    TableRules,
)
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    Departure,
    Hypothesis,
    mistake,
)

BASE = "base = tan(min(fov_y · 16 · max(1/h, h/w²), π / 4))"
LEVEL = "level = max(⌊log2(1000 · |position − e| · b)⌋, 0)"
MOVED = "moved = position + (2 u₀ − 1) r t + (2 u₁ − 1) r b, r = √2 edge"
KEY = "(x, y, z) = ⌊position / edge⌋, edge = 0.001 · 2^level"
HASH = "h(level + h(x + h(y + h(z + h(facing)))))"
INSERT = "the first slot of the bucket that is free, or holds the cell's checksum"
FIND = "the one of 16 slots that holds the checksum, or −1"
WALK = "min(n, most) of the n vertices from start on, each with the same chance"
TARGET = "value = albedo / π · radiance · cos θ · cos φ / d² · area"
DRAWN = "w_k = p_hat_k / (choice_k · density_k)"
KEPT = "slot k is kept where u_k · (w_0 + ⋯ + w_k) < w_k"
LONGER = "w_longer = Y(weight · value_suffix) · W_suffix"


def _known(
    pass_name: str,
    name: str,
    what: str,
    wrong: str,
    right: str,
    *seen: str,
    part: GridRules,
    departure: str = "",
    declared: str = "",
) -> Hypothesis:
    kind = cast(Departure, departure)
    said = cast(Departure, declared)
    return mistake(
        name,
        what,
        wrong,
        right,
        (pass_name,),
        *seen,
        departure=kind,
        declared=said,
        part=part,
    )


def _cell(**changes: Any) -> GridRules:
    return replace(CONTRACT_GRID, cell=CellRules(**changes))


def _words(**changes: Any) -> GridRules:
    return replace(CONTRACT_GRID, words=HashRules(**changes))


def _table(**changes: Any) -> GridRules:
    return replace(CONTRACT_GRID, table=TableRules(**changes))


def _light(**changes: Any) -> GridRules:
    return replace(CONTRACT_GRID, light=LightRules(**changes))


def _suffix(**changes: Any) -> GridRules:
    return replace(CONTRACT_GRID, suffix=SuffixRules(**changes))


OF_JACOBIANS = {
    "reuse-jacobian-left-out",
    "reuse-jacobian-divides",
    "reuse-jacobian-twice",
    "reuse-made-without-jacobian",
    "reuse-made-times-jacobian",
}
"""Mistakes of pass path_reuse that no point on a light shows: its Jacobian is 1."""


def _without_jacobian(formula: str) -> str:
    return formula.replace(" · jacobian_k", "").replace(" / jacobian_s", "")


CELLS = (
    *(
        _known(
            "cell_base", f"cell-base-{name}", what, wrong, BASE, part=_cell(**changes)
        )
        for name, what, wrong, changes in (
            (
                "in-degrees",
                "the tangent of degrees is taken as if they were radians",
                "tan(min(180 / π · fov_y · 16 · max(1/h, h/w²), π / 4))",
                {"fov_scale": 180 / pi},
            ),
            (
                "of-half-the-field",
                "half the field of view stands for all of it",
                "tan(min(fov_y / 2 · 16 · max(1/h, h/w²), π / 4))",
                {"fov_scale": 0.5},
            ),
            (
                "of-the-smaller-quotient",
                "the smaller of the two quotients counts",
                "tan(min(fov_y · 16 · min(1/h, h/w²), π / 4))",
                {"quotients": "smaller"},
            ),
            (
                "of-the-other-side",
                "width and height are exchanged",
                "tan(min(fov_y · 16 · max(1/w, w/h²), π / 4))",
                {"quotients": "turned"},
            ),
            (
                "not-bounded",
                "the angle is not bounded: of few pixels its tangent is anything",
                "tan(fov_y · 16 · max(1/h, h/w²))",
                {"widest": inf},
            ),
        )
    ),
    _known(
        "cell_level",
        "cell-level-of-another-rule",
        "another rule gives the size of cells: right if it is meant, and declared",
        "whole numbers that grow with the distance from the eye of the grid, or stay",
        LEVEL,
        declared="neighbors",
        part=_cell(levels="own"),
    ),
    _known(
        "cell_level",
        "cell-level-by-this-eye",
        "a look-up has the eye of its own frame, not of the frame that built the grid",
        "e = eye, b = base, at look-up too",
        "look-up: e = eye_before, b = base_before",
        part=_cell(eye_of_now=True),
    ),
    _known(
        "cell_level",
        "cell-level-from-the-origin",
        "the distance is that from the origin of the world",
        "level = max(⌊log2(1000 · |position| · b)⌋, 0)",
        LEVEL,
        part=_cell(eye_forgotten=True),
    ),
    _known(
        "cell_level",
        "cell-level-rounded-up",
        "the level is rounded up",
        "level = max(⌈log2(1000 · |position − e| · b)⌉, 0)",
        LEVEL,
        part=_cell(rounding="up"),
    ),
    _known(
        "cell_level",
        "cell-level-to-the-nearest",
        "the level is rounded to the nearest",
        "level = max([log2(1000 · |position − e| · b)], 0)",
        LEVEL,
        part=_cell(rounding="nearest"),
    ),
    _known(
        "cell_level",
        "cell-level-in-metres",
        "the smallest cell is a metre, not a millimetre",
        "level = max(⌊log2(|position − e| · b)⌋, 0)",
        LEVEL,
        part=_cell(smallest=1.0),
    ),
    _known(
        "cell_level",
        "cell-level-below-0",
        "levels are not bounded from below",
        "level = ⌊log2(1000 · |position − e| · b)⌋",
        LEVEL,
        part=_cell(least_level=False),
    ),
    _known(
        "cell_jitter",
        "cell-jitter-without-root-2",
        "points move by one edge, not by √2",
        "r = edge",
        MOVED,
        part=_cell(reach=1.0),
    ),
    _known(
        "cell_jitter",
        "cell-jitter-by-half",
        "points move by half of √2 edges: the width is taken for the reach",
        "r = edge / √2",
        MOVED,
        part=_cell(reach=0.5**0.5),
    ),
    _known(
        "cell_jitter",
        "cell-jitter-one-sided",
        "u stands in place of 2 u − 1: points move to one side",
        "moved = position + u₀ r t + u₁ r b",
        MOVED,
        part=_cell(one_sided=True),
    ),
    _known(
        "cell_jitter",
        "cell-jitter-in-the-ground-plane",
        "points move along x and z, whatever their normal",
        "t = (1, 0, 0), b = (0, 0, 1)",
        "t and b are orthogonal to the normal",
        "HIPRT 01b681fe",
        part=_cell(plane="ground"),
    ),
    _known(
        "cell_jitter",
        "cell-jitter-along-a-diagonal",
        "both tangents have the same number",
        "moved = position + (2 u₀ − 1) r (t + b)",
        MOVED,
        part=_cell(one_number=True),
    ),
    _known(
        "cell_key",
        "cell-key-truncated",
        "positions are cut towards 0: the cells at 0 are twice as wide",
        "(x, y, z) = int(position / edge)",
        KEY,
        "HIPRT 0f99d4bb",
        "global-restir",
        part=_cell(cut="trunc"),
    ),
    _known(
        "cell_key",
        "cell-key-rounded",
        "positions are rounded to the nearest",
        "(x, y, z) = [position / edge]",
        KEY,
        part=_cell(cut="round"),
    ),
    _known(
        "cell_key",
        "cell-key-in-metres",
        "the edge of the smallest cells is a metre",
        "edge = 2^level",
        KEY,
        part=_cell(smallest=1.0),
    ),
    _known(
        "cell_key",
        "cell-key-edge-grows-evenly",
        "the edge is proportional to the level",
        "edge = 0.001 · max(level, 1)",
        KEY,
        part=_cell(edge_doubles=False),
    ),
    _known(
        "cell_key",
        "cell-key-without-normal",
        "the normal is not looked at",
        "facing = 0",
        "facing = a + facings (b + facings c)",
        part=_cell(parts=False),
    ),
    _known(
        "cell_key",
        "cell-key-normal-turned",
        "the z of the normal counts in units, its x in squares",
        "facing = c + facings (b + facings a)",
        "facing = a + facings (b + facings c)",
        part=_cell(parts_turned=True),
    ),
)

HASHES = (
    _known(
        "cell_hash",
        "cell-hash-of-another-kind",
        "words of another hash, which tell cells apart: right if it is declared",
        "the same words for the same cell, others for another; a checksum above 0",
        HASH,
        declared="order",
        part=_words(own=True),
    ),
    _known(
        "cell_hash",
        "cell-hash-z-y-x",
        "coordinates are hashed in the other order",
        "h(level + h(z + h(y + h(x + h(facing)))))",
        HASH,
        part=_words(order=("facing", "x", "y", "z", "level")),
    ),
    _known(
        "cell_hash",
        "cell-hash-without-level",
        "cells of all levels have the same hashes",
        "h(x + h(y + h(z + h(facing))))",
        HASH,
        part=_words(order=("facing", "z", "y", "x")),
    ),
    _known(
        "cell_hash",
        "cell-hash-without-facing",
        "the part of the normal is not hashed",
        "h(level + h(x + h(y + h(z))))",
        HASH,
        part=_words(order=("z", "y", "x", "level")),
    ),
    _known(
        "cell_hash",
        "cell-hash-combined",
        "the hashes of the fields are combined by exclusive or: (1, 2, 2) is (1, 3, 3)",
        "h(level) ^ h(x) ^ h(y) ^ h(z) ^ h(facing)",
        HASH,
        part=_words(nested=False),
    ),
    _known(
        "cell_hash",
        "cell-hash-of-negatives-as-0",
        "coordinates below 0 become 0 as they are cast to words without a sign",
        "uint(−3) = 0",
        "the lower 32 bits, two's complement: uint(−3) = 4294967293",
        part=_words(saturates=True),
    ),
    _known(
        "cell_hash",
        "cell-checksum-is-the-hash",
        "the checksum is the hash of the bucket once more: it tells no cells apart",
        "checksum = bucket_hash",
        "checksum = max(h₂(…), 1), another hash",
        part=_words(one_hash=True),
    ),
    _known(
        "cell_hash",
        "cell-hashes-exchanged",
        "the bucket has xxHash, and the checksum PCG",
        "bucket_hash = h₂(…), checksum = max(h₁(…), 1)",
        "bucket_hash = h₁(…), checksum = max(h₂(…), 1)",
        departure="order",
        part=_words(exchanged=True),
    ),
    _known(
        "cell_hash",
        "cell-checksum-may-be-0",
        "a checksum of 0 stays: its cell looks like a free slot",
        "checksum = h₂(…)",
        "checksum = max(h₂(…), 1)",
        part=_words(lifted="never"),
    ),
)

TABLE = (
    *(
        _known(
            f"cell_{name}",
            f"cell-{name}-by-upper-bits",
            "the bucket is that of the upper bits of the hash: a product, no division",
            "bucket = bucket_hash · buckets >> 32",
            "bucket = bucket_hash mod buckets",
            departure="order",
            part=_table(bucket_of="upper bits"),
        )
        for name in ("insert", "find")
    ),
    _known(
        "cell_insert",
        "cell-insert-without-checksum",
        "whoever finds a slot in use takes it for its own",
        "the first slot of the bucket, used or free",
        INSERT,
        "global-restir",
        part=_table(told_apart="never"),
    ),
    _known(
        "cell_insert",
        "cell-insert-a-slot-each",
        "who does not get a free slot goes on, though its own cell has it by now",
        "the first slot of the bucket that is free",
        INSERT,
        "SHARC #5",
        part=_table(told_apart="each vertex"),
    ),
    _known(
        "cell_insert",
        "cell-insert-of-winners-alone",
        "who does not win the exchange is lost, though there is room, or its cell",
        "−1 where the compare-and-swap finds the slot in use",
        INSERT,
        "SHARC #5",
        part=_table(winners_alone=True),
    ),
    _known(
        "cell_insert",
        "cell-insert-tries-one-slot",
        "a bucket is given up at its first slot",
        "−1 where the first slot holds another cell",
        INSERT,
        part=_table(probes=1),
    ),
    _known(
        "cell_insert",
        "cell-insert-leaves-out-the-last-slot",
        "15 of 16 slots are tried",
        "slots 0 to 14",
        "slots 0 to 15",
        part=_table(probes=15),
    ),
    _known(
        "cell_insert",
        "cell-insert-into-the-last-slot",
        "cells of a full bucket share its last slot",
        "bucket · 16 + 15 where the bucket is full",
        "−1 where the bucket is full",
        part=_table(overflow="last slot"),
    ),
    _known(
        "cell_insert",
        "cell-insert-goes-on-in-the-next-bucket",
        "where a bucket is full the next one takes the cell",
        "the first slot from there on that is free, or holds the checksum",
        "−1 where the bucket is full",
        departure="order",
        part=_table(overflow="next bucket"),
    ),
    _known(
        "cell_insert",
        "cell-insert-of-everybody",
        "vertices that are not active are inserted too",
        "each vertex",
        "each vertex where active is 1",
        part=_table(inactive_too=True),
    ),
    _known(
        "cell_count",
        "cell-counters-not-cleared",
        "counters go on from what the last frame left in them",
        "counter = left + vertices of the cell",
        "counter = vertices of the cell",
        part=_table(cleared=False),
    ),
    _known(
        "cell_count",
        "cell-places-from-1",
        "the place is the counter after the vertex was counted",
        "place = 1, 2, … n",
        "place = 0, 1, … n − 1",
        part=_table(first_place=1),
    ),
    _known(
        "cell_scan",
        "cell-scan-inclusive",
        "the prefix sum has the counter of the cell itself in it",
        "start_c = counter_0 + ⋯ + counter_c",
        "start_c = counter_0 + ⋯ + counter_(c−1)",
        part=_table(inclusive=True),
    ),
    *(
        _known(
            "cell_scan",
            f"cell-scan-restarts-every-{rows}",
            f"the sums of blocks of {rows} rows are not added",
            f"start_c = sum from row {rows} · ⌊c / {rows}⌋ on",
            "start_c = sum from row 0 on",
            part=_table(restarts=rows),
        )
        for rows in (64, 128, 256, 512, 1024)
    ),
    _known(
        "cell_scatter",
        "cell-scatter-of-append-numbers",
        "what is stored is the vertex's number among those that were appended",
        "storage = place in the append buffer",
        "storage = row of the vertex",
        part=_table(numbers="appended"),
    ),
    _known(
        "cell_scatter",
        "cell-scatter-of-slots",
        "what is stored is the slot of the vertex",
        "storage = slot",
        "storage = row of the vertex",
        part=_table(numbers="slots"),
    ),
    _known(
        "cell_find",
        "cell-find-without-checksum",
        "the first slot in use is taken for the cell",
        "the first of 16 slots that is not free",
        FIND,
        "global-restir",
        part=_table(checksum_compared=False),
    ),
    _known(
        "cell_find",
        "cell-find-in-the-first-slot",
        "one slot of a bucket is looked at",
        "slot 0 of the bucket",
        FIND,
        part=_table(looked_at=1),
    ),
    _known(
        "cell_find",
        "cell-find-leaves-out-the-last-slot",
        "15 of 16 slots are looked at",
        "slots 0 to 14 of the bucket",
        FIND,
        part=_table(looked_at=15),
    ),
    _known(
        "cell_find",
        "cell-find-goes-on-in-the-next-bucket",
        "where a bucket is full the next one is looked at as well",
        "slots from the bucket on, until one is free",
        FIND,
        departure="order",
        part=_table(looks_further=True),
    ),
    _known(
        "cell_find",
        "cell-find-ends-in-a-free-slot",
        "a look-up that fails gives the free slot in which it ended",
        "the first slot that is free, or holds the checksum",
        FIND,
        part=_table(gives_free_slot=True),
    ),
    _known(
        "cell_visit",
        "cell-visit-from-the-first",
        "the walk begins at the first vertex, wherever u lies",
        "storage at start + ⌊k n / most⌋",
        WALK,
        part=_table(walk="from the first"),
    ),
    _known(
        "cell_visit",
        "cell-visit-twice",
        "of a cell with fewer vertices than are asked for some are taken again",
        "most vertices, whatever n is",
        WALK,
        "Capsaicin",
        part=_table(walk="twice"),
    ),
    _known(
        "cell_visit",
        "cell-visit-beyond-the-cell",
        "the walk does not come round: it goes on into the next cell",
        "storage at start + ⌊u n⌋ + ⌊k n / most⌋",
        "storage at start + (⌊u n⌋ + ⌊k n / most⌋) mod n, for one",
        part=_table(walk="beyond"),
    ),
    _known(
        "cell_visit",
        "cell-visit-of-the-next-cell",
        "the list begins where that of the next cell does",
        "storage from start_(slot+1) on",
        "storage from start_slot on",
        part=_table(walk="next cell"),
    ),
)

HELD = (
    ("half", "W and M are float16, to the nearest", "storage"),
    ("half, cut", "W and M are float16, cut off towards 0", "storage"),
    ("half, infinite", "W and M are float16, and infinite beyond 65504", ""),
)
"""Ways to store a reservoir, and whether they are right, to their rounding."""


def _as(held: str) -> str:
    """A way to store in the name of a hypothesis."""
    words = {
        "half": "halves",
        "half, cut": "halves-cut",
        "half, infinite": "halves-infinite",
    }
    return words[held]


def _held(
    pass_name: str, name: str, part: Callable[[str], GridRules]
) -> Iterator[Hypothesis]:
    """Storage in 16 bits, of one pass."""
    for held, what, departure in HELD:
        yield _known(
            pass_name,
            f"{name}-in-{_as(held)}",
            what,
            f"between passes {what}",
            "W and M are kept as they are; of halves the largest is 65504",
            departure=departure,
            part=part(held),
        )


LIGHTS = (
    *_held("light_candidates", "light-candidates", lambda held: _light(held=held)),
    *_held(
        "light_reuse", "light-reuse", lambda held: _light(reuse=ReuseRules(held=held))
    ),
    *(
        _known(
            "cell_similar",
            f"cell-similar-{name}",
            what,
            wrong,
            "max(n · n', 0)⁴ ≥ 1/2",
            part=_light(similar=kind),
        )
        for name, kind, what, wrong in (
            ("by-the-cosine", "cosine", "the cosine has no power", "n · n' ≥ 1/2"),
            (
                "by-the-square",
                "square",
                "the cosine is squared",
                "max(n · n', 0)² ≥ 1/2",
            ),
            (
                "on-both-sides",
                "both sides",
                "vertices that face away are neighbours",
                "(n · n')⁴ ≥ 1/2",
            ),
            (
                "inverted",
                "inverted",
                "those that face alike are left out",
                "max(n · n', 0)⁴ ≤ 1/2",
            ),
        )
    ),
    *(
        _known(
            "light_target",
            f"light-target-{name}",
            what,
            wrong,
            TARGET,
            part=_light(**changes),
        )
        for name, what, wrong, changes in (
            (
                "without-the-lights-cosine",
                "the cosine at the light is left out",
                "albedo / π · radiance · cos θ / d² · area",
                {"light_cosine": "left out"},
            ),
            (
                "without-the-surfaces-cosine",
                "the cosine at the surface is left out",
                "albedo / π · radiance · cos φ / d² · area",
                {"surface_cosine": "left out"},
            ),
            (
                "lit-from-behind",
                "lights shine from their backs",
                "albedo / π · radiance · cos θ · |cos φ| / d² · area",
                {"light_cosine": "absolute"},
            ),
            (
                "below-the-horizon",
                "lights below the horizon are reflected",
                "albedo / π · radiance · |cos θ| · cos φ / d² · area",
                {"surface_cosine": "absolute"},
            ),
            (
                "distance-once",
                "the distance is not squared",
                "albedo / π · radiance · cos θ · cos φ / d · area",
                {"distances": 1},
            ),
            (
                "without-distance",
                "the distance is left out",
                "albedo / π · radiance · cos θ · cos φ · area",
                {"distances": 0},
            ),
            (
                "without-area",
                "the density is taken for one in solid angle: the area is left out",
                "albedo / π · radiance · cos θ · cos φ / d²",
                {"area": False},
            ),
            (
                "without-pi",
                "the reflectance is the albedo",
                "albedo · radiance · cos θ · cos φ / d² · area",
                {"pi": False},
            ),
            (
                "without-albedo",
                "the albedo is left out",
                "radiance / π · cos θ · cos φ / d² · area",
                {"albedo": False},
            ),
        )
    ),
    *(
        _known(
            "light_candidates",
            f"light-candidates-{name}",
            what,
            wrong,
            right,
            departure=departure,
            part=_light(**changes),
        )
        for name, what, wrong, right, departure, changes in (
            (
                "without-the-choice",
                "the probability of the light is left out: a factor of their number",
                "w_k = p_hat_k / density_k",
                DRAWN,
                "",
                {"choice": False},
            ),
            (
                "without-the-density",
                "the density on the light is left out",
                "w_k = p_hat_k / choice_k",
                DRAWN,
                "",
                {"density": False},
            ),
            (
                "without-pdf",
                "targets are weights",
                "w_k = p_hat_k",
                DRAWN,
                "",
                {"choice": False, "density": False},
            ),
            (
                "times-pdf",
                "the target is multiplied by the density",
                "w_k = p_hat_k · choice_k · density_k",
                DRAWN,
                "",
                {"times_pdf": True},
            ),
            (
                "without-nulls",
                "candidates without light do not count",
                "M = candidates with w > 0",
                "M = K",
                "",
                {"nulls_count": False},
            ),
            (
                "not-divided",
                "the sum is not divided by the number of candidates",
                "W = Σw_k / p_hat_s",
                "W = Σw_k / (K · p_hat_s)",
                "",
                {"counted": "1"},
            ),
            (
                "count-once",
                "what is kept counts as one sample, not as K",
                "M = 1",
                "M = K",
                "confidence",
                {"confidence": "1"},
            ),
            (
                "target-of-the-first",
                "W is divided by the target of the first candidate",
                "W = Σw_k / (K · p_hat_0)",
                "W = Σw_k / (K · p_hat_s)",
                "",
                {"first_target": True},
            ),
            (
                "kept-by-the-sum-before",
                "a candidate is held against the sum without it",
                "slot k is kept where u_k · (w_0 + ⋯ + w_(k−1)) < w_k",
                KEPT,
                "",
                {"kept_by": "sum before"},
            ),
            (
                "u-turned",
                "the number decides the other way round",
                "slot k is kept where (1 − u_k) · (w_0 + ⋯ + w_k) < w_k",
                KEPT,
                "order",
                {"kept_by": "turned"},
            ),
        )
    ),
    *(
        _known(
            "light_reuse",
            f"light-{h.name}",
            h.mistake,
            _without_jacobian(h.wrong),
            _without_jacobian(h.right),
            *h.seen,
            departure=h.departure,
            part=_light(reuse=h.rules.part),
        )
        for h in REUSE_MISTAKES
        if h.name not in OF_JACOBIANS
    ),
)

SUFFIXES = (
    *_held("path_cache", "path-cache", lambda held: _suffix(held=held)),
    *(
        _known(
            "bounce_reservoir",
            f"bounce-{name}",
            what,
            wrong,
            right,
            departure=departure,
            part=_suffix(**changes),
        )
        for name, what, wrong, right, departure, changes in (
            (
                "without-the-step",
                "the weight of the step to the next vertex is left out",
                "value_longer = value_suffix",
                "value_longer = weight · value_suffix",
                "",
                {"step_weight": False},
            ),
            (
                "without-the-suffixes-weight",
                "W of the suffix is left out",
                "w_longer = Y(weight · value_suffix)",
                LONGER,
                "",
                {"suffix_weight": False},
            ),
            (
                "target-of-the-suffix",
                "the longer path competes with the target of its suffix",
                "w_longer = Y(value_suffix) · W_suffix",
                LONGER,
                "",
                {"target_of_suffix": True},
            ),
            (
                "ends-forgotten",
                "paths that end at the next vertex do not compete",
                "w_end = 0",
                "w_end competes",
                "",
                {"ends_compete": False},
            ),
            (
                "nulls-not-counted",
                "a path without light is drawn again, and does not count",
                "M = 0 where both weights are 0",
                "M = 1, null or not",
                "",
                {"nulls_count": False},
            ),
            (
                "averaged",
                "two parts of an integral are averaged as if they were two samples",
                "W = (w_end + w_longer) / (2 Y(value)), M = 2",
                "W = (w_end + w_longer) / Y(value), M = 1",
                "",
                {"averaged": True},
            ),
            (
                "kept-by-the-sum-before",
                "the longer path is held against the other one alone",
                "longer = 1 where u · w_end < w_longer",
                "longer = 1 where u · (w_end + w_longer) < w_longer",
                "",
                {"kept_by": "sum before"},
            ),
            (
                "u-turned",
                "the number decides the other way round",
                "longer = 1 where (1 − u) · (w_end + w_longer) < w_longer",
                "longer = 1 where u · (w_end + w_longer) < w_longer",
                "order",
                {"kept_by": "turned"},
            ),
        )
    ),
    *(
        _known(
            "path_cache",
            f"path-cache-{name}",
            what,
            wrong,
            right,
            *seen,
            part=_suffix(**changes),
        )
        for name, what, wrong, right, changes, seen in (
            (
                "of-useful-paths",
                "suffixes without light, or that cannot be joined, are not stored",
                "stored = 1 where rough is 1 and W > 0",
                "stored = 1 where rough is 1, whatever W is",
                {"stored": "useful"},
                ("[ZyanideND]",),
            ),
            (
                "of-joined-paths",
                "suffixes that cannot be joined are not stored",
                "stored = 1 where rough is 1 and joint is 2",
                "stored = 1 where rough is 1, whatever joint is",
                {"stored": "joined"},
                ("[ZyanideND]",),
            ),
            (
                "of-smooth-vertices",
                "vertices that paths cannot be joined to are stored",
                "stored = 1",
                "stored = 1 where rough is 1",
                {"stored": "any roughness"},
                (),
            ),
            (
                "joint-not-asked",
                "suffixes that cannot be joined keep their weight",
                "W, whatever joint is",
                "W = 0 where joint is not 2",
                {"joint_asked": False},
                (),
            ),
            (
                "nulls-without-confidence",
                "nulls are stored with M = 0",
                "M = 0 where W = 0",
                "M stays",
                {"null_confidence": False},
                (),
            ),
        )
    ),
    *(
        _known(
            "suffix_reach",
            f"suffix-reach-{name}",
            what,
            wrong,
            "0 where end > bounces + 2 − v",
            part=_suffix(**changes),
        )
        for name, what, wrong, changes in (
            (
                "not-asked",
                "suffixes may make a path of any length",
                "value and jacobian stay",
                {"reach": "any"},
            ),
            (
                "one-less",
                "the longest path is left out",
                "0 where end ≥ bounces + 2 − v",
                {"reach": "below"},
            ),
            (
                "from-the-pixel",
                "the bounces before the vertex do not count",
                "0 where end > bounces + 1",
                {"from_v": False},
            ),
        )
    ),
)

HASH_GRID_MISTAKES: tuple[Hypothesis, ...] = (
    *CELLS,
    *HASHES,
    *TABLE,
    *LIGHTS,
    *SUFFIXES,
)
