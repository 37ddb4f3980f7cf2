"""Who competes for the pixels of a frame: in its first half, and in its second."""

from collections.abc import Iterator

import numpy as np

from reference.arrays import Indices, Masks, Vec3s
from reference.passes.checkerboard import samples_anew
from reference.passes.entries import Donors
from reference.passes.fused import fused_competition
from reference.passes.initial import InitialSamples, initial_samples, shares_all
from reference.passes.lattice import keeps_reservoir
from reference.passes.moment import Moment
from reference.passes.past import Past
from reference.passes.resample import Competition
from reference.passes.spatial import Neighborhood, spatial_competitions
from reference.passes.temporal import temporal_competition
from reference.records import cut
from reference.resampling.reservoir import Reservoirs
from reference.rng import Stream


def first_competition(
    moment: Moment, past: Past | None, r: slice
) -> tuple[Competition, Vec3s]:
    """Draw samples, and let them compete with what the last frame left.

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
    Competition, (K, 3) float64, W/(m² sr)
        Of the temporal pass, or of the one that does all; and light that is not reused.
    """
    receivers = moment.receivers(r)
    drawn = _who_draws(moment, past, r)
    initial = _draw(moment, r, drawn)
    history = past.histories(r)[0] if past else None
    if moment.settings.reuse == "fused":
        around, uniforms = _around(moment, past, r), moment.uniforms(Stream.SPATIAL, r)
        competition = fused_competition(
            receivers, initial, around, history, uniforms, drawn
        )
    else:
        uniforms = moment.uniforms(Stream.TEMPORAL, r)
        competition = temporal_competition(receivers, initial, history, uniforms, drawn)
    return competition, initial.unshared


def second_competitions(
    moment: Moment, past: Past | None, temporal: Reservoirs, r: slice
) -> Iterator[tuple[Indices, Competition]]:
    """Let what neighbours keep compete.

    Parameters
    ----------
    moment : Moment
        This frame.
    past : Past or None
        The last one.
    temporal : Reservoirs
        Of the whole frame.
    r : slice
        K pixels.

    Returns
    -------
    iterator of ((J,) int, Competition)
        Of the spatial pass; :func:`reference.passes.spatial.spatial_competitions`.
    """
    history = past.histories(r)[1] if past else None
    around = _around(moment, past, r, temporal)
    uniforms = moment.uniforms(Stream.SPATIAL, r)
    return spatial_competitions(
        moment.receivers(r), cut(temporal, r), around, history, uniforms
    )


def who_keeps(moment: Moment, r: slice) -> Masks | None:
    """Who keeps reservoirs.

    Parameters
    ----------
    moment : Moment
        This frame.
    r : slice
        K pixels.

    Returns
    -------
    (K,) bool or None
        ``None`` for everyone.
    """
    side, width = moment.settings.lattice, moment.world.camera.width
    if side == 1:
        return None
    return keeps_reservoir(np.arange(r.start, r.stop), width, side)


def _who_draws(moment: Moment, past: Past | None, r: slice) -> Masks | None:
    """Who adds a new sample; ``None`` for everyone."""
    able = who_keeps(moment, r)
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
