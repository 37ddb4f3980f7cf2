"""Gradient after ReSTIR: paths that Area ReSTIR has kept, shifted to neighbours."""

from collections.abc import Iterator

from extensions.area_restir import area_drawn, area_reused
from extensions.frame_loop import Moment, PathFrame, path_frames
from gradient_domain.candidates import paired
from gradient_domain.frame import GradientFrame, gradient_frame, inner_shift
from gradient_domain.paired_domain import (
    WHOLE,
    PairValue,
    difference,
    share_of_base,
)
from gradient_domain.pairs import pixel_pairs
from gradient_domain.settings import AfterSettings
from reference.arrays import Vec3s
from reference.records import cut
from reference.resampling.target import luminance
from reference.scene.animation import Animation
from reference.schedule import Schedule, in_bands
from reference.world import World


def render_after_frames(
    world: World,
    settings: AfterSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[GradientFrame]:
    """Frames of Area ReSTIR, and differences estimated from their paths, without end.

    [Wang25, section 4.1].

    Reuse knows nothing of differences.

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(moment: Moment, last: PathFrame | None, schedule: Schedule) -> GradientFrame:
    camera, inner = moment.world.camera, inner_shift(moment, moment.world)
    pairs = pixel_pairs(camera.width, camera.height)
    kept = area_reused(moment, last, lambda r: area_drawn(moment, r), schedule)

    def delta(rows: slice) -> Vec3s:
        some = cut(pairs, rows)
        both = [paired(inner, kept, some, k, WHOLE) for k in (0, 1)]
        terms = [one_sided(r.y.value) * r.W[:, None] for r in both]
        total: Vec3s = terms[0] + terms[1]
        return total

    return gradient_frame(moment, kept, pairs, in_bands(schedule, len(pairs), delta))


def one_sided(value: PairValue) -> Vec3s:
    """What a resampled path says of a difference, times its weight W.

    [Wang25, Eqs. 11 to 13].

    Returns
    -------
    (N, 3); ω̂ G; densities after resampling are not known, and targets stand for them
    """
    p_base, p_offset = luminance(value.base.value), luminance(value.offset)
    share = share_of_base(p_base, p_offset, value.inner)
    found: Vec3s = difference(value) * share[:, None]
    return found
