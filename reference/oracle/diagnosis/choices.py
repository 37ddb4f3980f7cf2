"""Known mistakes with decisions and with the search for neighbours."""

from collections.abc import Iterator
from dataclasses import replace

from restir_gi.reference.oracle.contract.passes import BORDER, SEARCH
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SPATIAL,
    Hypothesis,
    mistake,
)
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.verbs import choose

U_RIGHT = "kept where u (w_before + w) < w"


def _old_sum(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
    return w - u * w_before


def _always(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
    return w


def _not_strict(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
    found = w - u * (w_before + w)
    return choose(found.value == 0, constant(1.0, found), found)


def _other_side(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
    found = w - (constant(1.0, u) - u) * (w_before + w)
    return choose(w_before.value == 0, w, found)


def _never(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
    alone = w_before.value == 0
    return choose(alone, w, constant(-1.0, w))


def _of_tables() -> Iterator[Hypothesis]:
    for name, what, wrong, table in (
        (
            "table-columns-and-rows-exchanged",
            "the second number of an offset is taken for columns",
            "x + offset₁, y + offset₀",
            "exchanged",
        ),
        (
            "table-offsets-subtracted",
            "offsets are subtracted",
            "x − offset₀, y − offset₁",
            "opposite",
        ),
        (
            "table-rows-upwards",
            "rows are counted upwards",
            "x + offset₀, y − offset₁",
            "upwards",
        ),
    ):
        right = "x + offset₀, y + offset₁"
        made = mistake(name, what, wrong, right, ("neighbors",), table=table)
        yield replace(made, only=(SEARCH.name, SEARCH.more))


def _of_borders() -> Iterator[Hypothesis]:
    right = "clamped: c = min(max(c, 0), n − 1); mirrored: −c, and 2 n − 1 − c"
    for border, what, wrong in (
        ("refused", "places outside are refused, whatever is asked", "row = −1"),
        (
            "clamped",
            "places outside are clamped, whatever is asked",
            "c = min(max(c, 0), n − 1)",
        ),
        (
            "mirrored",
            "places outside are mirrored, whatever is asked",
            "c = −c where c < 0, then c = 2 n − 1 − c where c ≥ n",
        ),
        (
            "mirrored-about-centers",
            "the image is mirrored about the centres of its last pixels",
            "c = 2 n − 2 − c where c ≥ n",
        ),
        (
            "mirrored-about-edges",
            "the image is mirrored about its edges",
            "c = −1 − c where c < 0",
        ),
        ("wrapped", "the image goes on at its other side", "c = c mod n"),
    ):
        name = f"border-{border}"
        made = mistake(name, what, wrong, right, ("neighbors",), border=border)
        yield replace(made, only=(BORDER.name, BORDER.more))


CHOICES = (
    mistake(
        "accepts-by-the-old-sum",
        "a candidate is compared with the sum before it",
        "kept where u w_before < w",
        U_RIGHT,
        ("merge", *REUSE),
        preference=_old_sum,
    ),
    mistake(
        "always-accepts",
        "every candidate with a weight is kept",
        "kept where w > 0",
        U_RIGHT,
        ("merge", *REUSE),
        preference=_always,
    ),
    mistake(
        "accepts-on-equality",
        "the comparison is not strict, so that a weight of 0 may be kept",
        "kept where u (w_before + w) ≤ w",
        U_RIGHT,
        ("merge",),
        preference=_not_strict,
    ),
    mistake(
        "keeps-the-other-side",
        "u is used as 1 − u: the same distribution, and other numbers",
        "kept where (1 − u) (w_before + w) < w",
        U_RIGHT,
        ("merge", *REUSE),
        departure="order",
        preference=_other_side,
    ),
    mistake(
        "one-number-for-all-neighbors",
        "one random number decides on all neighbours",
        "u = u_neighbors[0]",
        "u = u_neighbors[k]",
        SPATIAL,
        "RTXDI e7c576e",
        shared_decision="neighbors",
    ),
    mistake(
        "depth-relative-to-own",
        "the depth test is relative to the pixel's own depth",
        "|z_a − z_b| ≤ max_depth · z_a",
        "|z_a − z_b| ≤ max_depth · max(z_a, z_b)",
        ("similar", "neighbors"),
        "gradient-restir",
        depth_test="own",
    ),
    mistake(
        "radius-not-halved",
        "the search radius is not halved after a failure",
        "r = r",
        "r = max(r / 2, min_radius)",
        ("neighbors",),
        narrows=False,
    ),
    *_of_tables(),
    *_of_borders(),
    mistake(
        "never-accepts",
        "the sample that won is not copied",
        "the first sample of the stream is kept",
        U_RIGHT,
        ("merge", *REUSE),
        preference=_never,
    ),
    mistake(
        "stream-reversed",
        "the stream runs backwards: the same distribution, and other samples",
        "the last of the stream comes first",
        "the past, then the pixel's own, then neighbours in their order",
        REUSE,
        departure="order",
        order="reversed",
    ),
    mistake(
        "one-number-for-all-decisions",
        "one random number decides on all reservoirs of a stream",
        "u = u_own",
        "u = u_own, then u_neighbors[k]",
        ("spatial",),
        "kajiya 4d813e3",
        shared_decision="all",
    ),
    mistake(
        "stream-ignored",
        "the last word of the key is ignored: all passes draw the same numbers",
        "key = (pixel, frame, seed)",
        "key = (pixel, frame, seed, 64 · stream + dimension)",
        ("random",),
        "HIPRT 7c534c1d",
        ignored_words=(3,),
    ),
    mistake(
        "frame-ignored",
        "the frame is not in the key: noise stands still",
        "key = (pixel, seed, 64 · stream + dimension)",
        "key = (pixel, frame, seed, 64 · stream + dimension)",
        ("random",),
        "gradient-restir",
        ignored_words=(1,),
    ),
)
