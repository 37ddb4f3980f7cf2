"""Weights in a stream that a backend does not give, inferred from those that it does.

Where a single reservoir of a stream has a weight, W p̂ Z is that weight as the backend
has calculated it: so a wrong factor of it shows alone.  What is inferred there must
then explain all other rows too.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.naming.claims import (
    explained,
    explained_by_itself,
)
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE, Fit
from restir_gi.reference.oracle.diagnosis.naming.numbers import (
    CaseNumbers,
    Numbers,
    joined,
    part_of,
)
from restir_gi.reference.oracle.diagnosis.naming.slots import StreamFacts

Kinds = tuple[str, ...]

FACTORS_OF_WEIGHT = ("w", "J", "M", "W", "pdf")
"""What of a reservoir is asked about; the last divides its weight."""


@dataclass(frozen=True, slots=True)
class StreamFit:
    """What explains a stream.

    Attributes
    ----------
    term : str; "J of the past"
    text : str; what it is in place of right, and where
    rows, of : int; wrong rows that it explains, of how many
    cost : float; the simpler the lower
    """

    term: str
    text: str
    rows: int
    of: int
    cost: float = 0.0

    @property
    def share(self) -> float:
        """Of the wrong rows."""
        return self.rows / self.of


def weights_explained(
    streams: list[StreamFacts], precision: Precision
) -> StreamFit | None:
    """The simplest mistake with one kind of reservoirs that explains most wrong W."""
    found = []
    every = list(dict.fromkeys(s.kind for stream in streams for s in stream.slots))
    alone = {kind: list(_parts_alone(streams, kind)) for kind in every}
    for size in range(1, len(every) + 1):
        found = [
            told
            for kinds in combinations(every, size)
            for told in _of_kinds(streams, alone, kinds, precision)
        ]
        if found:
            return min(found, key=lambda one: (-round(one.share, 2), one.cost))
    return None


def _of_kinds(
    streams: list[StreamFacts],
    alone: dict[str, list[CaseNumbers]],
    kinds: Kinds,
    precision: Precision,
) -> Iterator[StreamFit]:
    """What explains the weights of some kinds, and with them all that is wrong."""
    times = joined("w", [part for kind in kinds for part in alone[kind]], precision)
    for factor in FACTORS_OF_WEIGHT:
        fit = _fit(times, factor)
        if fit is not None:
            rows, of = _explains(streams, kinds, factor, fit, precision)
            if of and rows >= SHARE * of:
                term = f"{factor} of {' and '.join(kinds)}"
                yield StreamFit(term, fit.text, rows, of, fit.cost)


def _fit(w: Numbers, factor: str) -> Fit | None:
    """What a factor of a weight is in place of right; of w any product will do."""
    if factor == "w":
        return explained(w)
    if factor not in w.factors:
        return None
    right = w.factors[factor].value
    times = w.found / w.right if factor != "pdf" else w.right / w.found
    allowed = right * w.allowed / w.right
    known = np.isfinite(right * times) & np.isfinite(allowed)
    return explained_by_itself(
        replace(
            w,
            name=factor,
            found=np.where(known, right * times, 0.0),
            right=right,
            allowed=np.where(known, allowed, np.inf),
        )
    )


def _parts_alone(streams: list[StreamFacts], kind: str) -> Iterator[CaseNumbers]:
    """Weights of a kind: all, where they are given, else those that are alone."""
    for stream in streams:
        w = np.stack([slot.w for slot in stream.slots])
        for k, slot in enumerate(stream.slots):
            if slot.kind != kind:
                continue
            known = (w[k] > 0) & stream.ordinary
            if stream.given is not None:
                found = stream.given[:, k].astype(np.float64)
            else:
                known &= (w > 0).sum(axis=0) == 1
                known &= slot.held | (stream.W.found == 0)
                found = slot.w * stream.W.found / stream.W.expected
            allowed = slot.w * stream.W.allowed / stream.W.expected
            known &= np.isfinite(found) & np.isfinite(allowed)
            rows = np.flatnonzero(known)
            yield part_of(found, slot.w, allowed, slot.facts, rows, stream.start)


def _explains(
    streams: list[StreamFacts],
    kinds: Kinds,
    factor: str,
    fit: Fit,
    precision: Precision,
) -> tuple[int, int]:
    """Rows with a wrong W that a fit explains, of how many; 0 if it breaks others."""
    explained_rows = wrong_rows = 0
    for stream in streams:
        value, room = _with_changed(stream, kinds, factor, fit, precision)
        W, o = stream.W, stream.ordinary
        wrong = (np.abs(W.found - W.expected) > W.allowed) & o
        agrees = np.abs(W.found - value) <= room
        told = np.abs(value - W.expected) > 2 * (W.allowed + room)
        if (~wrong & ~agrees & told & o).any():
            return 0, 0
        wrong_rows += int(wrong.sum())
        explained_rows += int((wrong & agrees & told).sum())
    return explained_rows, wrong_rows


def _with_changed(
    stream: StreamFacts, kinds: Kinds, factor: str, fit: Fit, precision: Precision
) -> tuple[Scalars, Scalars]:
    """W of a backend with a mistake in the weights of some kinds."""
    total, room = np.zeros(len(stream.kept)), np.zeros(len(stream.kept))
    for slot in stream.slots:
        times, error = np.ones(len(total)), np.zeros(len(total))
        right = slot.values(factor)
        if slot.kind in kinds and right is not None:
            every = np.arange(len(right))
            part = part_of(right, right, right * 0, slot.facts, every, 0)
            value, loose = fit.predicted(joined(factor, [part], precision))
            times = right / value if factor == "pdf" else value / right
            error = np.abs(loose / value)
            times, error = np.where(slot.w > 0, (times, error), 0.0)
        total += slot.w * times
        room += slot.w * times * error
    S = np.sum([slot.w for slot in stream.slots], axis=0)
    W = np.where(S > 0, stream.W.expected * total / S, 0.0)
    share = stream.W.allowed / stream.W.expected
    loose = np.abs(W) * (share + np.nan_to_num(room / total))
    return W, np.nan_to_num(loose)
