"""Gradient-domain path tracing: paths of both pixels of a pair, each shifted once."""

from collections.abc import Iterator

from extensions.area_restir import area_drawn
from extensions.area_settings import AreaSettings
from extensions.frame_loop import Moment, PathFrame, path_frames
from gradient_domain.candidates import paired
from gradient_domain.frame import (
    GradientFrame,
    estimate,
    gradient_frame,
    inner_shift,
)
from gradient_domain.paired_domain import WHOLE
from gradient_domain.pairs import pixel_pairs
from gradient_domain.settings import GradientPathSettings
from reference.arrays import Vec3s
from reference.records import cut
from reference.scene.animation import Animation
from reference.schedule import Schedule, in_bands
from reference.world import World


def render_gradient_paths(
    world: World,
    settings: GradientPathSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[GradientFrame]:
    """Frames of one sample a pixel, without end, independent of each other.

    [Kettunen15], and [Wang25, Eqs. 3 and 4].

    Pixels and differences are of the same paths.

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    """
    drawing = AreaSettings(shift=settings.shift, temporal=False, spatial=False)
    return path_frames(_frame, world, drawing, bounces, seed, schedule, animation)


def _frame(moment: Moment, last: PathFrame | None, schedule: Schedule) -> GradientFrame:
    camera, inner = moment.world.camera, inner_shift(moment, moment.world)
    pairs = pixel_pairs(camera.width, camera.height)
    drawn = in_bands(schedule, moment.pixels, lambda r: area_drawn(moment, r))

    def delta(rows: slice) -> Vec3s:
        some = cut(pairs, rows)
        return estimate([paired(inner, drawn, some, k, WHOLE) for k in (0, 1)])

    return gradient_frame(moment, drawn, pairs, in_bands(schedule, len(pairs), delta))
