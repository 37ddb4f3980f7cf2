"""Replay of visible points: where pixels look, and where the last frame saw it."""

from math import cos, radians

import numpy as np

from reference.arrays import Indices, Masks, Scalars
from reference.oracle.cases import Buffers, Case
from reference.oracle.contract.fields import Precision
from reference.oracle.replay.bounded import Bounded, exact, rounding_of
from reference.oracle.replay.further.camera import (
    Eye,
    eye_of,
    offset_from,
    rays,
    seen_at,
)
from reference.oracle.replay.further.numbers import (
    bounded_somehow,
    product,
    unit,
    where_all_positive,
)
from reference.oracle.replay.judgement import Decisions, Judgement, beside, exactly
from reference.oracle.replay.neighbors import similarity
from reference.oracle.replay.rules import Rules
from reference.oracle.replay.verbs import choose, inner, times


def judge_gbuffer(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``gbuffer``.

    Parameters
    ----------
    case : Case
        The call.
    outputs : mapping of str to array
        By the backend.
    rules : Rules
        What is calculated with.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    Judgement
        N rows.  Whether the ray meets the triangle is open within the bounds of the
        signs of its sides; the other buffers are judged as the backend decided.
    """
    rounding = rounding_of(precision)
    eye = eye_of(case.settings, rounding)
    a, b, c = (exact(case.inputs[name], rounding) for name in "abc")
    with np.errstate(invalid="ignore", over="ignore"):
        d = rays(eye, case.inputs["pixel"])
        n = product(b - a, c - a)
        facing = inner(n, d)
        t = inner(n, a - eye.position) / facing
        p = eye.position + times(d, t)
        sides = [
            inner(n, product(to - start, p - start))
            for start, to in ((a, b), (b, c), (c, a))
        ]
        met = where_all_positive([t, *sides])
        normal = times(unit(n), exact(np.where(facing.value > 0, -1, 1), rounding))
        # A triangle that is seen edge-on shows either side.
        either_side = ~facing.surely_positive & ~facing.surely_not_positive
        loose = np.where(either_side[:, None], 2.0, 0.0)
        normal = Bounded(normal.value, normal.error + loose, rounding)
        depth = inner(eye.forward, offset_from(eye, p))
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


def judge_reproject(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``reproject``.

    Parameters
    ----------
    case : Case
        The call.
    outputs : mapping of str to array
        By the backend.
    rules : Rules
        What is calculated with.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    Judgement
        N rows.  A place near the border of two pixels may be in either, and a point
        that is barely similar may be similar or not.
    """
    rounding = rounding_of(precision)
    eye = eye_of(case.settings, rounding)
    with np.errstate(invalid="ignore", over="ignore"):
        x, y, depth = seen_at(eye, exact(case.inputs["position"], rounding))
    x, y = bounded_somehow(x), bounded_somehow(y)
    seen = case.inputs["hit"] == 1
    before = seen & ~depth.surely_not_positive
    surely_before = seen & depth.surely_positive
    found = outputs["row"]

    def alike(row: Indices) -> Bounded:
        return _alike(case, row, depth, rules)

    corners = _places(x, y, eye)
    answers = [alike(row) for row in corners]
    # Four corners see all pixels of a place that is known to half a pixel.
    vague = ~(np.maximum(x.error, y.error) < 0.5)
    unlike = np.any([~answer.surely_positive for answer in answers], axis=0)
    may_be_none = ~surely_before | vague | unlike
    may_be_row = before & _may_hold(found, x, y, eye)
    may_be_row &= ~alike(np.where(may_be_row, found, -1)).surely_not_positive
    own = np.where(seen & (depth.value > 0) & (answers[0].value > 0), corners[0], -1)
    legal = np.where(found == -1, may_be_none, may_be_row)
    excused = legal & (found != own)
    # Places are spread over the pixels, whose borders they meet by chance.
    crossing = np.minimum(2 * (x.error + y.error), 1.0)[surely_before]
    unsure = answers[0].error > 0
    return Judgement(
        (exactly("row", found, np.where(legal, found, own)),),
        {"x": x.value, "y": y.value, "depth": depth.value, "exact": own},
        Decisions(
            np.zeros(case.rows, bool),
            int(excused.sum()),
            float(crossing.sum() + unsure.sum() + (before & ~surely_before).sum()),
        ),
        case.random,
    )


def _places(x: Bounded, y: Bounded, eye: Eye) -> list[Indices]:
    """Rows at a place, the exact one first, and at the corners of its bounds."""
    with np.errstate(invalid="ignore"):
        ends = [(v.value - v.error, v.value + v.error) for v in (x, y)]
    corners = [(at_x, at_y) for at_x in ends[0] for at_y in ends[1]]
    return [_row_at(at_x, at_y, eye) for at_x, at_y in ((x.value, y.value), *corners)]


def _row_at(x: Scalars, y: Scalars, eye: Eye) -> Indices:
    """Row of the pixel that holds a place, −1 outside and for what is no number."""
    width, height = eye.width.value[0], eye.height.value[0]
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    column, line = (np.floor(np.where(inside, v, 0.0)) for v in (x, y))
    return np.where(inside, line * width + column, -1).astype(np.int64)


def _may_hold(row: Indices, x: Bounded, y: Bounded, eye: Eye) -> Masks:
    """Whether the pixel of a row may hold a place."""
    width, height = int(eye.width.value[0]), int(eye.height.value[0])
    line, column = np.divmod(row, width)
    may: Masks = (row >= 0) & (row < width * height)
    for place, start in ((x, column), (y, line)):
        # A bound that is no number excludes nothing.
        may &= ~(start > place.value + place.error)
        may &= ~(start + 1 <= place.value - place.error)
    return may


def _alike(case: Case, row: Indices, depth: Bounded, rules: Rules) -> Bounded:
    """Positive where points are similar to what rows of the last frame saw."""
    rounding, to = depth.rounding, np.maximum(row, 0)
    max_depth = float(case.settings["max_depth"])
    # The limit max_depth · max(z, z_row) has its share of the error of z.
    whole = Bounded(depth.value, depth.error * (1 + max_depth), rounding)
    found = similarity(
        exact(case.inputs["normal"], rounding),
        whole,
        exact(case.inputs["normal_before"][to], rounding),
        exact(case.inputs["depth_before"][to], rounding),
        cos(radians(float(case.settings["max_angle"]))),
        max_depth,
        rules,
    )
    nowhere = row < 0
    return Bounded(
        np.where(nowhere, -1.0, found.value),
        np.where(nowhere, 0.0, found.error),
        rounding,
    )
