"""Generalized resampling: pixels take over whole paths from others."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from extensions.paths import Paths
from extensions.shifting import Shift
from reference.arrays import Indices, Scalars, divide_or_zero
from reference.resampling.mis import balance_heuristic, one_over_m, one_over_z
from reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    cap_confidence,
    finalize,
    merge,
    reused_candidates,
)
from reference.resampling.target import luminance
from reference.scene.surface import SurfacePoints
from reference.world import World

Mis = Literal["1/M", "1/Z", "balance"]


@dataclass(frozen=True, slots=True)
class Donor:
    """Reservoirs that K pixels are offered, one each.

    Attributes
    ----------
    world : World
        In which the donors' paths were made.
    points : SurfacePoints
        K visible points of the donors.
    reservoirs : Reservoirs
        K rows of `Paths`; M = 0 where nothing is offered.
    stands : bool
        Donor and pixel are one point, and nothing is shifted.
    """

    world: World
    points: SurfacePoints
    reservoirs: Reservoirs
    stands: bool = False


@dataclass(frozen=True, slots=True)
class _Placed:
    """Paths, and the place in the stream that put them in."""

    paths: Paths
    place: Indices


@dataclass(frozen=True, slots=True)
class _Entry:
    """A competitor: its donor, the candidates, and the Jacobian of their shift."""

    donor: Donor
    candidates: Candidates
    jacobian: Scalars


def resample(
    shift: Shift,
    world: World,
    points: SurfacePoints,
    donors: list[Donor],
    decisions: list[Scalars],
    mis: Mis,
    cap: float,
) -> Reservoirs:
    """Choose among what the donors of each pixel offer.

    Parameters
    ----------
    shift : Shift
        Mapping of paths.
    world : World
        Of the pixels.
    points : SurfacePoints
        K visible points.
    donors : list of Donor
        In the order of the stream; one of them stands, so that the domain is covered.
    decisions : list of (K,) float64
        One number in [0, 1) for each; that of the first decides nothing.
    mis : '1/M', '1/Z' or 'balance'
        What the sum of weights is divided by.
    cap : float
        Limit of M.

    Returns
    -------
    Reservoirs
        K rows of `Paths`, with their values at the pixels.

    Notes
    -----
    [Lin22, Eqs. 22 and 36].
    """
    entries = [
        _entry(shift, world, points, donor, place) for place, donor in enumerate(donors)
    ]
    chosen = entries[0].candidates
    for entry, u in zip(entries[1:], decisions[1:], strict=True):
        chosen = merge(chosen, entry.candidates, u)
    total = _normalization(shift, entries, chosen, mis)
    kept = finalize(replace(chosen, y=chosen.y.paths), total)
    return cap_confidence(kept, cap)


def _entry(
    shift: Shift, world: World, points: SurfacePoints, donor: Donor, place: int
) -> _Entry:
    r, size = donor.reservoirs, len(points)
    places = np.full(size, place, np.int8)
    if donor.stands:
        placed = Reservoirs(_Placed(r.y, places), r.W, r.M)
        c = reused_candidates(placed, luminance(r.y.value))
        return _Entry(donor, c, np.ones(size))
    there = shift(world, points, r.y, r.W > 0)
    placed = Reservoirs(_Placed(there.paths, places), r.W, r.M)
    c = reused_candidates(placed, luminance(there.paths.value), there.jacobian)
    return _Entry(donor, c, there.jacobian)


def _normalization(
    shift: Shift, entries: list[_Entry], chosen: Candidates, mis: Mis
) -> Scalars:
    """Confidences of those that could have made the path that was kept."""
    M_k = [entry.candidates.M for entry in entries]
    if mis == "1/M":
        return one_over_m(M_k)
    z, place = chosen.y.paths, chosen.y.place
    p_k: list[Scalars] = []
    p_made = chosen.p_hat
    for k, entry in enumerate(entries):
        mine = place == k
        if entry.donor.stands:
            p_k.append(chosen.p_hat)
            continue
        looks = (chosen.w > 0) & ~mine & (M_k[k] > 0)
        back = shift(entry.donor.world, entry.donor.points, z, looks)
        p = luminance(back.paths.value) * back.jacobian
        base = luminance(entry.donor.reservoirs.y.value)
        own = divide_or_zero(base, entry.jacobian)
        p_k.append(np.where(mine, own, p))
        p_made = np.where(mine, own, p_made)
    if mis == "balance":
        return balance_heuristic(M_k, p_k, p_made)
    return one_over_z(M_k, [p > 0 for p in p_k])
