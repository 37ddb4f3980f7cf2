"""Gradient-domain path tracing: paths of both pixels of a pair, each shifted once."""

from collections.abc import Iterator

from restir_gi.extensions.area_restir import area_drawn
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.frame_loop import PathFrame, path_frames
from restir_gi.gradient_domain.gradient_restir import (
    GradientFrame,
    estimate,
    gradient_frame,
    paired_both,
)
from restir_gi.gradient_domain.pairs import pixel_pairs
from restir_gi.gradient_domain.settings import GradientPathSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.transport.world import World


def render_gradient_paths(
    world: World,
    settings: GradientPathSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[GradientFrame]:
    """Frames of one sample a pixel, without end, independent of each other.

    Pixels and differences are of the same paths.  Arguments as of `path_frames`
    [Kettunen15; Wang25, Eqs. 3 and 4].
    """
    drawing = AreaSettings(shift=settings.shift, temporal=False, spatial=False)
    return path_frames(_frame, world, drawing, bounces, seed, schedule, animation)


def _frame(frame: FrameContext[AreaSettings], last: PathFrame | None) -> GradientFrame:
    camera = frame.world.camera
    pairs = pixel_pairs(camera.width, camera.height)
    paths = in_bands(frame.schedule, frame.pixels, lambda r: area_drawn(frame, r))
    # Eqs. 3 and 4.
    delta = estimate(paired_both(frame, paths, pairs))
    return gradient_frame(frame, paths, pairs, delta)
