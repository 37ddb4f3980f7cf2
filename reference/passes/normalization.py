"""Lines 16 to 20 of Algorithm 4: who else could have made the sample that was kept."""

from dataclasses import replace

import numpy as np

from reference.arrays import Masks, Scalars, dot
from reference.passes.entries import Entry, Origin
from reference.passes.initial import source_pdf
from reference.passes.receivers import Receivers, sees
from reference.passes.shifting import mirrored
from reference.records import NONE, take
from reference.resampling.mis import balance_heuristic, one_over_m, one_over_z
from reference.resampling.reservoir import Candidates, Reservoirs, Samples
from reference.resampling.shift import reconnection_jacobian
from reference.resampling.target import target
from reference.scene.surface import direction_and_distance


def normalization(
    receivers: Receivers, entries: list[Entry], chosen: Candidates, y: Samples
) -> Scalars:
    """Divide the sum of weights by this: M, Z, or the balance heuristic's sum.

    Parameters
    ----------
    receivers : Receivers
        K pixels that have resampled.
    entries : list of Entry
        Who took part.
    chosen : Candidates
        ``y`` is the place of the entry whose sample was kept.
    y : Samples
        The samples that were kept.

    Returns
    -------
    (K,) float64
        Meaningless where nothing was kept, w = 0; 1 where the weights were divided
        before, in pairs.

    Notes
    -----
    The domain D_k of a donor holds y where k's source density and target are positive
    and k sees y, in the frame that k's reservoir is of: ``p̂ > 0`` alone says nothing
    with the target of Equation 10.
    """
    mis, M_k = receivers.settings.mis, [entry.candidate.M for entry in entries]
    if mis == "1/M" or not any(entry.origin for entry in entries):
        return one_over_m(M_k)
    if mis in ("pairwise", "defensive"):
        return np.ones_like(chosen.w)
    holds, p = who_holds(receivers, entries, chosen, y)
    if mis == "1/Z":
        return one_over_z(M_k, holds)
    made_by = np.stack(p)[chosen.y, np.arange(len(chosen.w))]
    return balance_heuristic(M_k, p, made_by)


def who_holds(
    receivers: Receivers, entries: list[Entry], chosen: Candidates, y: Samples
) -> tuple[list[Masks], list[Scalars]]:
    """Whose domains hold the samples that were kept.

    Parameters
    ----------
    receivers, entries, chosen, y
        As for `normalization`.

    Returns
    -------
    list of (K,) bool, list of (K,) float64
        For each entry whether it could have made the sample, and :func:`target_from`.
    """
    kept = chosen.w > 0
    everyone = np.ones(len(kept), bool)
    holds, p = [], []
    for place, entry in enumerate(entries):
        if entry.origin is None:
            holds.append(everyone)
            p.append(chosen.p_hat)
            continue
        # Who made the sample sees it: only the others cost a ray.
        made = kept & (chosen.y == place)
        p_k = target_from(receivers, entry.origin, y, kept, made)
        holds.append(p_k > 0)
        p.append(p_k)
    return holds, p


def target_from(
    receivers: Receivers, origin: Origin, y: Samples, active: Masks, made: Masks
) -> Scalars:
    """Target of samples at donors, in the measure of the receivers.

    p_k(y) |∂ω_k / ∂ω_receiver| in the domain D_k, and 0 outside of it.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    origin : Origin
        A donor of each.
    y : Samples
        K samples at the receivers.
    active : (K,) bool
        Whose answer is wanted; 0 for the others.
    made : (K,) bool
        The donor made the sample, so that it sees it.

    Returns
    -------
    (K,) float64, radiance/sr
        With the weight 1/Z, which asks no more than that, any positive number.
    """
    settings, donors, x_k = receivers.settings, origin.donors, origin.x
    only_whether = settings.mis == "1/Z"
    active = active & (origin.rows != NONE)
    if only_whether:
        active &= ~made
    x = receivers.points.position
    # As it was in the donors' frame, and the receiver beside it.
    if donors.passage:
        x = donors.passage.beside_before(y, x)
        y = donors.passage.depart(y, active)
    p = _unshadowed(receivers, origin, y)
    possible = active & (p > 0)
    usable = mirrored(settings, x_k.position, x, y)
    if usable is not None:
        possible &= usable
    seen = made | sees(donors.world, x_k, y, possible & ~made)
    if only_whether:
        return seen.astype(float)
    p = p * reconnection_jacobian(x, x_k.position, y.position, y.normal)
    return np.where(possible & seen, p, 0.0)


def _unshadowed(receivers: Receivers, origin: Origin, y: Samples) -> Scalars:
    """Target of y at donors, 0 where they cannot draw it, whoever may hide it."""
    settings, materials = receivers.settings, receivers.world.materials
    surface, x = origin.donors.visible.surface, origin.x
    donor = np.where(origin.rows != NONE, origin.rows, 0)
    if materials.plain and settings.mis == "1/Z":
        # Every point here is black or reflects all colours to its whole horizon, so
        # that whether the target is positive is a question of geometry.
        toward = y.position - x.position
        holds = dot(y.normal, toward) < 0
        # A black point draws samples as others do, and Equation 10 does not mind it.
        if settings.target == "scattered" or settings.source == "bsdf":
            holds &= surface.color[donor, 0] > 0
        holds &= dot(take(surface.normal, donor), toward) > 0
        if surface.smooth is not None:
            holds &= dot(take(surface.smooth, donor), toward) > 0
        if origin.donors.passage:  # at another time it may not have shone
            holds &= y.radiance.any(axis=1)
        return holds.astype(float)
    k = take(surface, donor)
    omega, _ = direction_and_distance(k.position, y.position)
    possible = source_pdf(settings.source, materials, k, omega) > 0
    return np.where(possible, target(settings.target, materials, k, y), 0.0)


def drop_hidden(receivers: Receivers, r: Reservoirs) -> Reservoirs:
    """Empty the reservoirs whose sample their visible point does not see.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    r : Reservoirs
        Their reservoirs.

    Returns
    -------
    Reservoirs
        W = 0 where the sample is hidden; M still counts.
    """
    seen = receivers.see(r.y, r.W > 0)
    return replace(r, W=np.where(seen, r.W, 0.0))
