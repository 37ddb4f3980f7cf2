"""The one general engine alone, on tables of fractions.

Sources read shifts, targets and visibility from tables, those of the toy domain or any
others; what becomes of their answers is the engine's, unchanged.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from restir_gi.reference.options.weights import resample_weighted
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.resampling.shift import reconnection_jacobian
from tests.exact.domain import CELL, EYE, HOLDS, NORMAL, NOTHING
from tests.exact.pages import NOW, Kept, with_nothing


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
class SourceTables:
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

    tables: SourceTables
    i: int
    j: int
    reservoirs: Any
    rows: Any
    limit: Any = float("inf")
    part: Any = None
    same_domain: bool = False

    def unshifted(self, at):
        """Of its own samples, at home."""
        return self.reservoirs.y.value[self.rows[at]]

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


def toys(p_hat, j, kept):
    """Reservoirs of pixel j, with targets in their samples."""
    return Reservoirs(Toy(kept.cell, p_hat[j][kept.cell][:, None]), kept.W, kept.M)


def jacobian(i_from, i_to, x):
    """|∂ω_to / ∂ω_from| of cells; 1 for nothing."""
    x_from, x_to = (np.broadcast_to(EYE[i], (len(x), 3)) for i in (i_from, i_to))
    J = reconnection_jacobian(x_from, x_to, CELL[x], NORMAL[x])
    return np.where(x == NOTHING, Fraction(1), J)


DOMAIN = SourceTables(NOW.p_hat, NOW.seen, with_nothing(HOLDS, False), jacobian)
"""The toy domain."""


def resampled(sources, uniform, mis, cap=9999):
    """What a pixel keeps of its sources' samples."""
    r = resample(sources, [uniform() for _ in sources], mis, cap, target)
    here = sources[0].tables.p_hat[sources[0].i]
    # What is kept is worth what it is worth here, not where it came from.
    full = r.W > 0
    assert (target(r.y.value) == here[r.y.cell])[full].all()
    return Kept(np.where(full, r.y.cell, NOTHING), r.W, r.M)


def by_the_engine(given, settings, cap):
    """In place of `restir_gi.resampled`: all weights by the engine."""
    own = (given.past, given.u_own), (given.own, given.u_own)
    return resample_weighted(given.q, [*own, *given.neighbors], settings.mis, cap)
