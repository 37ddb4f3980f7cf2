"""Who takes part in the resampling of a pixel: its own reservoirs and others'."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices
from reference.passes.passage import Passage
from reference.passes.receivers import Receivers
from reference.passes.shifting import Shift, shift
from reference.records import NONE, take
from reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    Samples,
    reused_candidates,
)
from reference.scene.surface import Viewpoints, VisiblePoints
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class Donors:
    """Reservoirs of a whole frame, and what asks whether they could make a sample.

    Attributes
    ----------
    world : World
        Of their frame.
    visible : VisiblePoints
        Where they stand.
    reservoirs : Reservoirs
        A row a pixel.
    passage : Passage or None
        From their frame to this one; ``None`` where nothing has changed since.
    """

    world: World
    visible: VisiblePoints
    reservoirs: Reservoirs
    passage: Passage | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """Where reservoirs come from, K rows.

    Attributes
    ----------
    donors : Donors
        Whom they belong to.
    rows : (K,) int
        Which of them, ``NONE`` where there is none.
    x : Viewpoints
        Their visible points.
    """

    donors: Donors
    rows: Indices
    x: Viewpoints


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """One competitor in each receiver's stream, K rows.

    Attributes
    ----------
    candidate : Candidates
        ``y`` is the place of this entry in the stream; M is 0 where there is none.
    y : Samples or None
        The samples as they arrive; ``None``: as they stand in the donors' reservoirs.
    origin : Origin or None
        ``None`` where the reservoirs stand at the receivers themselves, so that both
        can make the same samples.
    """

    candidate: Candidates
    y: Samples | None
    origin: Origin | None = None


def own_entry(receivers: Receivers, r: Reservoirs, place: int) -> Entry:
    """Reservoirs at the receivers themselves, or taken to be there.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    r : Reservoirs
        K rows; M = 0 where there is none.
    place : int
        In the stream.

    Returns
    -------
    Entry
        Weighted with p̂ W M.
    """
    places = np.full(len(r.W), place, np.uint8)
    p_hat = receivers.target(r.y)
    candidate = reused_candidates(Reservoirs(places, r.W, r.M), p_hat)
    return Entry(candidate, r.y)


def other_entry(
    receivers: Receivers, donors: Donors, rows: Indices, place: int
) -> Entry:
    """Reservoirs of other pixels, or of another frame, shifted to the receivers.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    donors : Donors
        Whom the reservoirs belong to.
    rows : (K,) int
        Which of them, or ``NONE``.
    place : int
        In the stream.

    Returns
    -------
    Entry
        Weighted with p̂ W M |∂ω_to / ∂ω_from|.  Samples that arrive with no light, out
        of the shift's limits, or hidden, have w = 0; M counts them.

    Notes
    -----
    [Ouyang21, Alg. 4, lines 9 to 13].
    """
    settings, points = receivers.settings, receivers.points
    there = rows != NONE
    row = np.where(there, rows, 0)
    r = take(donors.reservoirs, row)
    x = take(donors.visible.surface.viewpoints, row)
    # Lines 10 and 11: the sample seen from here, in the measure of here.
    y, x_from = r.y, x.position
    if donors.passage:
        y = donors.passage.arrive(y, there & (r.W > 0))
        x_from = donors.passage.beside(y, x_from)
    moved = shift(settings, x_from, points.position, y)
    places = np.full(len(row), place, np.uint8)
    M = np.where(there, r.M, 0.0)
    candidate = reused_candidates(
        Reservoirs(places, r.W, M), receivers.target(y), moved.factor
    )
    candidate = _without(candidate, moved)
    # Lines 12 and 13: nothing comes from a sample that is hidden; M counts it.
    if settings.visibility == "all":
        seen = receivers.see(y, candidate.w > 0)
        candidate = replace(candidate, w=np.where(seen, candidate.w, 0.0))
    arrived = y if donors.passage else None
    return Entry(candidate, arrived, Origin(donors, rows, x))


def _without(candidate: Candidates, moved: Shift) -> Candidates:
    if moved.possible is None:
        return candidate
    return replace(candidate, w=np.where(moved.possible, candidate.w, 0.0))
