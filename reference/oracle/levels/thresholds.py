"""Decisions of a backend by their thresholds, whatever its weights and order are.

Which sample is kept, as a function of the numbers u of a row, is constant on boxes: a
decision falls at a threshold of one number, and the threshold may hang on how the other
decisions fell, but on nothing else of their numbers.  So all thresholds of a number
are met on the lines along it on which each other number is nearly 0 or nearly 1.  They
are bisected there, all rows at once, to neighbouring multiples of 2⁻²⁴, which is all
that u can be; the middle of each box is asked, and counts with the box's volume.
Random points tell whether the boxes are boxes.
"""

from collections.abc import Generator
from dataclasses import dataclass
from itertools import product

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.enumeration import LatticeEnumeration
from restir_gi.reference.oracle.levels.expectation import (
    NO_PATCH,
    KeptPatches,
    bias,
    expectations,
    kept_by,
    other_confidence,
)
from restir_gi.reference.oracle.levels.patches import PATCHES
from restir_gi.reference.oracle.levels.probe import Finding

STEPS = 2**24
"""Multiples of 2⁻²⁴ in [0, 1): numbers that u can be."""

FIRST, LAST = 1, STEPS - 1

SAME_THRESHOLD = 4
"""In units of 2⁻²⁴: that of two lines, as each has rounded it."""

CHECKS = 4
"""Random points of each of R outcomes: what is no box in a share v of their volume is
not noticed with probability (1 - v)^4R; R is 80 to 540."""

MOST_ROWS = 20_000
"""Of one call."""

Search = Generator[Case, Buffers, Finding]
"""Asks for the answers to cases, one after the other, and ends with a finding."""

Answers = Generator[Case, Buffers, KeptPatches]


class NoBoxesError(Exception):
    """Decisions are not those of thresholds of single numbers."""


def own_expectation(e: LatticeEnumeration, precision: Precision) -> Search:
    """Integrate a backend's answers over its own decisions.

    Yields
    ------
    Case; whose outputs are to be sent

    Returns
    -------
    Finding
        With the expectation of the backend's own distribution, if it is wrong.  Of a
        backend that is right the error is below the room that is left to it: a
        threshold is known to 1 + `SAME_THRESHOLD` units of 2⁻²⁴ and has itself rounded
        by 8 half units; if one of D thresholds of an outcome moves by d, what is summed
        moves by at most d times the largest W that patch x is kept with.
    """
    try:
        walls = yield from _walls(e, precision)
        boxes = _between(walls)
        values = yield from _answers_in(boxes, e, precision)
    except NoBoxesError:
        return Finding(
            False,
            f"{e.name}: which sample is kept hangs on the random numbers in another way"
            " than by a threshold of each: its expectation is not comparable",
        )
    found = expectations(e, boxes.outcome, boxes.volume, values)
    eps = float(np.finfo(precision).eps)
    moved = e.decisions * ((1 + SAME_THRESHOLD) / STEPS + 8 * eps / 2)
    wrong = bias(e, found, precision, moved * _largest(e, boxes.outcome, values))
    if wrong:
        how = "summed over all outcomes and the backend's own decisions"
        return Finding(False, f"{e.name}: {wrong}; {how}")
    if odd := other_confidence(e, boxes.outcome, values):
        return Finding(False, f"{e.name}: {odd}")
    off = min(
        float((np.abs(found - wanted) / e.solid_angle).max())
        for wanted in (e.expected, e.unbiased)
    )
    return Finding(
        True,
        f"{e.name}: decisions or weights are not the contract's; E[W 1(y = x)], summed"
        " over all outcomes and the backend's own decisions, is what it must be, to"
        f" {off:.2g} of a patch",
    )


def _asked(
    e: LatticeEnumeration, precision: Precision, outcome: Indices, points: Indices
) -> Answers:
    """Ask rows: outcomes, and (L, D) numbers u in units of 2⁻²⁴."""
    parts = []
    for start in range(0, len(outcome), MOST_ROWS):
        here = slice(start, start + MOST_ROWS)
        inputs = given(e.inputs(outcome[here], points[here] / STEPS), precision)
        out = yield Case(f"{e.name}-thresholds", e.pass_name, e.settings, inputs)
        parts.append(kept_by(out, len(outcome[here])))
    return _joined(parts)


def _joined(parts: list[KeptPatches]) -> KeptPatches:
    return KeptPatches(
        np.concatenate([part.patch for part in parts]),
        np.concatenate([part.W for part in parts]),
        np.concatenate([part.M for part in parts]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """Pieces of lines at whose ends a backend answers differently.

    Attributes
    ----------
    outcome, axis : (L,) int; the row, and the number that varies
    point : (L, D) int; a point of the line, in units of 2⁻²⁴
    low, high : (L,) int; ends
    below, above : KeptPatches; answers there
    """

    outcome: Indices
    axis: Indices
    point: Indices
    low: Indices
    high: Indices
    below: KeptPatches
    above: KeptPatches

    def rows(self, which: Masks) -> "_Pieces":
        """Some of them."""
        return _Pieces(
            self.outcome[which],
            self.axis[which],
            self.point[which],
            self.low[which],
            self.high[which],
            self.below.rows(which),
            self.above.rows(which),
        )

    def split(self, middle: Indices, values: KeptPatches) -> "_Pieces":
        """Both halves of each."""
        return _Pieces(
            np.tile(self.outcome, 2),
            np.tile(self.axis, 2),
            np.tile(self.point, (2, 1)),
            np.concatenate([self.low, middle]),
            np.concatenate([middle, self.high]),
            _joined([self.below, values]),
            _joined([values, self.above]),
        )


def _walls(
    e: LatticeEnumeration, precision: Precision
) -> Generator[Case, Buffers, list[Indices]]:
    """Thresholds of each number: (R, most) int each, in units of 2⁻²⁴.

    Each is the least number on its upper side; rows with fewer are filled with `STEPS`.
    """
    pieces = yield from _lines(e, precision)
    lines = len(pieces.outcome)
    ends: list[_Pieces] = []
    while len(pieces.outcome):
        middle = (pieces.low + pieces.high) // 2
        point = pieces.point.copy()
        point[np.arange(len(middle)), pieces.axis] = middle
        values = yield from _asked(e, precision, pieces.outcome, point)
        pieces = pieces.split(middle, values)
        pieces = pieces.rows(pieces.below.differs(pieces.above, precision))
        narrow = pieces.high - pieces.low == 1
        ends.append(pieces.rows(narrow))
        pieces = pieces.rows(~narrow)
        if len(pieces.outcome) > 2 * lines:
            raise NoBoxesError
    return [_of_axis(e, ends, axis) for axis in range(e.decisions)]


def _lines(
    e: LatticeEnumeration, precision: Precision
) -> Generator[Case, Buffers, _Pieces]:
    """All lines between corners of the unit cube, whether their ends differ or not."""
    D, R = e.decisions, len(e.setup)
    corners = np.array(list(product((0, 1), repeat=D)))
    rows = np.repeat(np.arange(R), len(corners))
    points = np.tile(np.where(corners, LAST, FIRST), (R, 1))
    values = yield from _asked(e, precision, rows, points)
    parts = []
    for axis in range(D):
        low = np.flatnonzero(np.tile(corners[:, axis] == 0, R))
        high = low + (1 << (D - 1 - axis))
        count = len(low)
        parts.append(
            _Pieces(
                rows[low],
                np.full(count, axis),
                points[low],
                np.full(count, FIRST),
                np.full(count, LAST),
                values.rows(low),
                values.rows(high),
            )
        )
    return _together(parts)


def _together(parts: list[_Pieces]) -> _Pieces:
    return _Pieces(
        np.concatenate([p.outcome for p in parts]),
        np.concatenate([p.axis for p in parts]),
        np.concatenate([p.point for p in parts]),
        np.concatenate([p.low for p in parts]),
        np.concatenate([p.high for p in parts]),
        _joined([p.below for p in parts]),
        _joined([p.above for p in parts]),
    )


def _of_axis(e: LatticeEnumeration, ends: list[_Pieces], axis: int) -> Indices:
    here = [part.rows(part.axis == axis) for part in ends]
    outcome = np.concatenate([part.outcome for part in here])
    wall = np.concatenate([part.high for part in here])
    order = np.lexsort((wall, outcome))
    outcome, wall = outcome[order], wall[order]
    # The same threshold on several lines is one wall.
    new = np.ones(len(wall), bool)
    new[1:] = (np.diff(outcome) > 0) | (np.diff(wall) > SAME_THRESHOLD)
    outcome, wall = outcome[new], wall[new]
    first = np.searchsorted(outcome, outcome)
    place = np.arange(len(wall)) - first
    found = np.full((len(e.setup), int(place.max(initial=-1)) + 1), STEPS)
    found[outcome, place] = wall
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Boxes:
    """Boxes between the thresholds of each outcome.

    Attributes
    ----------
    edges : list of (R, B + 1) int; ends of the boxes along each axis
    number : (R, boxes) int; of each box of an outcome; -1 where there is none
    outcome : (L,) int; that each box belongs to
    middle : (L, D) int, in units of 2⁻²⁴
    volume : (L,); their sum is 1 for each outcome
    """

    edges: list[Indices]
    number: Indices
    outcome: Indices
    middle: Indices
    volume: Scalars


def _between(walls: list[Indices]) -> _Boxes:
    R = len(walls[0])
    ends = np.zeros((R, 1), int), np.full((R, 1), STEPS)
    edges = [np.concatenate([ends[0], wall, ends[1]], axis=1) for wall in walls]
    shape = [edge.shape[1] - 1 for edge in edges]
    if R * np.prod(shape) > 64 * MOST_ROWS:
        raise NoBoxesError
    corners = np.array(list(product(*map(range, shape))))
    low, high = (
        np.stack([edge[:, k + end] for edge, k in zip(edges, corners.T, strict=True)])
        for end in (0, 1)
    )
    there = (high > low).all(axis=0)
    number = np.where(there, np.cumsum(there).reshape(there.shape) - 1, -1)
    middle = np.maximum((low + high - 1) // 2, FIRST)[:, there].T
    volume = ((high - low) / STEPS).prod(axis=0)[there]
    return _Boxes(edges, number, np.nonzero(there)[0], middle, volume)


def _answers_in(boxes: _Boxes, e: LatticeEnumeration, precision: Precision) -> Answers:
    """Answers in the middle of the boxes, which hold in all of them, as is tried."""
    tried, points, box = _tried(boxes.edges)
    values = yield from _asked(
        e,
        precision,
        np.concatenate([boxes.outcome, tried]),
        np.concatenate([boxes.middle, points]),
    )
    count = len(boxes.outcome)
    inside, checked = values.rows(slice(count)), values.rows(slice(count, None))
    if checked.differs(inside.rows(boxes.number[tried, box]), precision).any():
        raise NoBoxesError
    return inside


def _tried(edges: list[Indices]) -> tuple[Indices, Indices, Indices]:
    """Random points, not within rounding of a wall: outcome, point and box."""
    rng = np.random.default_rng(2026)
    outcome = np.repeat(np.arange(len(edges[0])), CHECKS)
    points = rng.integers(FIRST, STEPS, (len(outcome), len(edges)))
    places, clear = [], np.ones(len(outcome), bool)
    for axis, edge in enumerate(edges):
        here, u = edge[outcome], points[:, axis, None]
        places.append((here[:, 1:-1] <= u).sum(axis=1))
        clear &= (np.abs(here - u) > SAME_THRESHOLD).all(axis=1)
    shape = [edge.shape[1] - 1 for edge in edges]
    box = np.ravel_multi_index(places, shape)
    return outcome[clear], points[clear], box[clear]


def _largest(e: LatticeEnumeration, outcome: Indices, values: KeptPatches) -> Scalars:
    """Mean over outcomes of the largest W that each patch is kept with, (S, 5)."""
    held = values.patch != NO_PATCH
    most = np.zeros((len(e.setup), PATCHES))
    np.maximum.at(most, (outcome[held], values.patch[held]), values.W[held])
    found = np.zeros((len(e.setups), PATCHES))
    np.add.at(found, e.setup, e.probability[:, None] * most)
    return found
