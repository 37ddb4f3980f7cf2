"""Generalized resampling: pixels take over whole paths from others."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from extensions.paths import Paths
from extensions.shifting import Shift
from reference.arrays import Indices, Scalars, Vec3s, divide_or_zero, zero_vectors
from reference.passes.neighbors import NONE
from reference.records import scatter, take, where
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


@dataclass(frozen=True, slots=True, eq=False)
class Donor:
    """A frame of reservoirs, of which K pixels are offered one each.

    Attributes
    ----------
    world : World
        In which the paths were made.
    points : SurfacePoints
        N visible points of that frame.
    reservoirs : Reservoirs
        N rows of `Paths`.
    rows : (K,) int
        Row that is offered to each pixel, or ``NONE``.
    stands : bool
        Donor and pixel are one point, and nothing is shifted.
    """

    world: World
    points: SurfacePoints
    reservoirs: Reservoirs
    rows: Indices
    stands: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class _Entry:
    """A competitor: its donor, candidates by their place, values, and Jacobians."""

    donor: Donor
    candidates: Candidates
    value: Vec3s
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
    z = _kept_paths(entries, chosen.y)
    total = _normalization(shift, entries, chosen, z, mis)
    kept = finalize(replace(chosen, y=z), total)
    return cap_confidence(kept, cap)


def _entry(
    shift: Shift, world: World, points: SurfacePoints, donor: Donor, place: int
) -> _Entry:
    there, row = donor.rows != NONE, np.maximum(donor.rows, 0)
    r, size = donor.reservoirs, len(points)
    W, M = np.where(there, r.W[row], 0.0), np.where(there, r.M[row], 0.0)
    offered = Reservoirs(np.full(size, place, np.int8), W, M)
    if donor.stands:
        value, jacobian = take(r.y.value, row), np.ones(size)
    else:
        at = np.flatnonzero((W > 0) & points.hit)
        base = take(r.y, row[at])
        some, factor = shift(world, take(points, at), base)
        value, jacobian = scatter(at, some, size), scatter(at, factor, size)
    c = reused_candidates(offered, luminance(value), jacobian)
    return _Entry(donor, c, value, jacobian)


def _kept_paths(entries: list[_Entry], place: Indices) -> Paths:
    """The paths that won, with their values here: one gather for each frame."""
    found: Paths | None = None
    value, factor = zero_vectors(len(place)), np.ones(len(place))
    for k, entry in enumerate(entries):
        here = place == k
        value = np.where(here[:, None], entry.value, value)
        factor = np.where(here, entry.jacobian, factor)
    for reservoirs, row in _by_frame(entries, place):
        part = take(reservoirs.y, np.maximum(row, 0))
        found = part if found is None else where(row != NONE, part, found)
    assert found is not None
    return found.moved(value, factor)


def _by_frame(
    entries: list[_Entry], place: Indices
) -> Iterable[tuple[Reservoirs, Indices]]:
    frames: dict[int, tuple[Reservoirs, Indices]] = {}
    for k, entry in enumerate(entries):
        reservoirs = entry.donor.reservoirs
        nowhere = np.full(len(place), NONE)
        _, rows = frames.get(id(reservoirs), (reservoirs, nowhere))
        chosen = np.where(place == k, entry.donor.rows, rows)
        frames[id(reservoirs)] = reservoirs, chosen
    return frames.values()


def _normalization(
    shift: Shift, entries: list[_Entry], chosen: Candidates, z: Paths, mis: Mis
) -> Scalars:
    """Confidences of those that could have made the path that was kept."""
    M_k = [entry.candidates.M for entry in entries]
    if mis == "1/M":
        return one_over_m(M_k)
    p_k, p_made = [], chosen.p_hat
    for k, entry in enumerate(entries):
        donor, mine = entry.donor, chosen.y == k
        if donor.stands:
            p_k.append(chosen.p_hat)
            continue
        at = np.flatnonzero((chosen.w > 0) & ~mine & (M_k[k] > 0))
        row = np.maximum(donor.rows, 0)
        there = take(donor.points, row[at])
        value, factor = shift(donor.world, there, take(z, at))
        p = scatter(at, luminance(value) * factor, len(mine))
        base = luminance(take(donor.reservoirs.y.value, row))
        own = divide_or_zero(base, entry.jacobian)
        p_k.append(np.where(mine, own, p))
        p_made = np.where(mine, own, p_made)
    if mis == "balance":
        return balance_heuristic(M_k, p_k, p_made)
    return one_over_z(M_k, [p > 0 for p in p_k])
