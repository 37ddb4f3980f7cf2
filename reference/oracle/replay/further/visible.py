"""Replay of visible points: where pixels look, and where the last frame saw it."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.further.camera import (
    depth_of,
    eye_of,
    rays,
    seen_at,
)
from restir_gi.reference.oracle.replay.further.numbers import (
    bounded_somehow,
    moved,
    product,
    unit,
    where_all_positive,
)
from restir_gi.reference.oracle.replay.further.places import alike_at, may_hold, rows_at
from restir_gi.reference.oracle.replay.further.rules import further
from restir_gi.reference.oracle.replay.judgement import (
    Decisions,
    Judgement,
    beside,
    exactly,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import choose, inner, times


def judge_gbuffer(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``gbuffer``.

    Whether the ray meets the triangle is open within the bounds of the signs of its
    sides; the other buffers are judged as the backend decided.
    """
    rounding, part = rounding_of(precision), further(rules)
    eye = eye_of(case.settings, rounding, part)
    a, b, c = (exact(case.inputs[name], rounding) for name in "abc")
    with np.errstate(invalid="ignore", over="ignore"):
        d = rays(eye, case.inputs["pixel"], part.pixel_place)
        n = product(b - a, c - a)
        facing = inner(n, d)
        t = inner(n, a - eye.position) / facing
        p = eye.position + times(d, t)
        sides = [
            inner(n, product(to - start, p - start))
            for start, to in ((a, b), (b, c), (c, a))
        ]
        tests = sides if part.behind_counts else [t, *sides]
        met = where_all_positive(tests if part.back_faces else [*tests, -facing])
        normal = _turned(unit(n), facing) if part.normal_turns else unit(n)
        depth = depth_of(eye, p, part)
    p, normal, depth = (bounded_somehow(x) for x in (p, normal, depth))
    found = outputs["hit"] == 1
    hit = met.settled(found)
    nothing = exact(np.zeros((case.rows, 3)), rounding)
    return Judgement(
        (
            exactly("hit", outputs["hit"], hit),
            beside("position", outputs["position"], choose(hit, p, nothing)),
            beside("normal", outputs["normal"], choose(hit, normal, nothing)),
            beside("depth", outputs["depth"], choose(hit, depth, nothing[:, 0])),
        ),
        {"t": t.value, "n·d": facing.value, "d": d.value},
        met.decisions(found),
        case.random,
    )


def _turned(normal: Bounded, facing: Bounded) -> Bounded:
    """Normals on the side that is seen; a triangle seen edge-on shows either."""
    turned = times(normal, exact(np.where(facing.value > 0, -1, 1), facing.rounding))
    either_side = ~facing.surely_positive & ~facing.surely_not_positive
    loose = np.where(either_side[:, None], 2.0, 0.0)
    return Bounded(turned.value, turned.error + loose, turned.rounding)


def judge_reproject(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``reproject``.

    A place near the border of two pixels may be in either, and a point that is barely
    similar may be similar or not.
    """
    rounding, part = rounding_of(precision), further(rules)
    eye = eye_of(case.settings, rounding, part)
    position = exact(case.inputs["position"], rounding)
    with np.errstate(invalid="ignore", over="ignore"):
        x, y, along = seen_at(eye, position)
        depth = depth_of(eye, position, part)
    depth = abs(depth) if part.behind_counts else depth
    x, y = (moved(bounded_somehow(v), part.place_shift) for v in (x, y))
    seen = (case.inputs["hit"] == 1) | part.misses_go_on
    before = seen & (~along.surely_not_positive | part.behind_counts)
    surely_before = seen & (along.surely_positive | part.behind_counts)
    own_before = seen & ((along.value > 0) | part.behind_counts)
    found = outputs["row"]

    def alike(row: Indices) -> Bounded:
        return alike_at(case, row, depth, rules)

    corners = rows_at(x, y, eye, part.border)
    answers = [alike(row) for row in corners]
    # Four corners see all pixels of a place that is known to half a pixel.
    vague = ~(np.maximum(x.error, y.error) < 0.5)
    unlike = np.any([~answer.surely_positive for answer in answers], axis=0)
    may_be_none = ~surely_before | vague | unlike
    may_be_row = before & may_hold(found, x, y, eye, part.border)
    may_be_row &= ~alike(np.where(may_be_row, found, -1)).surely_not_positive
    own = np.where(own_before & (answers[0].value > 0), corners[0], -1)
    legal = np.where(found == -1, may_be_none, may_be_row)
    differing = legal & (found != own)
    # Places are spread over the pixels, whose borders they meet by chance.
    crossing = np.minimum(2 * (x.error + y.error), 1.0)[surely_before]
    unsure = answers[0].error > 0
    return Judgement(
        (exactly("row", found, np.where(legal, found, own)),),
        {"x": x.value, "y": y.value, "depth": depth.value, "exact": own},
        Decisions(
            np.zeros(case.rows, bool),
            int(differing.sum()),
            float(crossing.sum() + unsure.sum() + (before & ~surely_before).sum()),
        ),
        case.random,
    )
