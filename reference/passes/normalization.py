"""Lines 16 to 20 of Algorithm 4: who else could have made the sample that was kept."""

from dataclasses import dataclass

import numpy as np

from reference.arrays import Indices, Masks, Scalars
from reference.passes.initial import source_pdf
from reference.passes.neighbors import NONE
from reference.records import take
from reference.resampling.mis import balance_heuristic, one_over_m, one_over_z
from reference.resampling.reservoir import Candidates, Reservoirs, Samples
from reference.resampling.shift import reconnection_jacobian
from reference.resampling.target import target
from reference.scene.surface import SurfacePoints, VisiblePoints, direction_and_distance
from reference.settings import Settings
from reference.world import World

HISTORY, OWN = 0, 1
"""Slots of the stream: the pixel's spatial and temporal reservoirs, then neighbours."""


@dataclass(frozen=True, slots=True)
class Stream:
    """Who takes part in a pixel's spatial resampling, K rows.

    Attributes
    ----------
    donors : list of (K,) int
        Row of each slot, ``NONE`` where it is empty.
    M : list of (K,) float64
        Confidence of each slot, 0 where it is empty.
    chosen : Candidates
        ``y`` is the slot whose sample was kept.
    """

    donors: list[Indices]
    M: list[Scalars]
    chosen: Candidates


def normalization(
    world: World,
    points: SurfacePoints,
    visible: VisiblePoints,
    settings: Settings,
    stream: Stream,
    y: Samples,
) -> Scalars:
    """Divide the sum of weights by this: M, Z, or the balance heuristic's sum.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        K visible points that have resampled.
    visible : VisiblePoints
        Of the whole frame.
    settings : Settings
        Kind of weight, target and source density.
    stream : Stream
        Who took part.
    y : Samples
        The samples that were kept.

    Returns
    -------
    (K,) float64
        1 where nothing was kept.

    Notes
    -----
    The domain D_k of a donor holds y where k's source density and target are positive
    and k sees y: ``p̂ > 0`` alone says nothing with the target of Equation 10.
    """
    if settings.mis == "1/M":
        return one_over_m(stream.M)
    rows = np.flatnonzero(stream.chosen.w > 0)
    z, receiver = take(y, rows), take(points, rows)
    slot = stream.chosen.y[rows]
    everywhere = np.ones(len(rows), bool)
    holds, p = [everywhere, everywhere], [stream.chosen.p_hat[rows]] * 2
    M = [m[rows] for m in stream.M]
    for k in range(2, len(stream.donors)):
        donor = stream.donors[k][rows]
        some = np.flatnonzero(donor != NONE)
        lender = take(visible.surface, donor[some])
        made = slot[some] == k
        at_k = _target_of_maker(world, settings, lender, take(z, some), made)
        holds_k, p_k = np.zeros(len(rows), bool), np.zeros(len(rows))
        holds_k[some] = at_k > 0
        if settings.mis == "balance":
            z_some = take(z, some)
            p_k[some] = at_k * reconnection_jacobian(
                receiver.position[some], lender.position, z_some.position, z_some.normal
            )
        holds.append(holds_k)
        p.append(p_k)
    if settings.mis == "1/Z":
        total = one_over_z(M, holds)
    else:
        made_by = np.stack(p)[slot, np.arange(len(rows))]
        total = balance_heuristic(M, p, made_by)
    whole = np.ones(len(points))
    whole[rows] = total
    return whole


def _target_of_maker(
    world: World, settings: Settings, k: SurfacePoints, z: Samples, made: Masks
) -> Scalars:
    """Target of z at donors k, and 0 where k could not have made z."""
    p_hat = target(settings.target, world.materials, k, z)
    omega, _ = direction_and_distance(k.position, z.position)
    possible = source_pdf(settings.source, world.materials, k, omega) > 0
    p_hat = np.where(possible, p_hat, 0.0)
    # Who made it sees it: only the others cost a ray.
    rows = np.flatnonzero((p_hat > 0) & ~made)
    hidden = np.zeros(len(made), bool)
    hidden[rows] = ~sees(world, take(k, rows), take(z, rows))
    return np.where(hidden, 0.0, p_hat)


def sees(world: World, points: SurfacePoints, y: Samples) -> Masks:
    """Whether visible points see sample points: one ray each.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        K visible points.
    y : Samples
        K sample points.

    Returns
    -------
    (K,) bool
        Nothing lies between.
    """
    return world.caster.visible(points, y.position, y.normal, "reuse")


def drop_hidden(world: World, points: SurfacePoints, r: Reservoirs) -> Reservoirs:
    """Empty the reservoirs whose sample their visible point does not see.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        K visible points.
    r : Reservoirs
        Their reservoirs.

    Returns
    -------
    Reservoirs
        W = 0 where the sample is hidden; M still counts.
    """
    rows = np.flatnonzero(r.W > 0)
    seen = np.zeros(len(r.W), bool)
    seen[rows] = sees(world, take(points, rows), take(r.y, rows))
    return Reservoirs(y=r.y, W=np.where(seen, r.W, 0.0), M=r.M)
