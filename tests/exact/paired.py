"""Pairs of pixels on a domain of a few cells, in fractions: the production code on it.

Four pixels in two pairs look at four cells.  What the code asks of a scene is one
function, the shift of a path from a pixel to another, and that is a table here; inner
and outer shifts, weights, candidates, neighbours and resampling are those of
:mod:`gradient_domain`.

======  =======  =======  =======  =======  ==========================================
cell    pixel 0  pixel 1  pixel 2  pixel 3
======  =======  =======  =======  =======  ==========================================
0       more     less     less     more     signs of the pairs differ
1       red      green    green    red      channels of both signs
2       lit      dark     lit      lit      no inner shift in the first pair
3       dark     lit      dark     dark     no outer shift to the second pair
======  =======  =======  =======  =======  ==========================================
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from restir_gi.gradient_domain.gradient_restir import (
    MINUS,
    PLUS,
    WHOLE,
    PairedPaths,
    PairNeighbor,
    choose_pair,
    contribution,
    estimate,
    inner_shift,
    paired,
)
from restir_gi.gradient_domain.pairs import Pairs
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs
from tests.exact.explore import draw

CELLS = range(4)


def _table(rows):
    return np.array([[[Fraction(v) for v in f] for f in row] for row in rows], object)


F = _table(
    [
        [(5, 3), (4, 1), (3, 2), (0, 0)],
        [(2, 1), (1, 3), (0, 0), (2, 5)],
        [(1, 2), (1, 2), (2, 2), (0, 0)],
        [(4, 3), (3, 1), (6, 1), (0, 0)],
    ]
)
"""f of a pixel and cell, in two channels."""

MU = np.array(
    [
        [Fraction(a, b) for a, b in row]
        for row in (
            [(1, 2), (2, 3), (1, 1), (1, 3)],
            [(3, 4), (1, 2), (2, 1), (1, 1)],
            [(1, 1), (1, 4), (3, 2), (1, 5)],
            [(2, 5), (1, 1), (1, 2), (1, 7)],
        )
    ],
    object,
)
"""Measure of a cell in the space of a pixel's paths."""

PAIRS = Pairs(
    np.array([0, 2]),
    np.array([1, 3]),
    np.zeros(2, np.int8),
    np.ones(2),
    np.zeros(2),
)
A, B = range(2)


@dataclass(frozen=True, slots=True)
class Place:
    """In place of `Placed`: the pixel, and f there."""

    pixel: Any
    value: Any


@dataclass(frozen=True, slots=True)
class Cell:
    """In place of `AreaPaths`."""

    pixel: Any
    cell: Any
    worth: Any

    def __len__(self):
        """Number of rows."""
        return len(self.cell)

    @property
    def value(self):
        """As it is here."""
        return Place(self.pixel, self.worth)

    def moved(self, value, jacobian):
        """The same cells, seen from other pixels."""
        return Cell(value.pixel, self.cell, value.value)


@dataclass(frozen=True)
class TableShift:
    """In place of `AreaShift`: to the same cell, where the other pixel has it."""

    primary: str = "move"
    world_from: None = None
    world_to: None = None

    @property
    def inverse(self):
        """The other way; all pixels are of one image."""
        return self

    def __call__(self, samples, pixel, dx, dy):
        """Value and Jacobian."""
        c = samples.cell
        there = F[pixel, c].any(axis=1) & F[samples.pixel, c].any(axis=1)
        ratio = MU[pixel, c] / MU[samples.pixel, c]
        jacobian = np.where(there, ratio, Fraction(0))
        value = np.where(there[:, None], F[pixel, c], Fraction(0))
        return Place(pixel, value), jacobian


@dataclass(frozen=True)
class OtherPixel(TableShift):
    """To the other pixel of the pair, where rows are outcomes in place of pixels."""

    def __call__(self, samples, pixel, dx, dy):
        """Value and Jacobian."""
        p = samples.pixel // 2
        other = PAIRS.first[p] + PAIRS.second[p] - samples.pixel
        return super().__call__(samples, other, dx, dy)


WITHIN = TableShift()


def target(value):
    """Sum of the channels' magnitudes: luminance has no rational weights."""
    found = np.abs(contribution(value))
    return found[:, 0] + found[:, 1]


def of_pair(p, size):
    """A pair, for many outcomes."""
    return Pairs(*(np.full(size, getattr(PAIRS, name)[p]) for name in Pairs.__slots__))


def samples(p, k, cell, sign):
    """What a pair keeps, by k and cell: offset paths and Jacobians are made anew."""
    size, pairs = len(cell), of_pair(p, len(cell))
    pixel = np.where(k == 0, pairs.first, pairs.second)
    base = Cell(pixel, cell, F[pixel, cell])
    signs = np.full(size, sign, np.int8)
    return PairedPaths(k, base, *inner_shift(WITHIN, base, k, pairs), signs)


@dataclass(frozen=True, slots=True)
class KeptPair:
    """What a pair keeps for a sign: columns that can be told apart."""

    k: Any
    cell: Any
    W: Any
    M: Any

    def opened(self, p, sign):
        """As reservoirs of pairs."""
        return Reservoirs(samples(p, self.k, self.cell, sign), self.W, self.M)


def closed(p, r):
    """Columns of reservoirs; what they know of their samples must be true here."""
    full = r.W > 0
    again = samples(p, r.y.k, r.y.base.cell, WHOLE)
    assert (r.y.offset == again.offset)[full].all()
    assert (r.y.inner == again.inner)[full].all()
    assert (r.y.base.worth == again.base.worth)[full].all()
    # An empty reservoir's sample is nobody's business.
    k, cell = np.where(full, r.y.k, 0), np.where(full, r.y.base.cell, 0)
    return KeptPair(k, cell, r.W, r.M * Fraction(1))


SIGNS = (PLUS, MINUS)


def drawn(pixel, uniform):
    """A cell of a pixel, evenly among those that it has; W is measure over density."""
    able = np.flatnonzero(F[pixel].any(axis=1))
    share = Fraction(1, len(able))
    cell = able[draw(uniform(), [share] * (len(able) - 1))]
    y = Cell(np.full(len(cell), pixel), cell, F[pixel, cell])
    W = MU[pixel, cell] / share
    return Reservoirs(y, W, np.full(len(cell), Fraction(1), object))


def both_of(p, uniform):
    """New samples of a pair: k = 0 and 1."""
    pixels = PAIRS.first[p], PAIRS.second[p]
    new = [drawn(pixel, uniform) for pixel in pixels]
    size = len(new[0].W)
    # Rows of an outcome are its pixels' only ones.
    here = Pairs(np.arange(size), np.arange(size), *_rest(p, size))
    moved = []
    for k, paths in enumerate(new):
        moved.append(paired(OtherPixel(), paths, here, k, slice(0, size)))
    return moved


def _rest(p, size):
    some = of_pair(p, size)
    return some.axis, some.dx, some.dy


def fresh(p, uniform, signs=SIGNS):
    """What a pair keeps of its new samples."""
    both = both_of(p, uniform)
    return [choose_pair(both, sign, uniform(), target) for sign in signs]


def neighbor(p, p_from, r, sign, sign_from, same_domain=False):
    """A pair that is a source of samples to a pair, outcome by outcome."""
    size = len(r.W)
    return PairNeighbor(
        shift=WITHIN,
        pairs=of_pair(p, size),
        pairs_from=of_pair(p_from, size),
        reservoirs=r,
        rows=np.arange(size),
        dx=np.zeros(size),
        dy=np.zeros(size),
        sign=sign,
        sign_from=sign_from,
        same_domain=same_domain,
    )


def merged(neighbors, uniform, mis, cap=9999):
    """One pass over neighbours."""
    numbers = [uniform() for _ in neighbors]
    return resample(neighbors, numbers, mis, cap, target)


def with_trust(r, M):
    """Confidence is trust: any constants must do."""
    return replace(r, M=np.full(len(r.W), Fraction(M), object))


def measured(law, p, sign, kept):
    """E[W 1{y = (x, k)}] for each k and cell that the sign's target has."""
    weighted = law.probability * kept.W
    found, expected = [], []
    for k in (0, 1):
        for cell in CELLS:
            s = samples(p, np.array([k]), np.array([cell]), sign)
            has = bool(F[s.base.pixel[0], cell].any()) and target(s.value)[0] > 0
            at = (kept.k == k) & (kept.cell == cell)
            found.append(sum(weighted[at], Fraction(0)))
            pixel = s.base.pixel[0]
            expected.append(MU[pixel, cell] if has else Fraction(0))
    return found, expected


def difference(p):
    """Δ of a pair, from its definition."""
    i, j = PAIRS.first[p], PAIRS.second[p]
    return sum(MU[i, c] * F[i, c] - MU[j, c] * F[j, c] for c in CELLS)


def expected_difference(law, p, parts):
    """E of what reservoirs say of it."""
    terms = estimate(parts)
    return sum(law.probability[:, None] * terms)
