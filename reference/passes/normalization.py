"""Lines 16 to 20 of Algorithm 4: who else could have made the sample that was kept."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Indices, Masks, Scalars, dot
from reference.passes.initial import source_pdf
from reference.passes.neighbors import NONE
from reference.records import take
from reference.resampling.mis import balance_heuristic, one_over_m, one_over_z
from reference.resampling.reservoir import Candidates, Reservoirs, Samples
from reference.resampling.shift import reconnection_jacobian
from reference.resampling.target import target
from reference.scene.surface import (
    SurfacePoints,
    Viewpoints,
    VisiblePoints,
    direction_and_distance,
)
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
    x : list of Viewpoints
        Visible point of each slot.
    M : list of (K,) float64
        Confidence of each slot, 0 where it is empty.
    chosen : Candidates
        ``y`` is the slot whose sample was kept.
    """

    donors: list[Indices]
    x: list[Viewpoints]
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
        Meaningless where nothing was kept, w = 0.

    Notes
    -----
    The domain D_k of a donor holds y where k's source density and target are positive
    and k sees y: ``p̂ > 0`` alone says nothing with the target of Equation 10.
    """
    if settings.mis == "1/M":
        return one_over_m(stream.M)
    chosen, everyone = stream.chosen, np.ones(len(points), bool)
    holds, p = [everyone, everyone], [chosen.p_hat, chosen.p_hat]
    for k in range(2, len(stream.donors)):
        there = stream.donors[k] != NONE
        donor = np.where(there, stream.donors[k], 0)
        x_k = stream.x[k]
        p_k = _target_of_donor(world, visible.surface, settings, donor, x_k, y)
        # Who made the sample sees it: only the others cost a ray.
        possible = there & (p_k > 0) & (chosen.w > 0)
        made = possible & (chosen.y == k)
        holds.append(made | sees(world, x_k, y, possible & ~made))
        if settings.mis == "balance":
            p_k = p_k * reconnection_jacobian(
                points.position, x_k.position, y.position, y.normal
            )
            p.append(np.where(holds[k], p_k, 0.0))
    if settings.mis == "1/Z":
        return one_over_z(stream.M, holds)
    made_by = np.stack(p)[chosen.y, np.arange(len(points))]
    return balance_heuristic(stream.M, p, made_by)


def _target_of_donor(
    world: World,
    surface: SurfacePoints,
    settings: Settings,
    donor: Indices,
    x: Viewpoints,
    y: Samples,
) -> Scalars:
    """Target of y at donors, 0 where they cannot draw it, whoever may hide it."""
    if world.materials.plain and settings.mis == "1/Z":
        # Every point here is black or reflects all colours to its whole horizon, so
        # that whether the target is positive is a question of geometry.
        toward = y.position - x.position
        holds = dot(y.normal, toward) < 0
        holds &= surface.color[donor, 0] > 0
        holds &= dot(take(surface.normal, donor), toward) > 0
        if surface.smooth is not None:
            holds &= dot(take(surface.smooth, donor), toward) > 0
        return holds.astype(float)
    k = take(surface, donor)
    omega, _ = direction_and_distance(k.position, y.position)
    possible = source_pdf(settings.source, world.materials, k, omega) > 0
    p_hat = target(settings.target, world.materials, k, y)
    return np.where(possible, p_hat, 0.0)


def sees(
    world: World, points: SurfacePoints | Viewpoints, y: Samples, active: Masks
) -> Masks:
    """Whether visible points see sample points: one ray each.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints or Viewpoints
        N visible points.
    y : Samples
        N sample points.
    active : (N,) bool
        Who looks.

    Returns
    -------
    (N,) bool
        Nothing lies between; false where nobody looks.
    """
    return world.caster.visible(points, y.position, y.normal, active, "reuse")


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
    seen = sees(world, points, r.y, r.W > 0)
    return replace(r, W=np.where(seen, r.W, 0.0))
