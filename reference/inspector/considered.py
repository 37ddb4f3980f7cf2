"""What a pass considered: every candidate of every pixel, and what was made of it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference.arrays import Indices, Scalars, divide_or_zero
from reference.inspector.fates import Fate, fates, shifted
from reference.inspector.origins import Origins, Source
from reference.passes.entries import Entry
from reference.passes.neighbors import NONE
from reference.passes.normalization import normalization, who_holds
from reference.passes.resample import Competition, resample
from reference.passes.stream import kept_samples, stream
from reference.records import scatter, take
from reference.resampling.reservoir import Samples

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
    could = np.full((len(rows), len(entries)), NOT_ASKED)
    if c.shifted and receivers.settings.mis in ("1/Z", "balance"):
        could = np.stack(who_holds(receivers, entries, chosen, y)[0], axis=1).astype(
            int
        )
    samples = [_samples(entries, place) for place in range(len(entries))]
    sources = [origins.source(c, place, rows) for place in range(len(entries))]
    each = list(zip(c.entries, samples, strict=True))
    ways = [shifted(receivers, entry, y_k) for entry, y_k in each]
    fate = np.stack(
        [fates(*pair, *way) for pair, way in zip(each, ways, strict=True)], axis=1
    )
    # With visibility asked of the kept sample alone, that is where it is lost.
    lost = (chosen.w > 0) & (total > 0) & (kept.reservoirs.W <= 0)
    fate[lost, chosen.y[lost]] = Fate.HIDDEN
    numbers = np.stack([source.numbers for source in sources])
    made_by = numbers[chosen.y, np.arange(len(rows))]
    return sources, {
        "source": np.stack([source.rows for source in sources], axis=1),
        "M": np.stack([e.candidate.M for e in c.entries], axis=1),
        "W": np.stack([_weight(e) for e in c.entries], axis=1),
        "p_hat": np.stack([e.candidate.p_hat for e in c.entries], axis=1),
        "jacobian": np.stack([J for J, _ in ways], axis=1),
        "w": np.stack([e.candidate.w for e in entries], axis=1),
        "position": np.stack([y_k.position for y_k in samples], axis=1),
        "fate": fate,
        "could": could,
        "kept": np.asarray(chosen.y, int),
        "w_sum": chosen.w,
        "total": total,
        "number": np.where(kept.reservoirs.W > 0, made_by, NONE),
    }


def _samples(entries: list[Entry], place: int) -> Samples:
    return kept_samples(entries, np.full(len(entries[place].candidate.M), place))


def _weight(entry: Entry) -> Scalars:
    """W where the candidate comes from."""
    if entry.origin is None:
        c = entry.candidate
        return divide_or_zero(c.w, c.p_hat * c.M)
    there = entry.origin.rows != NONE
    W = take(entry.origin.donors.reservoirs.W, np.maximum(entry.origin.rows, 0))
    return np.where(there, W, 0.0)
