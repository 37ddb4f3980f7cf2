"""Where the visible points of a frame were a frame ago."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.passes.gbuffer import similar
from reference.passes.neighbors import NONE
from reference.records import take
from reference.scene.camera import image_points, view_depth
from reference.scene.motion import Motion, carry, turn
from reference.scene.surface import VisiblePoints
from reference.settings import Settings
from reference.world import World


def motion_vectors(
    before: World, world: World, visible: VisiblePoints, back: Motion | None
) -> tuple[Scalars, Scalars]:
    """How far the visible points have come in the image since the last frame.

    Parameters
    ----------
    before, world : World
        Of the last frame, and of this one.
    visible : VisiblePoints
        N visible points of this frame.
    back : Motion or None
        From this frame to the last.

    Returns
    -------
    (N,), (N,) float64, pixels
        To be subtracted from the place in this frame; NaN where nothing is seen, or
        the point was behind the camera.
    """
    surface = visible.surface
    shape = world.geometry.shape[surface.primitive]
    x, y = image_points(world.camera, surface.position)
    x_back, y_back = image_points(before.camera, carry(back, shape, surface.position))
    gone = ~surface.hit
    return np.where(gone, np.nan, x - x_back), np.where(gone, np.nan, y - y_back)


def reproject(
    before: World,
    seen_before: VisiblePoints,
    world: World,
    visible: VisiblePoints,
    back: Motion | None,
    settings: Settings,
) -> Indices:
    """Pixel of the last frame that saw what each pixel of this one sees.

    Parameters
    ----------
    before, world : World
        Of the last frame, and of this one.
    seen_before, visible : VisiblePoints
        G-buffers of both frames, N rows each.
    back : Motion or None
        From this frame to the last.
    settings : Settings
        Similarity of depths and normals.

    Returns
    -------
    (N,) int
        Row of the last frame, or ``NONE``: outside of the image, hidden then, or not
        similar; the pixel begins anew.

    Notes
    -----
    [Ouyang21, section 5].  The tests look at geometry alone, never at a sample.
    """
    surface, width = visible.surface, world.camera.width
    height = world.camera.height
    shape = world.geometry.shape[surface.primitive]
    position = carry(back, shape, surface.position)
    x, y = image_points(before.camera, position)
    inside = surface.hit & (x >= 0) & (x < width) & (y >= 0) & (y < height)
    column, line = (np.where(inside, v, 0.0).astype(np.int64) for v in (x, y))
    row = line * width + column
    alike = similar(
        turn(back, shape, surface.shading),
        np.where(inside, view_depth(before.camera, position), 0.0),
        take(seen_before.surface.shading, row),
        seen_before.depth[row],
        settings.max_angle,
        settings.max_depth,
    )
    return np.where(inside & alike, row, NONE)
