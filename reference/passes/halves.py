"""The two halves of a frame: before, and after, pixels may read their neighbours."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Masks, Vec3s
from reference.passes.competitions import (
    first_competition,
    second_competitions,
    who_keeps,
)
from reference.passes.moment import Moment
from reference.passes.past import Past
from reference.passes.receivers import Receivers
from reference.passes.resample import Resampled, resample, resample_each
from reference.passes.shade import shade
from reference.passes.storage import stored
from reference.records import cut
from reference.resampling.reservoir import Reservoirs


@dataclass(frozen=True, slots=True, eq=False)
class Fresh:
    """What the first half leaves, K rows.

    Attributes
    ----------
    kept : Resampled
        Temporal reservoirs, as they are stored.
    unshared : (K, 3) float64, W/(m² sr)
        Light that is not reused.
    """

    kept: Resampled
    unshared: Vec3s


@dataclass(frozen=True, slots=True, eq=False)
class Shaded:
    """What the second half leaves, K rows.

    Attributes
    ----------
    spatial : Reservoirs
        As they are stored.
    color : (K, 3) float64, W/(m² sr)
        Indirect light.
    seen : (K,) bool or None
        Final visibility, where it was asked for.
    """

    spatial: Reservoirs
    color: Vec3s
    seen: Masks | None


def reuses_neighbors(moment: Moment) -> bool:
    """Whether there is a spatial pass of its own.

    Parameters
    ----------
    moment : Moment
        This frame.

    Returns
    -------
    bool
        Not where spatial reuse is off, or fused with the temporal one.
    """
    return moment.settings.spatial and moment.settings.reuse != "fused"


def samples_and_temporal(moment: Moment, past: Past | None, r: slice) -> Fresh:
    """Draw samples, and resample them with what the last frame left.

    Parameters
    ----------
    moment : Moment
        This frame.
    past : Past or None
        The last one.
    r : slice
        K pixels.

    Returns
    -------
    Fresh
        K rows.

    Notes
    -----
    [Ouyang21, Alg. 2 and 3].
    """
    competition, unshared = first_competition(moment, past, r)
    return Fresh(_stored(moment, r, resample(competition)), unshared)


def spatial_and_shade(
    moment: Moment, past: Past | None, fresh: Fresh, r: slice
) -> Shaded:
    """Resample what neighbours keep, and shade.

    Parameters
    ----------
    moment : Moment
        This frame.
    past : Past or None
        The last one.
    fresh : Fresh
        First half of the whole frame.
    r : slice
        K pixels.

    Returns
    -------
    Shaded
        K rows.

    Notes
    -----
    [Ouyang21, Alg. 4 and Eq. 8].
    """
    receivers, kept = moment.receivers(r), cut(fresh.kept, r)
    if reuses_neighbors(moment):
        temporal = fresh.kept.reservoirs
        kept = resample_each(second_competitions(moment, past, temporal, r))
    color = shade(moment.world, receivers.points, kept.reservoirs)
    seen = _finally_seen(receivers, past, kept, r)
    if seen is not None:
        color = np.where(seen[:, None], color, 0.0)
    spatial = _stored(moment, r, kept).reservoirs
    keeps = who_keeps(moment, r)
    if keeps is not None:
        kept_M, kept_W = (np.where(keeps, a, 0.0) for a in (spatial.M, spatial.W))
        spatial = replace(spatial, M=kept_M, W=kept_W)
    return Shaded(spatial, color + fresh.unshared[r], seen)


def _stored(moment: Moment, r: slice, kept: Resampled) -> Resampled:
    points, storage = cut(moment.visible.surface, r), moment.settings.storage
    reservoirs = stored(storage, points, kept.reservoirs, moment.pixels)
    return replace(kept, reservoirs=reservoirs)


def _finally_seen(
    receivers: Receivers, past: Past | None, kept: Resampled, r: slice
) -> Masks | None:
    """Whether pixels see the sample that they show; ``None``: that is part of W."""
    how, full = receivers.settings.final_visibility, kept.reservoirs.W > 0
    if how == "in-weight":
        return None
    known = np.zeros(len(full), bool)
    before = known
    if how == "reused" and past and past.seen is not None:
        # What came from the pixel's own past was looked at when it came.
        known = past.is_there(r) & (kept.place == 0)
        home = r if past.home is None else np.maximum(past.home[r], 0)
        before = known & past.seen[home]
    return before | receivers.see(kept.reservoirs.y, full & ~known)
