"""Entries compete, and the sample that was kept gets its weight."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices, Scalars
from reference.passes.entries import Entry
from reference.passes.normalization import drop_hidden, normalization
from reference.passes.pairwise import in_pairs
from reference.passes.receivers import Receivers
from reference.passes.stream import kept_samples, stream
from reference.records import concatenate, take
from reference.resampling.reservoir import Reservoirs, cap_confidence, finalize


@dataclass(frozen=True, slots=True, eq=False)
class Competition:
    """Who takes part in the resampling of K receivers, before anything is chosen.

    Attributes
    ----------
    receivers : Receivers
        K pixels.
    entries : list of Entry
        In the order in which they are streamed.
    decisions : list of (K,) float64
        One number in [0, 1) for each entry; that of the first decides nothing.
    canonical : int
        Place of the receivers' own entry, which covers their domain.
    cap : float
        Limit of M.
    """

    receivers: Receivers
    entries: list[Entry]
    decisions: list[Scalars]
    canonical: int
    cap: float

    @property
    def shifted(self) -> bool:
        """Whether some samples come from elsewhere."""
        return any(entry.origin for entry in self.entries)

    @property
    def weighted(self) -> list[Entry]:
        """Entries with the weights that they are streamed with."""
        in_advance = self.receivers.settings.mis in ("pairwise", "defensive")
        if not (self.shifted and in_advance):
            return self.entries
        return in_pairs(self.receivers, self.entries, self.canonical)


@dataclass(frozen=True, slots=True, eq=False)
class Resampled:
    """What a pass leaves, K rows.

    Attributes
    ----------
    reservoirs : Reservoirs
        Closed; M at most the cap.
    place : (K,) int
        Of the entry in the stream whose sample was kept.
    """

    reservoirs: Reservoirs
    place: Indices


def resample(competition: Competition) -> Resampled:
    """Choose among the entries of each receiver.

    Parameters
    ----------
    competition : Competition
        K pixels, and who takes part.

    Returns
    -------
    Resampled
        K rows.

    Notes
    -----
    [Ouyang21, Alg. 4, lines 13 to 20], of which Algorithm 3 is the case of two entries.
    """
    receivers, entries = competition.receivers, competition.weighted
    decisions, cap = competition.decisions, competition.cap
    # Line 13: stream the candidates.
    chosen = stream(entries, decisions)
    y = kept_samples(entries, chosen.y)
    # Lines 16 to 20: divide by the confidences of those that could have made it.
    total = normalization(receivers, entries, chosen, y)
    kept = finalize(replace(chosen, y=y), total)
    if receivers.settings.visibility == "chosen" and competition.shifted:
        kept = drop_hidden(receivers, kept)
    return Resampled(cap_confidence(kept, cap), chosen.y)


def resample_each(competitions: Iterable[tuple[Indices, Competition]]) -> Resampled:
    """Choose in several competitions of one pass.

    Parameters
    ----------
    competitions : iterable of ((J,) int, Competition)
        One at least; each of K receivers in one of them.

    Returns
    -------
    Resampled
        K rows.
    """
    each = [(rows, resample(competition)) for rows, competition in competitions]
    if len(each) == 1:
        return each[0][1]
    order = np.argsort(np.concatenate([rows for rows, _ in each]))
    return take(concatenate([kept for _, kept in each]), order)
