"""Algorithm 4: pixels resample what their neighbours keep."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices, Masks, Scalars
from reference.passes.entries import Donors, Entry, other_entry, own_entry
from reference.passes.history import History, past_entry
from reference.passes.neighbors import find_neighbors
from reference.passes.receivers import Receivers
from reference.passes.resample import Competition
from reference.records import NONE, keep
from reference.resampling.reservoir import Reservoirs
from reference.rng import Uniforms

OWN = 63
"""Dimension that decides on the pixel's own reservoir; the others are neighbours'."""


@dataclass(frozen=True, slots=True, eq=False)
class Neighborhood:
    """Whose reservoirs the neighbours of K pixels lend.

    Attributes
    ----------
    donors : Donors
        Temporal reservoirs of this frame, or of the last.
    rows : (K,) int
        Pixels of the donors' frame around which neighbours are looked for, or ``NONE``.
    spatial : Donors or None
        Spatial reservoirs of the last frame, for pixels with few samples.
    home : (N,) int or None
        Row of the last frame for each pixel of the donors' frame, or ``NONE``; ``None``
        where they are the same.
    """

    donors: Donors
    rows: Indices
    spatial: Donors | None = None
    home: Indices | None = None


def spatial_competitions(
    receivers: Receivers,
    own: Reservoirs,
    around: Neighborhood | None,
    history: History | None,
    uniforms: Uniforms,
) -> Iterator[tuple[Indices, Competition]]:
    """Who takes part in spatial resampling.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    own : Reservoirs
        Their temporal reservoirs.
    around : Neighborhood or None
        Whose neighbours take part; ``None`` for nobody's.
    history : History or None
        Spatial reservoirs of the last frame; ``None`` after a reset.
    uniforms : Uniforms
        K rows.  Dimension s, lanes 0 and 1: neighbour s; lane 2: whether it is kept;
        lane 3: whether its spatial reservoir is.  Dimension 63, lane 0: whether the
        pixel's own temporal reservoir is.

    Yields
    ------
    (J,) int, Competition
        Which of the receivers, and who takes part there: those of many samples, which
        try few neighbours, apart from those of few; each pixel once.

    Notes
    -----
    [Ouyang21, Alg. 4 and section 5]: pixels whose M is below half of
    its limit try more neighbours.
    """
    settings = receivers.settings
    few: Masks = np.zeros(len(receivers.points), bool)
    if history:
        few = settings.spatial_cap / 2.0 <= history.reservoirs.M

    def of(mask: Masks, tries: int) -> tuple[Indices, Competition]:
        rows = np.flatnonzero(mask)
        if mask.all():
            return rows, _compete(receivers, own, around, history, uniforms, tries)
        return rows, _compete(
            replace(receivers, points=keep(receivers.points, mask)),
            keep(own, mask),
            replace(around, rows=around.rows[mask]) if around else None,
            history.keep(mask) if history else None,
            uniforms.rows(rows),
            tries,
        )

    if not few.any() or not few.all():
        yield of(~few, settings.iterations_many)
    if few.any():
        yield of(few, settings.iterations_few)


def _compete(
    receivers: Receivers,
    own: Reservoirs,
    around: Neighborhood | None,
    history: History | None,
    uniforms: Uniforms,
    tries: int,
) -> Competition:
    entries = [past_entry(receivers, history, 0)] if history else []
    # The pixel's own temporal reservoir always takes part: without it the supports of
    # the others need not cover the pixel's domain.
    canonical = len(entries)
    entries.append(own_entry(receivers, own, canonical))
    decisions = [uniforms.draw(OWN)[0]] * len(entries)
    # Lines 2 to 15: stream the candidates.
    little = _little(receivers, history)
    for entry, u in neighbors(receivers, around, uniforms, tries, len(entries), little):
        entries.append(entry)
        decisions.append(u)
    cap = receivers.settings.spatial_cap
    return Competition(receivers, entries, decisions, canonical, cap)


def _little(receivers: Receivers, history: History | None) -> Masks | None:
    if not receivers.settings.boost_below:
        return None
    M = history.reservoirs.M if history else np.zeros(len(receivers.points))
    little: Masks = receivers.settings.boost_below > M
    return little


def neighbors(
    receivers: Receivers,
    around: Neighborhood | None,
    uniforms: Uniforms,
    tries: int,
    place: int,
    little: Masks | None = None,
) -> list[tuple[Entry, Scalars]]:
    """Entries of the neighbours of pixels, each with the number that decides on it.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    around : Neighborhood or None
        Whose neighbours take part; ``None`` for nobody's.
    uniforms : Uniforms
        K rows, as for `spatial_competitions`.
    tries : int
        Neighbours that are looked for.
    place : int
        Of the first, in the stream.
    little : (K,) bool or None
        Pixels that reuse spatial reservoirs of their neighbours, too.

    Returns
    -------
    list of (Entry, (K,) float64)
        One or two for each try.

    Notes
    -----
    [Ouyang21, Alg. 4, lines 5 to 13, and Fig. 10].
    """
    if around is None:
        return []
    there = around.rows != NONE
    draws = [uniforms.draw(s) for s in range(tries)]
    rows = find_neighbors(
        np.where(there, around.rows, 0),
        around.donors.visible,
        receivers.world.camera.width,
        receivers.settings,
        draws,
        receivers.settings.lattice,
    )
    found: list[tuple[Entry, Scalars]] = []
    for row, u in zip(rows, draws, strict=True):
        neighbor = np.where(there, row, NONE)
        entry = other_entry(receivers, around.donors, neighbor, place + len(found))
        found.append((entry, u[2]))
        if around.spatial and little is not None:
            before = neighbor
            if around.home is not None:
                before = np.where(neighbor != NONE, around.home[neighbor], NONE)
            before = np.where(little, before, NONE)
            entry = other_entry(receivers, around.spatial, before, place + len(found))
            found.append((entry, u[3]))
    return found
