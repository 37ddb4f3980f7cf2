"""The last frame, as the pixels of this one find it."""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from reference.arrays import Indices, Masks
from reference.passes.entries import Donors
from reference.passes.history import History
from reference.passes.home import find_home
from reference.passes.lattice import corner, keeps_reservoir
from reference.passes.moment import Frame, Moment
from reference.passes.passage import Passage, passage_between
from reference.passes.validation import validated
from reference.records import NONE, cut
from reference.resampling.reservoir import Reservoirs
from reference.resampling.suffix import age
from reference.scene.motion import carry
from reference.scene.surface import SurfacePoints, VisiblePoints
from reference.schedule import in_bands


@dataclass(frozen=True, slots=True, eq=False)
class Past:
    """What the last frame hands on, for the N pixels of this one.

    Attributes
    ----------
    temporal, spatial : Donors
        Reservoirs of the last frame.
    home : (N,) int or None
        Row of the last frame that each pixel goes on from, or ``NONE`` where it begins
        anew; ``None`` while every pixel is at its own place.
    as_they_stand : bool
        Reservoirs need no shift, or get none.
    seen : (N,) bool or None
        Final visibility in the last frame.
    """

    temporal: Donors
    spatial: Donors
    home: Indices | None
    as_they_stand: bool
    seen: Masks | None

    def is_there(self, r: slice) -> Masks:
        """Whether pixels go on from the last frame.

        Parameters
        ----------
        r : slice
            K pixels.

        Returns
        -------
        (K,) bool
            False where they begin anew.
        """
        if self.home is None:
            return np.ones(r.stop - r.start, bool)
        there: Masks = self.home[r] != NONE
        return there

    def histories(self, r: slice) -> tuple[History, History]:
        """Temporal and spatial history of some pixels.

        Parameters
        ----------
        r : slice
            K pixels.

        Returns
        -------
        History, History
            K rows each.
        """
        rows = r if self.home is None else self.home[r]
        stand = self.as_they_stand
        return History(self.temporal, rows, stand), History(self.spatial, rows, stand)


def past_of(moment: Moment, last: Frame | None) -> Past | None:
    """What the last frame hands on to this one.

    Parameters
    ----------
    moment : Moment
        This frame.
    last : Frame or None
        The last one.

    Returns
    -------
    Past or None
        ``None`` where nothing is reused over time.

    Notes
    -----
    [Ouyang21, section 5]: reprojection by motion vectors; where it fails, both
    reservoirs are reset.
    """
    settings = moment.settings
    if last is None or not settings.temporal:
        return None
    passage = passage_between(last.world, moment.world, moment.replay)
    home = None
    if passage or settings.permutation:
        home = find_home(moment, last, passage)
        home = _on_lattice(moment, home)
    as_stored = settings.motion == "as-stored"
    visible = last.visible
    if moment.validates:
        visible = _carried(passage, visible)

    def donors(r: Reservoirs) -> Donors:
        r = _without_old(moment, r)
        r = _validated(moment, visible.surface, r)
        return Donors(last.world, last.visible, r, None if as_stored else passage)

    temporal = donors(last.temporal)
    fused = last.spatial is last.temporal
    spatial = temporal if fused else donors(last.spatial)
    return Past(temporal, spatial, home, as_stored or home is None, last.seen)


def _on_lattice(moment: Moment, home: Indices) -> Indices:
    """Homes where reservoirs are, of pixels that keep some."""
    side, width = moment.settings.lattice, moment.world.camera.width
    if side == 1:
        return home
    keeps = keeps_reservoir(np.arange(moment.pixels), width, side)
    there = keeps & (home != NONE)
    return np.where(there, corner(np.maximum(home, 0), width, side), NONE)


def _carried(passage: Passage | None, visible: VisiblePoints) -> VisiblePoints:
    """Visible points of the last frame, where their shapes are in this one."""
    if passage is None or passage.forth is None:
        return visible
    surface = visible.surface
    shape = passage.before.geometry.shape[surface.primitive]
    position = carry(passage.forth, shape, surface.position)
    return replace(visible, surface=replace(surface, position=position))


def _without_old(moment: Moment, r: Reservoirs) -> Reservoirs:
    """Reservoirs without those whose sample is too old.

    Biased: which sample a reservoir keeps, and so its age, depends on its value.
    """
    limit = moment.settings.max_age
    if not isfinite(limit):
        return r
    assert r.y.suffix is not None
    young = age(r.y.suffix, moment.number, moment.pixels) <= limit
    return replace(r, W=np.where(young, r.W, 0.0), M=np.where(young, r.M, 0.0))


def _validated(moment: Moment, points: SurfacePoints, r: Reservoirs) -> Reservoirs:
    if not moment.validates:
        return r
    world, replay = moment.world, moment.replay
    tolerance = moment.settings.validation_tolerance
    return in_bands(
        moment.schedule,
        moment.pixels,
        lambda b: validated(world, cut(points, b), cut(r, b), replay, tolerance),
    )
