"""Fractional motion vectors: the parts of the last image that an area now covers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.extensions.frame_loop import PathFrame
from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.options.reprojection import alike_before, places_before, row_at
from restir_gi.reference.resampling.generalized import (
    SourceReservoirs,
    Target,
    resample,
)
from restir_gi.reference.resampling.reservoir import Reservoirs, cap_confidence


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """A pixel of the last image that the past of each of K pixels overlaps.

    Attributes
    ----------
    rows : (K,) int; of the last frame, or ``NONE``
    dx, dy : (K,) float64, pixels; how far places have moved since
    share : (K,) float64
        Of the pixel's area, 0 without a past; of all windows together at most 1.
    """

    rows: Indices
    dx: Scalars
    dy: Scalars
    share: Scalars


def windows(
    frame: FrameContext[PathSettings], last: PathFrame, pixel: Indices
) -> list[Window]:
    """Where the areas of pixels were a frame ago.

    [Zhang24].  What the centres see decides, never a sample.

    Parameters
    ----------
    pixel : (K,) int; rows of the image

    Returns
    -------
    list of Window
        The four pixels around, whose parts of the area are disjoint; the pixel itself
        where nothing has moved.
    """
    if last.world is frame.world:
        none = np.zeros(len(pixel))
        return [Window(pixel, none, none, none + 1.0)]
    visible, width = take(frame.visible, pixel), frame.world.camera.width
    x_now, y_now = pixel % width + 0.5, pixel // width + 0.5
    x, y = places_before(last.world, frame.world, visible, None)
    left, top = np.floor(x - 0.5), np.floor(y - 0.5)
    found = []
    for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
        column, line = left + i, top + j
        rows = row_at(column + 0.5, line + 0.5, last.world)
        seen = last.world, last.visible, frame.world, visible
        usable = alike_before(*seen, None, rows, frame.settings)
        overlap = (1.0 - np.abs(column + 0.5 - x)) * (1.0 - np.abs(line + 0.5 - y))
        rows = np.where(usable & (overlap > 0), rows, NONE)
        share = np.where(rows != NONE, overlap, 0.0)
        found.append(Window(rows, x_now - x, y_now - y, share))
    return found


def resample_past(
    own: SourceReservoirs,
    before: Sequence[SourceReservoirs],
    shares: Sequence[Scalars],
    decisions: list[Scalars],
    settings: PathSettings,
    target: Target,
) -> Reservoirs:
    """Resample the windows of each area's history, and what is new.

    Parameters
    ----------
    own : SourceReservoirs; the new samples, in their own domain
    shares : list of (K,); of the area, one for each neighbour of the last frame
    decisions : list of (K,)
        One number in [0, 1) for each of them, and for the new samples at last.
    """
    M = own.reservoirs.M
    for q_n, share in zip(before, shares, strict=True):
        # Windows are parts of one area: what they know of it are means, not sums.
        M = M + q_n.reservoirs.M[np.maximum(q_n.rows, 0)] * share
    kept = resample([*before, own], decisions, settings.mis, np.inf, target)
    return cap_confidence(replace(kept, M=M), settings.temporal_cap)
