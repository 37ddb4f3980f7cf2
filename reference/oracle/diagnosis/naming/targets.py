"""Another target than the right one, in the weights and in W alike."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE
from restir_gi.reference.oracle.diagnosis.naming.monomials import Monomial
from restir_gi.reference.oracle.diagnosis.naming.numbers import CLEAR, ROUNDINGS
from restir_gi.reference.oracle.diagnosis.naming.slots import StreamFacts
from restir_gi.reference.oracle.diagnosis.naming.weights import StreamFit

FACTORS = (
    "cos θ",
    "d",
    "cos φ",
    "Y(albedo)",
    "Y(L_o)",
    "Y(albedo · L_o)",
    "Y601(albedo · L_o)",
)
EXPONENTS = (-1.0, 1.0, -2.0, 2.0, -0.5, 0.5)
FEW, SAMPLE = 20, 128
"""Wrong rows from which nothing is told, and on which each target is tried first."""

Exponents = tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """R rows of all cases, with S slots each.

    Attributes
    ----------
    w : (S, R) float64; weights by the contract
    factors : mapping of str to (S, R) float64; 1 where a slot has no weight
    kept : (R,) int; slot that the backend has kept
    found, right, allowed : (R,) float64; W
    wrong : (R,) bool
    """

    w: Scalars
    factors: Mapping[str, Scalars]
    kept: Indices
    found: Scalars
    right: Scalars
    allowed: Scalars
    wrong: Masks

    def rows(self, rows: Indices) -> "_Rows":
        return _Rows(
            w=self.w[:, rows],
            factors={name: values[:, rows] for name, values in self.factors.items()},
            kept=self.kept[rows],
            found=self.found[rows],
            right=self.right[rows],
            allowed=self.allowed[rows],
            wrong=self.wrong[rows],
        )

    def agrees(self, exponents: Exponents, unit: float) -> Masks:
        """Whether W is that of a target with these factors too much, (R,) bool."""
        factor = np.ones_like(self.w)
        for name, exponent in exponents:
            factor = factor * self.factors[name] ** exponent
        kept = factor[self.kept, np.arange(len(self.kept))]
        times = (self.w * factor).sum(axis=0) / self.w.sum(axis=0) / kept
        room = np.abs(times) * (self.allowed + ROUNDINGS * unit * self.right)
        agrees: Masks = np.abs(self.found - self.right * times) <= room
        return agrees


def target_explained(streams: list[StreamFacts], unit: float) -> StreamFit | None:
    """A product that the target is multiplied by, wherever it stands.

    Parameters
    ----------
    unit : float; relative error of an operation
    """
    rows = _rows_of(streams)
    wrong = np.flatnonzero(rows.wrong)
    if len(wrong) < FEW:
        return None
    few = rows.rows(wrong[:: max(1, len(wrong) // SAMPLE)])
    for exponents in _products():
        if few.agrees(exponents, unit).mean() < SHARE:
            continue
        agrees = rows.agrees(exponents, unit)
        explained = int((agrees & rows.wrong).sum())
        if explained >= SHARE * len(wrong) and (agrees | rows.wrong).all():
            text = f"{Monomial(1.0, exponents).text}, in the weights and in W"
            return StreamFit("p̂", text, explained, len(wrong))
    return None


def _products() -> Iterator[Exponents]:
    for name, e in product(FACTORS, EXPONENTS):
        yield ((name, e),)
    for (a, b), e, f in product(combinations(FACTORS, 2), EXPONENTS, EXPONENTS):
        yield (a, e), (b, f)


def _rows_of(streams: list[StreamFacts]) -> _Rows:
    """Rows in which W is known well, of all cases; who has fewer slots gets empty ones.

    A sample without a weight has none by another target either.
    """
    count = max(len(s.slots) for s in streams)
    known = [np.flatnonzero(_known(s)) for s in streams]

    def of_slots(values: list[list[Scalars]], missing: float) -> Scalars:
        return np.concatenate(
            [
                np.stack([v[k] for v in slots] + [np.full(len(k), missing)] * lacking)
                for slots, k in zip(values, known, strict=True)
                for lacking in (count - len(slots),)
            ],
            axis=1,
        )

    def of_rows(values: list[Scalars]) -> Scalars:
        return np.concatenate([v[k] for v, k in zip(values, known, strict=True)])

    w = of_slots([[slot.w for slot in s.slots] for s in streams], 0.0)
    factors = {
        name: of_slots(
            [[_factor(slot.values(name)) for slot in s.slots] for s in streams], 1.0
        )
        for name in FACTORS
    }
    found, right, allowed = (
        of_rows([getattr(s.W, name).astype(np.float64) for s in streams])
        for name in ("found", "expected", "allowed")
    )
    return _Rows(
        w,
        {name: np.where(w > 0, values, 1.0) for name, values in factors.items()},
        np.concatenate([s.kept[k] for s, k in zip(streams, known, strict=True)]),
        found,
        right,
        allowed,
        np.abs(found - right) > allowed,
    )


def _factor(values: Scalars | None) -> Scalars:
    assert values is not None  # every slot has what is known of its sample
    return values


def _known(s: StreamFacts) -> Masks:
    known: Masks = s.ordinary & (s.W.allowed < CLEAR * s.W.expected)
    known &= np.any([slot.held for slot in s.slots], axis=0)
    return known
