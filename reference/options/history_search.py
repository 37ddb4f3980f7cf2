"""Where each pixel finds its history: reprojection, permutation, fallback search."""

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.numerics.rng import Draw, Stream
from restir_gi.reference.options.reprojection import alike_before, places_before, row_at
from restir_gi.reference.passes.pixels import FrameReservoirs
from restir_gi.reference.scene.motion import Motion
from restir_gi.reference.settings import Settings

ATTEMPTS, REACH = 4, 4.0
"""Places that are tried where reprojection fails, and how far away, in pixels."""

FLIP = 3
"""Bits of x and y that are turned over: a permutation within blocks of 4 x 4 pixels."""


def permuted(rows: Indices, width: int, height: int, frame: int) -> Indices:
    """Pixels shuffled within blocks of 4 x 4, which lie elsewhere in each frame.

    It breaks up the patterns of history that stays with its pixel.  Place and time
    alone decide.

    Parameters
    ----------
    rows : (N,) int; pixels of the last frame, or ``NONE``
    frame : int; from 0

    Returns
    -------
    (N,) int
        The pixel's partner, whose own partner it is; itself where that would lie
        outside of the image; ``NONE`` stays.
    """
    shift_x, shift_y = frame % 4, frame // 4 % 4
    y, x = np.divmod(np.maximum(rows, 0), width)
    x_to = ((x + shift_x) ^ FLIP) - shift_x
    y_to = ((y + shift_y) ^ FLIP) - shift_y
    inside = (x_to >= 0) & (x_to < width) & (y_to >= 0) & (y_to < height)
    partner = np.where(inside, y_to * width + x_to, rows)
    return np.where(rows == NONE, NONE, partner)


def nearby(x: Scalars, y: Scalars, u: Draw, radius: float) -> tuple[Scalars, Scalars]:
    """A random place near a place of the image.

    Parameters
    ----------
    x, y : (N,) float64, pixels; places, NaN where there is none
    u : four (N,) float64; lanes 0 and 1
    radius : float, pixels; half of the side of the square that is searched

    Returns
    -------
    (N,), (N,) float64, pixels; also outside of the image
    """
    return x + radius * (2.0 * u[0] - 1.0), y + radius * (2.0 * u[1] - 1.0)


def find_history(
    frame: FrameContext[Settings], last: FrameReservoirs, reverse: Motion | None
) -> Indices:
    """Pixel of the last frame that each pixel of this one goes on from.

    [Ouyang21, section 5].  Geometry and time decide, and random numbers of no sample:
    so the choice of a history biases nothing, where it is then shifted.

    Parameters
    ----------
    reverse : Motion or None; of the shapes, from this frame to the last

    Returns
    -------
    (N,) int; or ``NONE``: the pixel starts over
    """
    before, world, camera = last.world, frame.world, last.world.camera

    def alike(rows: Indices) -> Masks:
        return alike_before(
            before, last.visible, world, frame.visible, reverse, rows, frame.settings
        )

    x, y = places_before(before, world, frame.visible, reverse)
    found = row_at(x, y, before)
    if frame.settings.permutation:
        partner = permuted(found, camera.width, camera.height, frame.number)
        found = np.where(alike(partner), partner, found)
    found = np.where(alike(found), found, NONE)
    if frame.settings.fallback_search:
        uniforms = frame.uniforms(Stream.TEMPORAL, slice(0, frame.pixels))
        for attempt in range(ATTEMPTS):
            u = uniforms.draw(1 + attempt)
            nearest = row_at(*nearby(x, y, u, REACH), before)
            found = np.where((found == NONE) & alike(nearest), nearest, found)
    return found
