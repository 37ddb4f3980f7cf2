"""Gradient after ReSTIR: paths that Area ReSTIR has kept, shifted to neighbours."""

from collections.abc import Iterable, Iterator

from restir_gi.extensions.area_restir import area_drawn, area_reused
from restir_gi.extensions.frame_loop import PathFrame, path_frames
from restir_gi.gradient_domain.gradient_restir import (
    GradientFrame,
    PairValue,
    difference,
    gradient_frame,
    paired_both,
    share_of_base,
)
from restir_gi.gradient_domain.pairs import pixel_pairs
from restir_gi.gradient_domain.settings import AfterSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.transport.world import World


def render_after_frames(
    world: World,
    settings: AfterSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[GradientFrame]:
    """Frames of Area ReSTIR, and differences estimated from their paths, without end.

    Reuse knows nothing of differences.  Arguments as of `path_frames` [Wang25,
    section 4.1].
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(frame: FrameContext[AfterSettings], last: PathFrame | None) -> GradientFrame:
    camera = frame.world.camera
    pairs = pixel_pairs(camera.width, camera.height)
    # Eq. 10.
    kept = area_reused(frame, last, lambda r: area_drawn(frame, r))
    both = paired_both(frame, kept, pairs)
    return gradient_frame(frame, kept, pairs, estimate_after(both))


def estimate_after(both: Iterable[Reservoirs]) -> Vec3s:
    """Differences of pairs, by the resampled paths of their pixels, (P, 3).

    [Wang25, Eq. 12].

    Parameters
    ----------
    both : two Reservoirs; those of k = 0, and of k = 1
    """
    # Eq. 12; G has the sign of the difference for k = 1, too.
    i, j = (one_sided(r.y.value) * r.W[:, None] for r in both)
    found: Vec3s = i + j
    return found


def one_sided(value: PairValue) -> Vec3s:
    """What N resampled paths say of differences, times their weights W: ω̂ G, (N, 3).

    Densities after resampling are not known, and targets stand for them [Wang25,
    Eqs. 11 to 13].
    """
    p_base, p_offset = luminance(value.base.value), luminance(value.offset)
    share = share_of_base(p_base, p_offset, value.inner)
    found: Vec3s = difference(value) * share[:, None]
    return found
