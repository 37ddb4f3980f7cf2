"""Where each pixel of this frame goes on from in the last one."""

import numpy as np

from reference.arrays import Indices, Masks
from reference.passes.moment import Frame, Moment
from reference.passes.passage import Passage
from reference.passes.reproject import alike_before, places_before, row_at
from reference.passes.taps import nearby, permuted
from reference.records import NONE
from reference.rng import Stream

TAPS, REACH = 4, 4.0
"""Places that are tried where reprojection fails, and how far away, in pixels."""


def find_home(moment: Moment, last: Frame, passage: Passage | None) -> Indices:
    """Row of the last frame for each pixel of this one.

    Parameters
    ----------
    moment : Moment
        This frame.
    last : Frame
        The last one.
    passage : Passage or None
        Between the two.

    Returns
    -------
    (N,) int
        Or ``NONE``: the pixel begins anew.

    Notes
    -----
    [Ouyang21, section 5].  Geometry and time decide, and random numbers of no sample:
    so the choice of a history biases nothing, where it is then shifted.
    """
    back = passage.back if passage else None
    before, world, camera = last.world, moment.world, last.world.camera

    def alike(rows: Indices) -> Masks:
        return alike_before(
            before, last.visible, world, moment.visible, back, rows, moment.settings
        )

    x, y = places_before(before, world, moment.visible, back)
    home = row_at(x, y, before)
    if moment.settings.permutation:
        partner = permuted(home, camera.width, camera.height, moment.number)
        home = np.where(alike(partner), partner, home)
    home = np.where(alike(home), home, NONE)
    if moment.settings.fallback_search:
        uniforms = moment.uniforms(Stream.TEMPORAL, slice(0, moment.pixels))
        for tap in range(TAPS):
            u = uniforms.draw(1 + tap)
            found = row_at(*nearby(x, y, u, REACH), before)
            home = np.where((home == NONE) & alike(found), found, home)
    return home
