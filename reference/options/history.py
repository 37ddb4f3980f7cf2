"""What the last frame hands on, where something moves or is dropped."""

from dataclasses import replace
from math import isfinite

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.records import NONE, cut
from restir_gi.reference.numerics.schedule import in_bands
from restir_gi.reference.options.history_search import find_history
from restir_gi.reference.options.motion import (
    EarlierReservoirs,
    TemporalShift,
    temporal_shift,
)
from restir_gi.reference.options.reduced_resolution import corner, keeps_reservoir
from restir_gi.reference.options.replay import replay_of
from restir_gi.reference.options.validation import validated, validates
from restir_gi.reference.passes.pixels import FrameReservoirs, History
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.resampling.suffix import age
from restir_gi.reference.scene.motion import carry
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
from restir_gi.reference.settings import Settings


def moved_history(frame: FrameContext[Settings], last: History) -> History:
    """What the last frame hands on to this one.

    [Ouyang21, section 5]: reprojection by motion vectors; where it fails, both
    reservoirs are reset.

    Parameters
    ----------
    last : History; the last one as it was left

    Returns
    -------
    History
        Where each pixel goes on from; without samples that are too old or no longer
        what they were, as the settings say.
    """
    settings, before = frame.settings, last.temporal
    shift = temporal_shift(before.world, frame.world, replay_of(frame))
    pixel = None
    if shift or settings.permutation:
        reverse = shift.reverse if shift else None
        pixel = find_history(frame, before, reverse)
        pixel = _at_reduced_resolution(frame, pixel)
    as_stored = settings.motion == "as-stored"
    visible = before.visible
    if validates(frame):
        visible = _carried(shift, visible)

    def kept(r: FrameReservoirs) -> FrameReservoirs:
        young = _without_old(frame, r.reservoirs)
        reservoirs = _validated(frame, visible.surface, young)
        if as_stored or shift is None:
            return replace(r, reservoirs=reservoirs)
        return EarlierReservoirs(r.world, r.visible, reservoirs, shift)

    temporal = kept(last.temporal)
    one = last.spatial is last.temporal
    return replace(
        last,
        temporal=temporal,
        spatial=temporal if one else kept(last.spatial),
        pixel=pixel,
        shifted=pixel is not None and not as_stored,
    )


def _at_reduced_resolution(frame: FrameContext[Settings], pixel: Indices) -> Indices:
    """Pixels where reservoirs are, for pixels that keep some."""
    side, width = frame.settings.lattice, frame.world.camera.width
    if side == 1:
        return pixel
    keeps = keeps_reservoir(np.arange(frame.pixels), width, side)
    there = keeps & (pixel != NONE)
    return np.where(there, corner(np.maximum(pixel, 0), width, side), NONE)


def _carried(shift: TemporalShift | None, visible: VisiblePoints) -> VisiblePoints:
    """Visible points of the last frame, where their shapes are in this one."""
    if shift is None or shift.motion is None:
        return visible
    surface = visible.surface
    shape = shift.before.geometry.shape[surface.primitive]
    position = carry(shift.motion, shape, surface.position)
    return replace(visible, surface=replace(surface, position=position))


def _without_old(frame: FrameContext[Settings], r: Reservoirs) -> Reservoirs:
    """Reservoirs without those whose sample is too old.

    Biased: which sample a reservoir keeps, and so its age, depends on its value.
    """
    limit = frame.settings.max_age
    if not isfinite(limit):
        return r
    assert r.y.suffix is not None
    young = age(r.y.suffix, frame.number, frame.pixels) <= limit
    return replace(r, W=np.where(young, r.W, 0.0), M=np.where(young, r.M, 0.0))


def _validated(
    frame: FrameContext[Settings], points: SurfacePoints, r: Reservoirs
) -> Reservoirs:
    if not validates(frame):
        return r
    world, replay = frame.world, replay_of(frame)
    tolerance = frame.settings.validation_tolerance
    return in_bands(
        frame.schedule,
        frame.pixels,
        lambda b: validated(world, cut(points, b), cut(r, b), replay, tolerance),
    )
