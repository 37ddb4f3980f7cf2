"""Replay of pairs of pixels: edges, the search along them, and their motion."""

from dataclasses import dataclass

import numpy as np

from restir_gi.gradient_domain.oracle.contract import EITHER_SIDE, GIVEN
from restir_gi.gradient_domain.oracle.rules import PairRules, pairing
from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.further.numbers import Choice
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement, exactly
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import inner


@dataclass(frozen=True, slots=True)
class PixelLikeness:
    """By how much pixels may differ that look alike.

    Attributes
    ----------
    albedo : float; in each channel, at most
    cosine : float; of their normals, at least
    depth : float; at most, as a part of the larger one
    either_side : bool; the cosine is its magnitude
    """

    albedo: float = 0.1
    cosine: float = 0.9
    depth: float = 0.1
    either_side: bool = False


def likeness_in(case: Case) -> PixelLikeness:
    """What a case asks for."""
    asked, either = case.settings, case.settings.get("normals") == EITHER_SIDE
    if asked.get("thresholds") != GIVEN:
        return PixelLikeness(either_side=either)
    albedo, cosine, depth = (
        float(asked[name]) for name in ("most_albedo", "least_cosine", "most_depth")
    )
    return PixelLikeness(albedo, cosine, depth, either)


@dataclass(frozen=True, slots=True, eq=False)
class SeenPixels:
    """What pixels see, N rows.

    Attributes
    ----------
    albedo, normal : (N, 3) Bounded
    depth : (N,) Bounded
    hit : (N,) bool; whether there is a point
    """

    albedo: Bounded
    normal: Bounded
    depth: Bounded
    hit: Masks

    def at(self, rows: Indices) -> "SeenPixels":
        """Some of them.

        Parameters
        ----------
        rows : (K,) int
        """
        return SeenPixels(
            self.albedo[rows], self.normal[rows], self.depth[rows], self.hit[rows]
        )


def seen_in(inputs: Buffers, rounding: Rounding, suffix: str = "") -> SeenPixels:
    """Pixels among the buffers of a case."""
    albedo, normal, depth = (
        exact(inputs[f"{name}{suffix}"], rounding)
        for name in ("albedo", "normal", "depth")
    )
    return SeenPixels(albedo, normal, depth, inputs[f"hit{suffix}"] == 1)


def differing_pixels(
    a: SeenPixels, b: SeenPixels, rules: PairRules, like: PixelLikeness
) -> Choice:
    """Whether pixels look unlike."""
    tests = [
        *_albedos(a, b, rules, like),
        *_normals(a, b, rules, like),
        *_depths(a, b, rules, like),
    ]
    yes = np.array([test.surely_positive for test in tests])
    no = np.array([test.surely_not_positive for test in tests])
    own = np.array([test.value > 0 for test in tests])
    if rules.every:
        found, certain = own.all(axis=0), yes.all(axis=0) | no.any(axis=0)
    else:
        found, certain = own.any(axis=0), yes.any(axis=0) | no.all(axis=0)
    both, alone = a.hit & b.hit, a.hit ^ b.hit
    return Choice(found & both | alone & rules.lone_hit, certain | ~both)


def _albedos(
    a: SeenPixels, b: SeenPixels, rules: PairRules, like: PixelLikeness
) -> list[Bounded]:
    apart = a.albedo - b.albedo
    if rules.albedos == "ignored":
        return []
    if rules.albedos == "luminance":
        Y = abs(luminance(apart))
        return [Y - constant(like.albedo, Y)]
    apart = apart if rules.albedos == "signed" else abs(apart)
    return [apart[:, c] - constant(like.albedo, apart[:, c]) for c in range(3)]


def _normals(
    a: SeenPixels, b: SeenPixels, rules: PairRules, like: PixelLikeness
) -> list[Bounded]:
    cosine = inner(a.normal, b.normal)
    cosine = abs(cosine) if like.either_side else cosine
    least = constant(like.cosine, cosine)
    return {
        "below": [least - cosine],
        "above": [cosine - least],
        "absolute": [least - abs(cosine)],
        "ignored": [],
    }[rules.normals]


def _depths(
    a: SeenPixels, b: SeenPixels, rules: PairRules, like: PixelLikeness
) -> list[Bounded]:
    apart, share = abs(a.depth - b.depth), constant(like.depth, a.depth)
    larger = np.maximum(a.depth.value, b.depth.value)
    most = Bounded(larger, np.zeros_like(larger), a.depth.rounding)
    return {
        "larger": [apart - share * most],
        "first": [apart - share * a.depth],
        "second": [apart - share * b.depth],
        "absolute": [apart - share],
        "ignored": [],
    }[rules.depths]


def judge_edge_pair(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``edge_pair``."""
    rounding = rounding_of(precision)
    a, b = (seen_in(case.inputs, rounding, s) for s in ("_a", "_b"))
    edge = differing_pixels(a, b, pairing(rules), likeness_in(case))
    allowed = np.where(edge.certain, 0.0, 1.0)
    compared = Compared("edge", outputs["edge"], edge.own.astype(float), allowed)
    return Judgement((compared,), {"open": (~edge.certain).astype(float)})


# ------------------------------------------------ search

FARTHEST = 2**15
"""Columns and lines, beyond which nobody looks for a pair."""


@dataclass(frozen=True, slots=True, eq=False)
class _Image:
    """Pixels of an image, and which of its pairs are edges, by axis and first pixel."""

    seen: SeenPixels
    width: int
    height: int
    rules: PairRules
    like: PixelLikeness
    edges: tuple[Choice, Choice]

    def second(self, first: Indices, axis: int) -> Indices:
        """The other pixel; one of the image, whether there is one or not."""
        step = self.width if axis else 1
        return np.minimum(first + step, len(self.seen.hit) - 1)

    def has_pair(self, x: Indices, y: Indices, axis: int) -> Masks:
        """Whether a pair begins at a place."""
        columns, lines = self.width - (axis == 0), self.height - (axis == 1)
        found: Masks = (x >= 0) & (y >= 0) & (x < columns) & (y < lines)
        return found


def _image_of(case: Case, rules: PairRules, rounding: Rounding) -> _Image:
    seen, width = seen_in(case.inputs, rounding), int(case.settings["width"])
    height, pixel = case.rows // width, np.arange(case.rows)
    like, edges = likeness_in(case), []
    for step in (1, width):
        other = np.minimum(pixel + step, case.rows - 1)
        edges.append(differing_pixels(seen, seen.at(other), rules, like))
    return _Image(seen, width, height, rules, like, (edges[0], edges[1]))


def judge_pair_search(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_search``.

    Pairs of whose search rounding leaves open a place, an edge or a likeness before the
    first sure find are not looked at.
    """
    rounding, part = rounding_of(precision), pairing(rules)
    image = _image_of(case, part, rounding)
    radius = int(min(float(case.settings["radius"]), FARTHEST))
    expected, unsure = [], []
    for axis in (0, 1):
        u = exact(case.inputs["u"][:, axis], rounding)
        found, is_open = _searched(image, axis, u, radius)
        expected.append(found)
        unsure.append(is_open)
    allowed = np.where(np.stack(unsure, axis=1), np.inf, 0.0)
    wanted = np.stack(expected, axis=1).astype(float)
    compared = Compared("neighbor", outputs["neighbor"], wanted, allowed)
    return Judgement((compared,), {"open": np.isinf(allowed).any(axis=1).astype(float)})


def _searched(
    image: _Image, axis: int, u: Bounded, radius: int
) -> tuple[Indices, Masks]:
    """First pixels of what pairs of an axis find, and where rounding leaves it open."""
    rules, size = image.rules, len(image.seen.hit)
    first = np.arange(size)
    x, y = first % image.width, first // image.width
    exists, edge = image.has_pair(x, y, axis), image.edges[axis]
    looks = exists & (edge.own | rules.interior)
    unsure = exists & ~edge.certain & (not rules.interior)
    found = np.full(size, -1)
    for t in range(u.value.shape[1]):
        to_x, to_y, place_is_open = _place(x, y, u[:, t], radius, rules)
        if rules.border == "clamped":
            last = image.width - 1 - (axis == 0), image.height - 1 - (axis == 1)
            to_x, to_y = np.clip(to_x, 0, last[0]), np.clip(to_y, 0, last[1])
        onto = 1 - axis if rules.other_axis else axis
        inside = image.has_pair(to_x, to_y, onto)
        to = np.where(inside, to_y * image.width + to_x, 0)
        alike = _alike(image, first, to, axis, onto)
        usable = inside & ((to != first) | rules.itself)
        if rules.edges_alone:
            there = image.edges[onto]
            own = alike.own & there.own[to]
            no = alike.certain & ~alike.own | there.certain[to] & ~there.own[to]
            alike = Choice(own, alike.certain & there.certain[to] | no)
        searching = looks & (found < 0) if rules.taken == "first" else looks
        unsure |= searching & (place_is_open | usable & ~alike.certain)
        found = np.where(searching & usable & alike.own, to, found)
    return found, unsure


def _place(
    x: Indices, y: Indices, u: Bounded, radius: int, rules: PairRules
) -> tuple[Indices, Indices, Masks]:
    """Column and line of a try, and whether rounding may move it to the next."""
    side = 2 * radius + 1
    at = u * constant(float(side * side), u)
    place = np.floor(at.value).astype(np.int64)
    # A product that is rounded up may reach the next whole number.
    is_open = (at.value - at.error < place) | (at.value + at.error >= place + 1)
    is_open &= u.value > 0
    column, line = place % side, place // side
    if rules.square == "columns":
        column, line = line, column
    return x + column - radius, y + line - radius, is_open


def _alike(image: _Image, first: Indices, to: Indices, axis: int, onto: int) -> Choice:
    """Whether pairs look alike, pixel by pixel."""
    seen, rules = image.seen, image.rules
    own = [seen.at(first), seen.at(image.second(first, axis))]
    other = [seen.at(to), seen.at(image.second(to, onto))]
    if rules.compared == "crossed":
        other = other[::-1]
    apart = [
        differing_pixels(a, b, rules, image.like)
        for a, b in zip(own, other, strict=True)
    ]
    if rules.compared in ("first", "second"):
        apart = apart[:1] if rules.compared == "first" else apart[1:]
    unlike = np.array([c.own for c in apart])
    certain = np.array([c.certain for c in apart])
    everywhere: Masks = np.all(certain, axis=0)
    if rules.compared == "any":
        some: Masks = ~np.all(unlike, axis=0)
        return Choice(some, everywhere)
    refuted: Masks = certain & unlike
    sure_no: Masks = np.any(refuted, axis=0)
    both: Masks = ~np.any(unlike, axis=0)
    return Choice(both, everywhere | sure_no)


# ------------------------------------------------ motion


def judge_pair_motion(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_motion``: depths are compared, and nothing is rounded."""
    part, given = pairing(rules), case.inputs
    depth = [given[f"depth_{which}"].astype(float) for which in ("first", "second")]
    if part.pivot != "depth alone":
        depth = [
            np.where(given[f"hit_{which}"] == 1, d, np.inf)
            for which, d in zip(("first", "second"), depth, strict=True)
        ]
    second = {
        "farther": depth[1] > depth[0],
        "first": np.zeros(case.rows, bool),
        "either": depth[1] <= depth[0],
    }.get(part.pivot, depth[1] < depth[0])
    before = np.where(second, given["before_second"], given["before_first"])
    width, height = (int(case.settings[name]) for name in ("width", "height"))
    x, y = before % width, before // width
    down = given["axis"] == 1
    along = ~down if part.stepped_across else down
    back = second if part.stepped else np.zeros_like(second)
    x, y = x - (back & ~along), y - (back & along)
    columns, lines = (
        np.where(down, width, width - 1),
        np.where(down, height - 1, height),
    )
    inside = (before >= 0) & (x >= 0) & (y >= 0)
    if part.border == "lost":
        inside &= (x < columns) & (y < lines)
    row = np.where(inside, y * width + x, -1)
    return Judgement((exactly("row", outputs["row"], row),))
