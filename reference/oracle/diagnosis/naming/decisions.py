"""Which sample is kept: by another random number than the right one, or by weights."""

from collections.abc import Callable, Iterator, Mapping
from itertools import chain, product

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE
from restir_gi.reference.oracle.diagnosis.naming.monomials import Monomial
from restir_gi.reference.oracle.diagnosis.naming.slots import StreamFacts
from restir_gi.reference.oracle.diagnosis.naming.weights import StreamFit

LEFT_OPEN = 0.002
"""Share of the right rows that rounding may decide otherwise by another rule: some
hundred times what it leaves open by the right one."""

FEW = 20
"""Illegal choices, from which no rule is told."""

EXPONENTS = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)

Choose = Callable[[StreamFacts], Indices]


def decisions_explained(streams: list[StreamFacts]) -> StreamFit | None:
    """The rule by which most choices are right, if nearly all are: legal ones too."""
    of = sum(int(_counted(s, s.illegal).sum()) for s in streams)
    right = sum(int(_counted(s, ~s.illegal).sum()) for s in streams)
    if of < FEW:
        return None
    names = dict.fromkeys(
        name for s in streams for slot in s.slots for name in slot.facts.factors
    )
    found = []
    for text, choose in chain(_numbers(), _weights(list(names))):
        explained = broken = 0
        for s in streams:
            matches = _matches(s, choose(s))
            explained += int((matches & _counted(s, s.illegal)).sum())
            broken += int((~matches & _counted(s, ~s.illegal)).sum())
        if explained >= SHARE * of and broken <= LEFT_OPEN * right:
            fit = StreamFit("the kept sample", f"is chosen with {text}", explained, of)
            found.append((broken - explained, fit))
    return min(found, key=lambda one: one[0])[1] if found else None


def _counted(s: StreamFacts, rows: Masks) -> Masks:
    """Those in which anything has a weight, within the working range."""
    some: Masks = np.any([slot.w > 0 for slot in s.slots], axis=0)
    return rows & some & s.ordinary


def _matches(stream: StreamFacts, kept: Indices) -> Masks:
    held = np.stack([slot.held for slot in stream.slots])
    same: Masks = held[kept, np.arange(len(kept))]
    return same


def _kept(w: list[Scalars], u: list[Scalars], own: bool = True) -> Indices:
    """Who is kept, (N,), of weights and numbers of each slot.

    The sum that a weight is held against has that weight in it, or not.
    """
    kept, total = np.zeros(len(w[0]), np.int64), w[0].copy()
    for k in range(1, len(w)):
        alone = (total == 0) & (w[k] > 0)
        against = total + w[k] if own else total
        kept = np.where((u[k] * against < w[k]) & (w[k] > 0) | alone, k, kept)
        total = total + w[k]
    return kept


NUMBERS: Mapping[str, Callable[[Scalars], Scalars]] = {
    "u² for u": np.square,
    "√u for u": np.sqrt,
    "1 − u for u": lambda u: 1 - u,
    "u / 2 for u": lambda u: u / 2,
    "2 u for u": lambda u: 2 * u,
    "the u of the row before": lambda u: np.roll(u, 1),
    "the u of the row after": lambda u: np.roll(u, -1),
}


def _numbers() -> Iterator[tuple[str, Choose]]:
    def by_old_sum(s: StreamFacts) -> Indices:
        w = [slot.w for slot in s.slots]
        return _kept(w, [slot.u for slot in s.slots], own=False)

    yield "w_before for w_before + w", by_old_sum
    for text, at in (("0 for u", 0.0), ("1 for u", 1.0)):

        def always(s: StreamFacts, at: float = at) -> Indices:
            number = np.full(len(s.kept), at)
            return _kept([slot.w for slot in s.slots], [number for _ in s.slots])

        yield text, always
    for text, change in NUMBERS.items():

        def choose(
            s: StreamFacts, change: Callable[[Scalars], Scalars] = change
        ) -> Indices:
            w = [slot.w for slot in s.slots]
            return _kept(w, [change(slot.u) for slot in s.slots])

        yield text, choose


def _weights(names: list[str]) -> Iterator[tuple[str, Choose]]:
    """Weights with a factor too much, or a factor in their place."""
    for name in names:

        def alone(s: StreamFacts, name: str = name) -> Indices:
            w = [
                np.where(slot.w > 0, powered(slot.values(name), 1), 0)
                for slot in s.slots
            ]
            return _kept(w, [slot.u for slot in s.slots])

        yield f"{name} for w", alone
    for name, exponent in product(["w", *names], EXPONENTS):

        def choose(
            s: StreamFacts, name: str = name, exponent: float = exponent
        ) -> Indices:
            w = [slot.w * powered(slot.values(name), exponent) for slot in s.slots]
            total = [
                np.where(slot.w > 0, x, 0.0) for slot, x in zip(s.slots, w, strict=True)
            ]
            return _kept(total, [slot.u for slot in s.slots])

        by = Monomial(1.0, ((name, exponent),)).text.removeprefix("is right ")
        root = (name, exponent) == ("w", -0.5)
        yield ("√w for w" if root else f"w {by} for w"), choose


def powered(values: Scalars | None, exponent: float) -> Scalars | float:
    """A power of a factor.

    Parameters
    ----------
    values : (N,) float64 or None

    Returns
    -------
    (N,) float64; 1 where there is no such factor, 0 where the power is infinite
    """
    if values is None:
        return 1.0
    return np.nan_to_num(values**exponent, posinf=0.0)
