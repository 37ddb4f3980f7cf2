"""The two halves of a frame: before, and after, pixels may read their neighbours."""

from dataclasses import dataclass, replace

import numpy as np

from reference.arrays import Masks, Vec3s
from reference.passes.checkerboard import samples_anew
from reference.passes.entries import Donors
from reference.passes.fused import fused_pass
from reference.passes.initial import InitialSamples, initial_samples, shares_all
from reference.passes.lattice import keeps_reservoir
from reference.passes.moment import Moment
from reference.passes.past import Past
from reference.passes.receivers import Receivers
from reference.passes.resample import Resampled
from reference.passes.shade import shade
from reference.passes.spatial import Neighborhood, spatial_pass
from reference.passes.storage import stored
from reference.passes.temporal import temporal_pass
from reference.records import cut
from reference.resampling.reservoir import Reservoirs
from reference.rng import Stream


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
    receivers, settings = moment.receivers(r), moment.settings
    drawn = _who_draws(moment, past, r)
    initial = _draw(moment, r, drawn)
    history = past.histories(r)[0] if past else None
    if settings.reuse == "fused":
        around, uniforms = _around(moment, past, r), moment.uniforms(Stream.SPATIAL, r)
        kept = fused_pass(receivers, initial, around, history, uniforms, drawn)
    else:
        uniforms = moment.uniforms(Stream.TEMPORAL, r)
        kept = temporal_pass(receivers, initial, history, uniforms, drawn)
    return Fresh(_stored(moment, r, kept), initial.unshared)


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
        history = past.histories(r)[1] if past else None
        around = _around(moment, past, r, fresh.kept.reservoirs)
        uniforms = moment.uniforms(Stream.SPATIAL, r)
        kept = spatial_pass(receivers, kept.reservoirs, around, history, uniforms)
    color = shade(moment.world, receivers.points, kept.reservoirs)
    seen = _finally_seen(receivers, past, kept, r)
    if seen is not None:
        color = np.where(seen[:, None], color, 0.0)
    spatial = _stored(moment, r, kept).reservoirs
    keeps = _who_keeps(moment, r)
    if keeps is not None:
        kept_M, kept_W = (np.where(keeps, a, 0.0) for a in (spatial.M, spatial.W))
        spatial = replace(spatial, M=kept_M, W=kept_W)
    return Shaded(spatial, color + fresh.unshared[r], seen)


def _who_draws(moment: Moment, past: Past | None, r: slice) -> Masks | None:
    """Who adds a new sample; ``None`` for everyone."""
    able = _who_keeps(moment, r)
    rows, width = np.arange(r.start, r.stop), moment.world.camera.width
    drawn = None
    if past and moment.validates:
        # The rays of this frame go into old samples, where there are.
        drawn = ~past.is_there(r)
    elif past and moment.settings.checkerboard:
        drawn = samples_anew(rows, width, moment.number, past.is_there(r))
    if able is None or drawn is None:
        return able if drawn is None else drawn
    return drawn & able


def _who_keeps(moment: Moment, r: slice) -> Masks | None:
    """Who keeps reservoirs; ``None`` for everyone."""
    side, width = moment.settings.lattice, moment.world.camera.width
    if side == 1:
        return None
    return keeps_reservoir(np.arange(r.start, r.stop), width, side)


def _draw(moment: Moment, r: slice, drawn: Masks | None) -> InitialSamples:
    settings, receivers = moment.settings, moment.receivers(r)
    numbers = moment.numbers(r)
    tail = moment.replay.tail
    # Light that is not reused is wanted of every pixel in every frame.
    idle = shares_all(moment.world, settings.source, settings.glossy_samples)
    return initial_samples(
        moment.world,
        receivers.points,
        settings.source,
        settings.glossy_samples,
        moment.bounces,
        moment.uniforms(Stream.INITIAL, r),
        moment.uniforms(Stream.PATH, r),
        moment.uniforms(Stream.SPECULAR, r),
        numbers if moment.remembers else None,
        tail(numbers) if tail else None,
        drawn if idle else None,
    )


def _around(
    moment: Moment, past: Past | None, r: slice, temporal: Reservoirs | None = None
) -> Neighborhood | None:
    """Where the neighbours of some pixels are looked for: in this frame or the last."""
    settings, rows = moment.settings, np.arange(r.start, r.stop)
    boosted = past.spatial if past and settings.boost_below else None
    if settings.reuse == "separate" and temporal:
        donors = Donors(moment.world, moment.visible, temporal)
        return Neighborhood(donors, rows, boosted, past.home if past else None)
    if past is None:
        return None
    if past.home is not None:
        rows = past.home[r]
    return Neighborhood(past.temporal, rows, boosted)


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
