"""Pixels that a backend finds beside those that it should: where it rounds otherwise.

A place in the image is rounded to a pixel, which is taken or not.  How far the pixels
that a backend takes lie from the exact places, over all of its rows, says how it
rounds, turns or scales them.  A replay then says whether that explains every row.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import pi

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.passes import BORDER, SEARCH
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE
from restir_gi.reference.oracle.diagnosis.naming.misreadings import Misread
from restir_gi.reference.oracle.diagnosis.naming.monomials import CONSTANTS, number
from restir_gi.reference.oracle.diagnosis.subsets import AskedRows, judged
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.further.camera import depth_of, eye_of, seen_at
from restir_gi.reference.oracle.replay.further.places import alike_at
from restir_gi.reference.oracle.replay.further.rules import FurtherRules
from restir_gi.reference.oracle.replay.neighbors import alike_to
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

Places = NDArray[np.float64]

FEW = 20
"""Pixels in wrong rows, from which nothing is told."""

NEAR, OPEN = 1e-3, 0.002
"""Pixels from where a place is rounded otherwise, and either will do; and the share of
right rows that rounding may still leave open."""


def _inside(at: Places, width: int, height: int) -> Masks:
    found: Masks = np.all((at >= 0) & (at < [width, height]), axis=1)
    return found


Outside = Callable[[Places, Masks, int, int], Places]


def _held(at: Places, width: int, height: int) -> Places:
    return np.stack([at[:, 0].clip(0, width - 1), at[:, 1].clip(0, height - 1)], axis=1)


OUTSIDE: Mapping[str, Outside] = {
    "": lambda at, inside, w, h: at,
    "pixels beyond the border were those on it": lambda at, inside, w, h: np.where(
        inside[:, None], _held(at, w, h), -1.0
    ),
    "places outside were those on the border": lambda at, inside, w, h: _held(at, w, h),
    "lines went on into the next": lambda at, inside, w, h: np.stack(
        [at[:, 0] % w, at[:, 1] + at[:, 0] // w], axis=1
    ),
    "the image went on around its borders": lambda at, inside, w, h: at % [w, h],
}
"""What becomes of pixels outside of the image: from those, and from whether the exact
places are inside.  Those that are still outside are none."""


@dataclass(frozen=True, slots=True)
class Landing:
    """How places become pixels; by the contract, they are rounded to the nearest.

    Attributes
    ----------
    turned : (float, float), (float, float); matrix that offsets are multiplied by
    shift : float, float; pixels that are added before a place is rounded
    toward_zero : bool; offsets are rounded toward 0
    outside : str; what becomes of pixels outside, a key of `OUTSIDE`
    narrowing : float; factor on the radius after a failure
    least : bool; the radius does not fall below its least
    """

    turned: tuple[tuple[float, float], ...] = ((1.0, 0.0), (0.0, 1.0))
    shift: tuple[float, float] = (0.0, 0.0)
    toward_zero: bool = False
    outside: str = ""
    narrowing: float = 0.5
    least: bool = True

    def rows(
        self, start: Places, offset: Places, width: int, height: int
    ) -> tuple[Indices, Masks]:
        """Rows of pixels.

        Parameters
        ----------
        start, offset : (N, 2) float64, pixels; places are start + offset

        Returns
        -------
        (N,) int; −1 outside
        (N,) bool; whether rounding may take them elsewhere
        """
        moved: Places = offset @ np.array(self.turned).T
        place = moved if self.toward_zero else start + moved + self.shift
        at = start + np.trunc(place) if self.toward_zero else self._whole(place)
        edge = np.abs(place - np.rint(place))
        edge = edge if self.toward_zero else 0.5 - edge
        inside = _inside(start + offset + 0.5, width, height)
        at = OUTSIDE[self.outside](at, inside, width, height)
        there = _inside(at, width, height)
        row = np.where(there, at[:, 1] * width + at[:, 0], -1).astype(np.int64)
        near: Masks = np.any(edge < NEAR, axis=1)
        return row, near

    def _whole(self, place: Places) -> Places:
        """Nearest pixels; of two, that which the exact place is nearer to."""
        up, down = np.ceil(place - 0.5), np.floor(place + 0.5)
        sign = np.sign(self.shift)
        return np.select([sign < 0, sign > 0], [down, up], np.rint(place))


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """What a backend found in a case: N rows, each with K places to find.

    Attributes
    ----------
    start : (N, 2) float64, pixels; that places are counted from
    asked : (N,) bool; rows that have a place at all
    found : (N, K) int; rows of pixels, or −1
    offsets : callable; from k and the radius, (N,), to (N, 2), pixels
    alike : callable; from rows of pixels, (N,), to what is above 0 where they are taken
    """

    case: Case
    right: Masks
    start: Places
    asked: Masks
    found: Indices
    radius: Scalars
    least: float
    offsets: Callable[[int, Scalars], Places]
    alike: Callable[[Indices], Bounded]

    @property
    def size(self) -> tuple[int, int]:
        width = int(self.case.settings["width"])
        return width, int(self.case.settings.get("height", self.case.rows // width))

    def explained(self, landing: Landing) -> Masks:
        """Whether rows are as they would be by another landing, (N,) bool."""
        itself = np.arange(self.case.rows)
        legal, radius = np.ones(self.case.rows, bool), self.radius
        for k in range(self.found.shape[1]):
            row, near = landing.rows(self.start, self.offsets(k, radius), *self.size)
            row = np.where(self.asked, row, -1)
            found, alike = self.found[:, k], self.alike(row)
            own = (row == itself) & self.searches
            taken = (found == row) & (row >= 0) & ~alike.surely_not_positive & ~own
            none = (found == -1) & (~alike.surely_positive | (row < 0) | own)
            legal &= taken | none | near
            missed = (found < 0) & ~(own & (alike.value > 0))
            narrow = radius * landing.narrowing
            narrow = np.maximum(narrow, self.least) if landing.least else narrow
            radius = np.where(missed, narrow, radius)
        return legal

    @property
    def searches(self) -> bool:
        """Whether the pixel itself is no answer."""
        return self.case.pass_name == "neighbors"


def misplaced(given: Sequence[AskedRows], precision: Precision) -> Misread | None:
    """How places are rounded, if that explains nearly all wrong rows.

    Parameters
    ----------
    given : sequence of AskedRows; all that a backend answered of a pass
    """
    name = given[0].case.pass_name
    # Of a table, and of a border that is not refused, the names have to do.
    given = [a for a in given if not {SEARCH.name, BORDER.name} & {*a.case.settings}]
    if name not in FOUND or not given:
        return None
    cases = [FOUND[name](asked, precision) for asked in given]
    of = sum(int((~one.right).sum()) for one in cases)
    best, text = 0, ""
    for said, landing in _landings(cases, name):
        legal = [one.explained(landing) for one in cases]
        pairs = list(zip(cases, legal, strict=True))
        broken = sum(int((one.right & ~ok).sum()) for one, ok in pairs)
        rows = sum(int((~one.right & ok).sum()) for one, ok in pairs)
        few = OPEN * sum(int(one.right.sum()) for one in cases)
        if broken <= few and rows > best:
            best, text = rows, said
    return Misread(text, best, of) if best and best >= SHARE * of else None


# ---------------------------------------------------------------- what was found


def _neighbors(asked: AskedRows, precision: Precision) -> _Found:
    case, rounding = asked.case, rounding_of(precision)
    width, row = int(case.settings["width"]), np.arange(case.rows)
    least = float(case.settings["min_radius"])
    first = max(float(case.settings["radius"]) * width, least)
    u = case.inputs["u"].astype(np.float64)

    def offsets(k: int, radius: Scalars) -> Places:
        angle = 2 * pi * u[:, k, 1]
        way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        found: Places = way * (radius * np.sqrt(u[:, k, 0]))[:, None]
        return found

    return _Found(
        case=case,
        right=judged(asked, CONTRACT_RULES, precision)[1] | ~asked.rows,
        start=np.stack([row % width, row // width], axis=1).astype(np.float64),
        asked=np.ones(case.rows, bool),
        found=asked.outputs["neighbors"].astype(np.int64),
        radius=np.full(case.rows, first),
        least=least,
        offsets=offsets,
        alike=lambda to: alike_to(case, row, to, CONTRACT_RULES, rounding),
    )


def _reprojected(asked: AskedRows, precision: Precision) -> _Found:
    """Places are counted so that their pixel is the nearest whole number."""
    case, rounding = asked.case, rounding_of(precision)
    rules = FurtherRules()
    eye = eye_of(case.settings, rounding, rules)
    position = exact(case.inputs["position"], rounding)
    x, y, along = seen_at(eye, position)
    depth = depth_of(eye, position, rules)
    place = np.nan_to_num(np.stack([x.value, y.value], axis=1), posinf=-9, neginf=-9)
    return _Found(
        case=case,
        right=judged(asked, CONTRACT_RULES, precision)[1] | ~asked.rows,
        start=np.full((case.rows, 2), -0.5),
        asked=(case.inputs["hit"] == 1) & (along.value > 0),
        found=asked.outputs["row"].astype(np.int64)[:, None],
        radius=np.ones(case.rows),
        least=1.0,
        offsets=lambda k, radius: place,
        alike=lambda to: alike_at(case, to, depth, CONTRACT_RULES),
    )


FOUND: Mapping[str, Callable[[AskedRows, Precision], _Found]] = {
    "neighbors": _neighbors,
    "reproject": _reprojected,
}
ROUNDED: Mapping[str, Mapping[float, str]] = {
    "neighbors": {
        -0.5: "offsets were rounded down, not to the nearest",
        0.5: "offsets were rounded up, not to the nearest",
    },
    "reproject": {
        0.5: "places were rounded to the nearest, not down",
        1.0: "places were rounded up, not down",
    },
}
"""What it means where pixels lie aside of the right ones, in both directions alike."""


# ------------------------------------------------------------ what it may have been


def _landings(cases: list[_Found], name: str) -> Iterator[tuple[str, Landing]]:
    """What the pixels that were taken say of how they were found."""
    exact_offsets, taken = (
        np.concatenate(parts)
        for parts in zip(*(_taken(one) for one in cases), strict=True)
    )
    ways = [("", Landing())]
    if len(taken) >= FEW:
        ways += _ways(exact_offsets, taken, name)
    narrowing = [("", 0.5, True), ("the radius fell below its least", 0.5, False)]
    factor = _after_a_failure(cases)
    if factor not in (None, 0.5):
        said = f"the radius were {number(factor)} of what it was after a failure"
        narrowing += [(said, factor, True), (f"{said}, however small", factor, False)]
    for (a, way), outside, (c, factor, least) in product(ways, OUTSIDE, narrowing):
        said = " and ".join(text for text in (a, outside, c) if text)
        if said:
            yield (
                said,
                replace(way, outside=outside, narrowing=factor, least=least),
            )


def _taken(one: _Found) -> tuple[Places, Places]:
    """Exact offsets and those that were taken, in wrong rows before any failure."""
    offsets, taken = [np.zeros((0, 2))], [np.zeros((0, 2))]
    so_far = ~one.right & one.asked
    for k in range(one.found.shape[1]):
        so_far = so_far & (one.found[:, k] >= 0)
        y, x = np.divmod(one.found[so_far, k], one.size[0])
        offsets.append(one.offsets(k, one.radius)[so_far])
        taken.append(np.stack([x, y], axis=1) - one.start[so_far])
    return np.concatenate(offsets), np.concatenate(taken)


def _ways(offsets: Places, taken: Places, name: str) -> list[tuple[str, Landing]]:
    found = []
    beside = taken - offsets
    shift = np.round(2 * np.median(beside, axis=0)) / 2
    if shift.any():
        x, y = (float(s) for s in shift)
        text = ROUNDED[name].get(x) if x == y else None
        text = text or f"pixels lay {x:+g} aside in x and {y:+g} in y"
        found.append((text, Landing(shift=(x, y))))
    toward_zero = bool(np.median(np.sign(offsets) * beside) < -0.25)
    # What a pixel is rounded toward is itself; a place in the image has no such pixel.
    if toward_zero and name == "neighbors":
        text = "offsets were rounded toward 0, not to the nearest"
        found.append((text, Landing(toward_zero=True)))
    matrix = np.linalg.lstsq(offsets, taken, rcond=None)[0].T
    snapped = [[_snapped(float(v)) for v in line] for line in matrix]
    if snapped != [[1.0, 0.0], [0.0, 1.0]]:
        (a, b), (c, d) = snapped
        text = f"offsets (dx, dy) were ({_sum(a, b)}, {_sum(c, d)})"
        found.append((text, Landing(turned=((a, b), (c, d)))))
    return found


def _sum(x: float, y: float) -> str:
    terms = {"dx": x, "dy": y}
    return " + ".join(f"{v:.4g} {name}" for name, v in terms.items() if v) or "0"


def _snapped(value: float) -> float:
    """A number by its name, if it is near one that has any."""
    if abs(value) < 0.05:
        return 0.0
    near = min(CONSTANTS.values(), key=lambda c: abs(c - abs(value)))
    return float(np.sign(value)) * near if abs(near / abs(value) - 1) < 0.02 else value


def _after_a_failure(cases: list[_Found]) -> float | None:
    """By which factor offsets are smaller after one failure; from wrong rows."""
    ratios = []
    for one in cases:
        failed = np.zeros(one.case.rows, int)
        for k in range(one.found.shape[1]):
            y, x = np.divmod(one.found[:, k], one.size[0])
            first = one.offsets(k, one.radius)
            length = np.hypot(*first.T)
            sure = ~one.right & (failed == 1) & (one.found[:, k] >= 0) & (length > 4)
            taken = np.stack([x, y], axis=1) - one.start
            ratios.append((np.hypot(*taken.T) / np.maximum(length, 1))[sure])
            failed += one.found[:, k] < 0
    every = np.concatenate(ratios) if ratios else np.zeros(0)
    return _snapped(float(np.median(every))) if len(every) >= FEW else None
