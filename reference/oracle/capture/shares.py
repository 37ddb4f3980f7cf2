"""Chances of the candidates of a stream, and who was kept.

Where two candidates are one sample, nobody can tell which of them was kept: the chance
that counts is that of the sample.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.blocks import blocks
from restir_gi.reference.oracle.replay.mis import CHAINED, with_mis_weights
from restir_gi.reference.oracle.replay.resampling import COPIED, held_by
from restir_gi.reference.oracle.replay.reuse import STREAMS
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import ORDERS, Slot
from restir_gi.reference.oracle.statistics.choices import Chances


@dataclass(frozen=True, slots=True, eq=False)
class StreamChances:
    """What the rows of a case could keep, S candidates and N rows.

    Attributes
    ----------
    names : tuple of str; in the order of the contract
    order : tuple of int; in which they come
    w, error : (S, N) float64; weights, those of MIS among them, and bounds to rounding
    same : (S, S, N) bool; whether two are one sample
    held : (S, N) bool; whether the outputs hold them
    shown : (N,) bool; rows that had a choice, and whose choice can be told
    """

    names: tuple[str, ...]
    order: tuple[int, ...]
    w: Scalars
    error: Scalars
    same: Masks
    held: Masks
    shown: Masks

    def chances(self, shares: tuple[Scalars, Scalars]) -> Iterator[tuple[str, Chances]]:
        """Who was kept beside some bounds on the chances, candidate by candidate.

        Parameters
        ----------
        shares : (S, N) and (S, N) float64; least and largest probability of each
        """
        low, high = (np.einsum("kjn,jn->kn", self.same, share) for share in shares)
        for k, name in enumerate(self.names):
            one = Chances(self.held[k], low[k], np.minimum(high[k], 1.0))
            yield name, one.of(self.shown)

    def shares(self) -> tuple[Scalars, Scalars]:
        """Least and largest wₖ / Σw that rounding leaves, (S, N) each."""
        least, most = np.maximum(self.w - self.error, 0.0), self.w + self.error
        return _part(least, most), _part(most, least)


def _part(own: Scalars, others: Scalars) -> Scalars:
    """Each number as a part of itself and of all the others, (S, N).

    Of a number without a bound it may be all.
    """
    rest = [np.delete(others, k, axis=0).sum(axis=0) for k in range(len(others))]
    whole = own + np.stack(rest)
    bounded = (whole > 0) & np.isfinite(whole)
    found: Scalars = np.divide(own, whole, out=np.zeros_like(own), where=bounded)
    return np.where(np.isinf(own), 1.0, found)


def candidates_of(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> StreamChances | None:
    """StreamChances of a pass under some rules; ``None`` for a chain of closed merges.

    There the chance of one hangs on who was kept before, of which nothing is told.
    """
    if rules.normalization in CHAINED:
        return None
    found = [
        _candidates(part, {n: a[at] for n, a in outputs.items()}, rules, precision)
        for at, part in blocks(case)
    ]
    w, error, same, held, shown = (
        np.concatenate([getattr(one, name) for one in found], axis=-1)
        for name in ("w", "error", "same", "held", "shown")
    )
    return replace(found[0], w=w, error=error, same=same, held=held, shown=shown)


def _candidates(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> StreamChances:
    slots, closing = STREAMS[case.pass_name](case, rules, precision)
    held = held_by(outputs, slots, rules)
    weighted = with_mis_weights(slots, closing, rules)
    w, error = (
        np.stack([getattr(slot.w, name) for slot in weighted])
        for name in ("value", "error")
    )
    shown = (w.sum(axis=0) > 0) & held.any(axis=0) & case.within
    names = _names(case.pass_name, len(slots))
    order = _order(rules.order, len(slots), closing.canonical)
    return StreamChances(names, order, w, error, _same(slots), held, shown)


def _names(pass_name: str, count: int) -> tuple[str, ...]:
    """What candidates are called, in the order of the contract."""
    if pass_name == "fused":
        return "the pixel's own", *(f"source {k}" for k in range(count - 1))
    if pass_name != "spatial":
        return "the past", "the new sample"
    around = (f"neighbour {k}" for k in range(count - 2))
    return "the spatial past", "the pixel's own", *around


def _order(name: str, count: int, own: int) -> tuple[int, ...]:
    if name == "contract":
        return tuple(range(count))
    return tuple(ORDERS[name].of(count, own)[0])


def _same(slots: list[Slot]) -> Masks:
    """Whether two candidates are one sample, (S, S, N)."""
    there = np.stack([(slot.M.value > 0) | (slot.w.value > 0) for slot in slots])
    found = there[:, None] & there[None]
    for k, a in enumerate(slots):
        for j, b in enumerate(slots[:k]):
            for name in COPIED:
                found[k, j] &= (
                    getattr(a.y, name).value == getattr(b.y, name).value
                ).all(axis=1)
            found[j, k] = found[k, j]
        found[k, k] = True
    return found


def accepted(candidates: StreamChances, mistake: str) -> tuple[Scalars, Scalars]:
    """Chances under another way to decide, (S, N) twice.

    Parameters
    ----------
    mistake : 'accepts-by-the-old-sum', 'always-accepts', 'never-accepts' or
        'one-number-for-all-decisions'
    """
    w = candidates.w[list(candidates.order)]
    before = np.cumsum(w, axis=0) - w
    takes = _takes(w, before, mistake)
    found = np.empty_like(w)
    left = np.ones(w.shape[1])
    for k in reversed(range(len(w))):
        if mistake == "one-number-for-all-decisions":
            # The last one whose share is above the number stays.
            found[k] = np.maximum(takes[k] - (1 - left), 0.0)
            left = np.minimum(left, 1 - takes[k])
        else:
            found[k] = takes[k] * left
            left = left * (1 - takes[k])
    placed = np.empty_like(found)
    placed[list(candidates.order)] = found
    return placed, placed


def _takes(w: Scalars, before: Scalars, mistake: str) -> Scalars:
    """Probability that each candidate is taken as it comes, (S, N)."""
    first = (before == 0) & (w > 0)
    if mistake == "accepts-by-the-old-sum":
        takes = np.divide(w, before, out=np.ones_like(w), where=before > 0)
    elif mistake == "always-accepts":
        takes = np.ones_like(w)
    elif mistake == "never-accepts":
        takes = np.zeros_like(w)
    else:
        takes = np.divide(w, before + w, out=np.zeros_like(w), where=w > 0)
    return np.where(first, 1.0, np.where(w > 0, np.minimum(takes, 1.0), 0.0))
