"""Entries compete, and the sample that was kept gets its weight."""

from dataclasses import dataclass, replace

from reference.arrays import Indices, Scalars
from reference.passes.entries import Entry
from reference.passes.normalization import drop_hidden, normalization
from reference.passes.pairwise import in_pairs
from reference.passes.receivers import Receivers
from reference.passes.stream import kept_samples, stream
from reference.resampling.reservoir import Reservoirs, cap_confidence, finalize


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


def resample(
    receivers: Receivers,
    entries: list[Entry],
    decisions: list[Scalars],
    canonical: int,
    cap: float,
) -> Resampled:
    """Choose among the entries of each receiver.

    Parameters
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

    Returns
    -------
    Resampled
        K rows.

    Notes
    -----
    [Ouyang21, Alg. 4, lines 13 to 20], of which Algorithm 3 is the case of two entries.
    """
    settings = receivers.settings
    shifted = any(entry.origin for entry in entries)
    if shifted and settings.mis in ("pairwise", "defensive"):
        entries = in_pairs(receivers, entries, canonical)
    # Line 13: stream the candidates.
    chosen = stream(entries, decisions)
    y = kept_samples(entries, chosen.y)
    # Lines 16 to 20: divide by the confidences of those that could have made it.
    total = normalization(receivers, entries, chosen, y)
    kept = finalize(replace(chosen, y=y), total)
    if settings.visibility == "chosen" and shifted:
        kept = drop_hidden(receivers, kept)
    return Resampled(cap_confidence(kept, cap), chosen.y)
