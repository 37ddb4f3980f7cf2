"""Fractional motion vectors of pairs: both pixels move with the nearer one."""

import numpy as np

from extensions.frame_loop import Moment, PathFrame
from extensions.windows import Window, windows
from gradient_domain.pairs import Pairs, pair_at
from reference.arrays import Indices
from reference.records import NONE
from reference.scene.surface import VisiblePoints


def pivots(pairs: Pairs, visible: VisiblePoints) -> Indices:
    """The nearer pixel of each pair.

    [Wang25, section 4.3.1]: what is behind may have been hidden.

    Returns
    -------
    (K,) int
        Row of the pixel; one that sees nothing is the farther one, and the first is
        taken where both are alike.
    """
    depth = np.where(visible.surface.hit, visible.depth, np.inf)
    second = depth[pairs.second] < depth[pairs.first]
    return np.where(second, pairs.second, pairs.first)


def pair_windows(last: PathFrame, moment: Moment, pairs: Pairs) -> list[Window]:
    """Where pairs were a frame ago.

    Parameters
    ----------
    last : PathFrame; the frame before

    Returns
    -------
    list of Window
        Up to four; rows are those of the pairs of the last frame that have the pivot
        where this pair has it.
    """
    camera = last.world.camera
    pivot = pivots(pairs, moment.visible)
    second = pivot != pairs.first
    back_x, back_y = (
        np.where(second, step, 0).astype(np.int64) for step in (pairs.dx, pairs.dy)
    )
    found = []
    for part in windows(last, moment, pivot):
        y, x = np.divmod(part.rows, camera.width)
        size = camera.width, camera.height
        rows = pair_at(pairs.axis, x - back_x, y - back_y, *size)
        rows = np.where(part.rows != NONE, rows, NONE)
        share = np.where(rows != NONE, part.share, 0.0)
        found.append(Window(rows, part.dx, part.dy, share))
    return found
