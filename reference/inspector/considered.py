"""What a pass considered: every candidate of every pixel, and what was made of it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference.arrays import Indices, Scalars, divide_or_zero
from reference.inspector.fates import Fate, fates, shifted
from reference.inspector.origins import Origins, Source
from reference.passes.entries import Entry
from reference.passes.normalization import normalization, who_holds
from reference.passes.resample import Competition, resample
from reference.passes.stream import kept_samples, stream
from reference.records import NONE, scatter, take

NOT_ASKED = 2
"""Besides no, 0, and yes, 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Considered:
    """Candidates of a pass, in C places of the streams of N pixels.

    Attributes
    ----------
    name : str
        Of the pass.
    roles : tuple of str
        Who stands in each place.
    frames : tuple of int
        Of which frame each of them is.
    source : (N, C) int
        Pixel of that frame that lent the candidate, or ``NONE``.
    M, W, p_hat, jacobian, w : (N, C) float64
        Confidence; contribution weight where it comes from (sr); target at the
        receiver (radiance/sr); factor on W; weight in the stream.
    position : (N, C, 3) float64, m
        Sample point.
    fate : (N, C) int
        Of `Fate`.
    could : (N, C) int
        Whether it could have made the sample that was kept, or `NOT_ASKED`.
    kept : (N,) int
        Place of the kept sample.
    w_sum, total : (N,) float64
        Sum of w; what it was divided by: M, Z, or 1 where weights were divided before.
    number : (N,) int64
        Of the path that drew the kept sample.
    """

    name: str
    roles: tuple[str, ...]
    frames: tuple[int, ...]
    source: Indices
    M: Scalars
    W: Scalars
    p_hat: Scalars
    jacobian: Scalars
    w: Scalars
    position: Scalars
    fate: Indices
    could: Indices
    kept: Indices
    w_sum: Scalars
    total: Scalars
    number: Indices


def considered(
    name: str, competitions: Iterable[tuple[Indices, Competition]], origins: Origins
) -> Considered:
    """What a pass considers, and what comes of it.

    Parameters
    ----------
    name : str
        Of the pass.
    competitions : iterable of ((J,) int, Competition)
        Each pixel of the frame in one of them.
    origins : Origins
        Knows who stands where.

    Returns
    -------
    Considered
        N rows.
    """
    parts = [(rows, *_of(rows, c, origins)) for rows, c in competitions]
    longest = max((sources for _, sources, _ in parts), key=len)
    whole = {
        key: sum(
            scatter(rows, _padded(values[key], key, len(longest)), origins.pixels)
            for rows, _, values in parts
        )
        for key in parts[0][2]
    }
    roles, frames = zip(*((s.role, s.frame) for s in longest), strict=True)
    return Considered(name, roles, frames, **whole)


def _padded(values: Any, key: str, places: int) -> Any:
    if values.ndim == 1 or values.shape[1] == places:
        return values
    missing = [(0, 0), (0, places - values.shape[1]), *[(0, 0)] * (values.ndim - 2)]
    return np.pad(values, missing, constant_values=NONE if key == "source" else 0)


def _of(
    rows: Indices, c: Competition, origins: Origins
) -> tuple[list[Source], dict[str, Any]]:
    receivers, entries = c.receivers, c.weighted
    # As `resample` goes about it, step by step.
    chosen = stream(entries, c.decisions)
    y = kept_samples(entries, chosen.y)
    total = normalization(receivers, entries, chosen, y)
    kept = resample(c)
    full = kept.reservoirs.W > 0
    could = np.full((len(rows), len(entries)), NOT_ASKED)
    if c.shifted and receivers.settings.mis in ("1/Z", "balance"):
        holds, _ = who_holds(receivers, entries, chosen, y)
        could = np.stack(holds, axis=1).astype(int)
    each = [_candidates(c, place, entry) for place, entry in enumerate(entries)]
    whole = {key: np.stack([one[key] for one in each], axis=1) for key in each[0]}
    # With visibility asked of the kept sample alone, that is where it is lost.
    lost = (chosen.w > 0) & (total > 0) & ~full
    whole["fate"][lost, chosen.y[lost]] = Fate.HIDDEN
    sources = [origins.source(c, place, rows) for place in range(len(entries))]
    numbers = np.stack([source.numbers for source in sources], axis=1)
    made_by = numbers[np.arange(len(rows)), chosen.y]
    return sources, {
        **whole,
        "source": np.stack([source.rows for source in sources], axis=1),
        "could": could,
        "kept": np.asarray(chosen.y, int),
        "w_sum": chosen.w,
        "total": total,
        "number": np.where(full, made_by, NONE),
    }


def _candidates(c: Competition, place: int, weighted: Entry) -> dict[str, Any]:
    """Those of one place, of which the weights in pairs change w alone."""
    entry = c.entries[place]
    y = kept_samples(c.entries, np.full(len(entry.candidate.M), place))
    J, possible = shifted(c.receivers, entry, y)
    return {
        "M": entry.candidate.M,
        "W": _weight(entry),
        "p_hat": entry.candidate.p_hat,
        "jacobian": J,
        "w": weighted.candidate.w,
        "position": y.position,
        "fate": fates(entry, y, J, possible),
    }


def _weight(entry: Entry) -> Scalars:
    """W where the candidate comes from."""
    if entry.origin is None:
        c = entry.candidate
        return divide_or_zero(c.w, c.p_hat * c.M)
    there = entry.origin.rows != NONE
    W = take(entry.origin.donors.reservoirs.W, np.maximum(entry.origin.rows, 0))
    return np.where(there, W, 0.0)
