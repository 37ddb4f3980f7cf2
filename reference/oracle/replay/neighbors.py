"""Replay of the search for neighbours, along the backend's own steps."""

from collections.abc import Callable, Mapping
from math import cos, pi, radians
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.passes import (
    BORDER,
    CLAMPED,
    MIRRORED,
    REFUSED,
    SEARCH,
    TABLE,
)
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.judgement import Compared, Decisions, Judgement
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.stream import at_an_end
from restir_gi.reference.oracle.replay.verbs import inner

Border = Callable[[Indices, int], Indices]


def _mirrored_about(first: int, last: int) -> Border:
    """Reflection about the centres of the border's pixels, 0, or their edges, 1."""

    def border(at: Indices, size: int) -> Indices:
        at = np.where(at < 0, -first - at, at)
        return np.where(at >= size, 2 * size - 2 + last - at, at)

    return border


BORDERS: Mapping[str, Border] = {
    REFUSED: lambda at, size: at,
    CLAMPED: lambda at, size: np.clip(at, 0, size - 1),
    MIRRORED: _mirrored_about(0, 1),
    "mirrored-about-centers": _mirrored_about(0, 0),
    "mirrored-about-edges": _mirrored_about(1, 1),
    "wrapped": lambda at, size: at % size,
}
"""What stands for places along an axis of so many pixels."""

TABLES: Mapping[str, tuple[tuple[int, int], ...]] = {
    "asked": ((1, 0), (0, 1)),
    "exchanged": ((0, 1), (1, 0)),
    "opposite": ((-1, 0), (0, -1)),
    "upwards": ((1, 0), (0, -1)),
}
"""By what offsets of a table are multiplied."""

SINE = 8.0
"""Roundings of a sine or cosine of 2πu: the argument's, times up to 2π, and its own."""


def similarity(
    normal_a: Bounded,
    depth_a: Bounded,
    normal_b: Bounded,
    depth_b: Bounded,
    least_cosine: float,
    max_depth: float,
    rules: Rules,
) -> Bounded:
    """Positive where two points are similar.

    Parameters
    ----------
    normal_a, normal_b : Bounded; (N, 3) unit normals
    depth_a, depth_b : Bounded; (N,), m
    least_cosine : float; of the largest angle
    max_depth : float; relative difference
    rules : Rules; what the difference is relative to

    Returns
    -------
    Bounded
        (N,), a smallest slack; equality is similar, and certain where the two points
        are the same.
    """
    unit = depth_a.rounding.unit
    angle = inner(normal_a, normal_b)
    # A cosine moves by the sine for each rounding of its angle, of up to π.
    sine = np.sqrt(max(1 - least_cosine**2, 0.0))
    turned = unit * (abs(least_cosine) + np.pi * sine)
    alike = Bounded(angle.value - least_cosine, angle.error + turned, angle.rounding)
    difference = abs(depth_a - depth_b)
    scale = np.maximum(depth_a.value, depth_b.value)
    if rules.depth_test == "own":
        scale = depth_a.value
    limit = max_depth * scale
    near = Bounded(
        limit - difference.value, difference.error + 2 * unit * limit, angle.rounding
    )
    slack = _least(alike, near)
    seen = (depth_a.value > 0) & (depth_b.value > 0)
    same = (normal_a.value == normal_b.value).all(axis=1) & (difference.value == 0)
    value = np.where(seen, np.where(same & (slack.value >= 0), 1.0, slack.value), -1.0)
    error = np.where(seen & ~same, slack.error, 0.0)
    value = np.where(value == 0, error / 2, value)  # inclusive
    return Bounded(value, error, angle.rounding)


def _least(a: Bounded, b: Bounded) -> Bounded:
    """The smaller; its sign is uncertain unless one is surely negative or both sure."""
    value = np.minimum(a.value, b.value)
    surely_not = a.surely_not_positive | b.surely_not_positive
    unsure = ~surely_not & ~(a.surely_positive & b.surely_positive)
    error = np.where(unsure, np.maximum(a.error, b.error) + np.abs(value), 0.0)
    return Bounded(value, error, a.rounding)


def judge_neighbors(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``neighbors``.

    The radius goes on from the backend's own success or failure; of a table there is
    none.
    """
    rounding, s = rounding_of(precision), case.settings
    found = outputs["neighbors"]
    rows, width = np.arange(case.rows), int(s["width"])
    size = width, case.rows // width
    asked = str(s.get(BORDER.name, BORDER.default))
    is_asked = rules.border == "asked" or asked == REFUSED
    border = BORDERS[asked if is_asked else rules.border]
    of_table = s.get(SEARCH.name) == TABLE
    least = 0.0 if of_table else float(s["min_radius"])
    first = 0.0 if of_table else max(float(s["radius"]) * width, least)
    radius = np.full(case.rows, first)
    wrong, differing, mean = np.zeros(case.rows, bool), 0, 0.0
    expected = np.empty_like(found)
    for k in range(found.shape[1]):
        by_chance: Masks = np.ones(case.rows, bool)
        if of_table:
            offset = case.inputs["offsets"][:, k].astype(np.int64)
            offset = offset @ np.array(TABLES[rules.table])
            options, odds = [_row_at(rows, offset.T, size, border)], np.zeros(case.rows)
        else:
            u = case.inputs["u"][:, k].astype(float)
            options, odds = _landings(rows, size, radius, u, rounding, border)
            by_chance = ~np.any(at_an_end(u), axis=1)
        answers = [alike_to(case, rows, o, rules, rounding) for o in options]
        legal = [
            _is_legal(found[:, k], o, a, rows)
            for o, a in zip(options, answers, strict=True)
        ]
        own = _exact_answer(options[0], answers[0], rows)
        expected[:, k] = own
        is_legal = np.any(legal, axis=0)
        wrong |= ~is_legal
        differing += int((is_legal & by_chance & (found[:, k] != own)).sum())
        mean += float((odds + (answers[0].error > 0))[by_chance].sum())
        missed = (found[:, k] < 0) & ~_is_itself(options, answers, rows)
        if rules.narrows:
            radius = np.where(missed, np.maximum(radius / 2, least), radius)
    compared = Compared(
        "neighbors",
        np.where(wrong[:, None], found, expected),
        expected,
        np.zeros(found.shape),
    )
    terms = {"exact": expected, "radius after the last": radius}
    decisions = Decisions(wrong, differing, mean, "which neighbours were found")
    return Judgement((compared,), terms, decisions, case.random)


def _row_at(
    rows: Indices, offset: Any, size: tuple[int, int], border: Border
) -> Indices:
    """Pixels at whole offsets from others, (N,), −1 outside.

    Parameters
    ----------
    offset : two (N,) arrays; columns and rows
    """
    (dx, dy), (width, height) = offset, size
    x, y = border(rows % width + dx, width), border(rows // width + dy, height)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    found: Indices = np.where(inside, y * width + x, -1).astype(np.int64)
    return found


def _landings(
    rows: Indices,
    size: tuple[int, int],
    radius: Scalars,
    u: Scalars,
    r: Rounding,
    border: Border,
) -> tuple[list[Any], Scalars]:
    """Pixels that an offset may be rounded to, the exact one first, −1 outside.

    Beside them the mean number of decisions that rounding leaves open, for random u.
    """
    reach = radius * np.sqrt(u[:, 0])
    room = (SINE + 4) * r.unit * reach
    dx, dy = reach * np.cos(2 * pi * u[:, 1]), reach * np.sin(2 * pi * u[:, 1])
    options, spread = [], []
    for sx in (0, -1, 1):
        for sy in (0, -1, 1):
            moved = np.rint(dx + sx * room), np.rint(dy + sy * room)
            options.append(_row_at(rows, moved, size, border))
            spread.append(options[-1] != options[0])
    return options, np.minimum(4 * room, 1.0)


def alike_to(
    case: Case, rows: Indices, row_to: Indices, rules: Rules, rounding: Rounding
) -> Bounded:
    """Positive where pixels landed on are similar.

    Parameters
    ----------
    rows, row_to : (N,) int; of the pixels that look, and that are landed on, or −1

    Returns
    -------
    Bounded; (N,), negative outside of the image
    """
    n = exact(case.inputs["visible_normal"], rounding)
    depth = exact(case.inputs["depth"], rounding)
    to = np.maximum(row_to, 0)
    alike = similarity(
        n,
        depth,
        n[to],
        depth[to],
        cos(radians(float(case.settings["max_angle"]))),
        float(case.settings["max_depth"]),
        rules,
    )
    outside = row_to < 0
    return Bounded(
        np.where(outside, -1.0, alike.value),
        np.where(outside, 0.0, alike.error),
        rounding,
    )


def _is_legal(found: Indices, row_to: Indices, alike: Bounded, rows: Indices) -> Masks:
    itself = row_to == rows
    taken = (found == row_to) & (found >= 0) & ~alike.surely_not_positive & ~itself
    none = (found == -1) & (~alike.surely_positive | itself)
    legal: Masks = taken | none
    return legal


def _exact_answer(row_to: Indices, alike: Bounded, rows: Indices) -> Indices:
    return np.where((alike.value > 0) & (row_to != rows), row_to, -1)


def _is_itself(options: list[Indices], answers: list[Bounded], rows: Indices) -> Masks:
    """Whether −1 stands for the pixel itself, which does not narrow the search."""
    itself: Masks = (options[0] == rows) & (answers[0].value > 0)
    return itself
