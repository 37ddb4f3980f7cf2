"""Where the visible points of a frame were a frame ago."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.passes.gbuffer import similar
from restir_gi.reference.scene.camera import image_points, view_depth
from restir_gi.reference.scene.motion import Motion, carry, turn
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.settings import Search
from restir_gi.reference.transport.world import World


def places_before(
    before: World, world: World, visible: VisiblePoints, back: Motion | None
) -> tuple[Scalars, Scalars]:
    """Where the visible points of this frame were in the image of the last.

    Parameters
    ----------
    before, world : World; of the last frame, and of this one
    back : Motion or None; from this frame to the last

    Returns
    -------
    (N,), (N,) float64, pixels
        Also outside of the image; NaN where nothing is seen, or the point was behind
        the camera.
    """
    surface = visible.surface
    shape = world.geometry.shape[surface.primitive]
    x, y = image_points(before.camera, carry(back, shape, surface.position))
    return np.where(surface.hit, x, np.nan), np.where(surface.hit, y, np.nan)


def motion_vectors(
    before: World, world: World, visible: VisiblePoints, back: Motion | None
) -> tuple[Scalars, Scalars]:
    """How far the visible points have come in the image since the last frame.

    Parameters
    ----------
    before, world : World; of the last frame, and of this one
    back : Motion or None; from this frame to the last

    Returns
    -------
    (N,), (N,) float64, pixels
        To be subtracted from the place in this frame; NaN where nothing is seen, or
        the point was behind the camera.
    """
    x, y = image_points(world.camera, visible.surface.position)
    x_back, y_back = places_before(before, world, visible, back)
    return x - x_back, y - y_back


def row_at(x: Scalars, y: Scalars, world: World) -> Indices:
    """Pixels that hold places of the image.

    Parameters
    ----------
    x, y : (N,) float64, pixels; places, NaN where there is none

    Returns
    -------
    (N,) int; row, or ``NONE`` outside of the image
    """
    width, height = world.camera.width, world.camera.height
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    column, line = (np.where(inside, v, 0.0).astype(np.int64) for v in (x, y))
    return np.where(inside, line * width + column, NONE)


def alike_before(
    before: World,
    seen_before: VisiblePoints,
    world: World,
    visible: VisiblePoints,
    back: Motion | None,
    rows: Indices,
    settings: Search,
) -> Masks:
    """Whether pixels of the last frame saw something like what each pixel sees now.

    Parameters
    ----------
    before, world : World; of the last frame, and of this one
    seen_before, visible : VisiblePoints; G-buffers of both frames, N rows each
    back : Motion or None; from this frame to the last
    rows : (N,) int; pixels of the last frame, or ``NONE``

    Returns
    -------
    (N,) bool; False where there is no pixel, or either saw nothing
    """
    surface, row = visible.surface, np.maximum(rows, 0)
    shape = world.geometry.shape[surface.primitive]
    depth = view_depth(before.camera, carry(back, shape, surface.position))
    alike = similar(
        turn(back, shape, surface.shading),
        np.where(surface.hit, depth, 0.0),
        take(seen_before.surface.shading, row),
        seen_before.depth[row],
        settings.max_angle,
        settings.max_depth,
    )
    found: Masks = alike & (rows != NONE)
    return found


def reproject(
    before: World,
    seen_before: VisiblePoints,
    world: World,
    visible: VisiblePoints,
    back: Motion | None,
    settings: Search,
) -> Indices:
    """Pixel of the last frame that saw what each pixel of this one sees.

    [Ouyang21, section 5].  The tests look at geometry alone, never at a sample.

    Parameters
    ----------
    before, world : World; of the last frame, and of this one
    seen_before, visible : VisiblePoints; G-buffers of both frames, N rows each
    back : Motion or None; from this frame to the last

    Returns
    -------
    (N,) int
        Row of the last frame, or ``NONE``: outside of the image, hidden then, or not
        similar; the pixel starts over.
    """
    row = row_at(*places_before(before, world, visible, back), before)
    alike = alike_before(before, seen_before, world, visible, back, row, settings)
    return np.where(alike, row, NONE)
