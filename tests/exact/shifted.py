"""The engine `reference.resampling.generalized` itself, on the toy domain.

It has the passes of :mod:`tests.exact.pipeline`, so that the same claims are proved of
it.  Donors read shifts, targets and visibility from tables of fractions; what becomes
of their answers is the production code's, unchanged.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from reference.resampling.generalized import resample
from reference.resampling.reservoir import Reservoirs
from tests.exact import pipeline
from tests.exact.pipeline import HELD, P_HAT, SEEN, jacobian

trust = pipeline.trust


@dataclass(frozen=True, slots=True)
class Toy:
    """A cell, and its target where it is, (N, 1)."""

    cell: Any
    value: Any

    def moved(self, value, jacobian):
        """The same cells, as another pixel sees them."""
        return replace(self, value=value)


def target(value):
    """The only column."""
    return value[:, 0]


@dataclass(frozen=True, slots=True)
class Tables:
    """Of all pixels: targets, and a function of shifts."""

    p_hat: Any
    seen: Any
    held: Any
    jacobian: Any

    def worth(self, i_from, i_to, cell, usable):
        """Value and Jacobian at a pixel; nothing where it is not usable."""
        value = np.where(usable, self.p_hat[i_to][cell], Fraction(0))[:, None]
        ratio = self.jacobian(i_from, i_to, cell)
        return value, np.where(usable, ratio, Fraction(0))


@dataclass(frozen=True, slots=True)
class ToyDonor:
    """Pixel j of the toy domain, offered to pixel i; ``part`` limits what it makes."""

    tables: Tables
    i: int
    j: int
    reservoirs: Any
    rows: Any
    limit: Any = float("inf")
    part: Any = None
    same_domain: bool = False

    def shifted(self, at):
        """Of its own samples; refused are the unseen, and shifts beyond the limit."""
        cell = self.reservoirs.y.cell[self.rows[at]]
        ratio = self.tables.jacobian(self.j, self.i, cell)
        usable = self.tables.seen[self.i][cell] & (ratio <= self.limit)
        return self.tables.worth(self.j, self.i, cell, usable & self._parted(cell))

    def inverse(self, samples, at):
        """Of others' samples; refused is what it could not have made, or lent."""
        cell = samples.cell[at]
        ratio = self.tables.jacobian(self.j, self.i, cell)
        usable = self.tables.held[self.j][cell] & (ratio <= self.limit)
        return self.tables.worth(self.i, self.j, cell, usable & self._parted(cell))

    def _parted(self, cell):
        return True if self.part is None else np.isin(cell, self.part)


def toys(p_hat, j, r):
    """Reservoirs of pixel j, with targets in their samples."""
    return Reservoirs(Toy(r.y, p_hat[j][r.y][:, None]), r.W, r.M)


def tables(code):
    """Of the toy domain, with the Jacobian of the code."""
    return Tables(P_HAT, SEEN, HELD, lambda a, b, x: jacobian(code, a, b, x))


def initial(code, i, uniform):
    """One new candidate; M is a fraction too, since 0 / 1 of integers would be none."""
    c = pipeline.initial(code, i, uniform)
    return replace(c, M=c.M * Fraction(1))


def temporal(code, i, history, new, cap, uniform):
    """The past of the same pixel, and a new candidate: both of one domain."""
    k = code.reservoir
    fresh = k.finalize(new, new.M)
    pairs = [(i, fresh)] if history is None else [(i, history), (i, fresh)]
    return _resampled(code, i, pairs, uniform, "1/Z", cap, lambda slot, j: True)


def spatial(
    code, i, donors, uniform, mis="1/Z", limit=float("inf"), cap=9999, parts=None
):
    """Donors are pairs (pixel, Reservoirs), the pixel's own first."""

    def same_domain(slot, j):
        return j == i

    return _resampled(code, i, donors, uniform, mis, cap, same_domain, limit, parts)


def _resampled(
    code, i, pairs, uniform, mis, cap, same_domain, limit=float("inf"), parts=None
):
    found = []
    for slot, (j, r) in enumerate(pairs):
        everyone = np.arange(len(r.W))
        part = parts[slot] if parts else None
        shown = toys(P_HAT, j, r)
        donor = ToyDonor(tables(code), i, j, shown, everyone, limit, part)
        found.append(replace(donor, same_domain=same_domain(slot, j)))
    decisions = [uniform() for _ in pairs]
    kept = resample(found, decisions, mis, cap, target)
    cell, full = kept.y.cell, kept.W > 0
    # What is kept is worth what it is worth here, not where it came from.
    assert (target(kept.y.value) == P_HAT[i][cell])[full].all()
    return Reservoirs(cell, kept.W, kept.M)
