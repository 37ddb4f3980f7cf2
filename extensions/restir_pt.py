"""ReSTIR PT: the frame loop of ReSTIR GI, on whole paths."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.frame_loop import PathFrame, path_frames, path_shift
from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.extensions.shifting import PathNeighbor
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.records import cut
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.options.reprojection import reproject
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs, finalize
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.transport.world import World


def render_path_frames(
    world: World,
    settings: PathSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[PathFrame]:
    """Frames of indirect light by ReSTIR PT, without end [Lin22, section 6].

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result

    Returns
    -------
    iterator of PathFrame; each pixel's path begins at what its centre sees
    """
    return path_frames(next_frame, world, settings, bounces, seed, schedule, animation)


def next_frame(frame: FrameContext[PathSettings], last: PathFrame | None) -> PathFrame:
    """One frame: new paths, temporal and spatial reuse, and the picture."""
    kept = reused(frame, last, partial(_drawn, frame))
    color = kept.y.value * kept.W[:, None]
    return PathFrame(frame.number, frame.world, frame.visible, kept, color)


def reused(
    frame: FrameContext[PathSettings],
    last: PathFrame | None,
    drawn: Callable[[slice], Reservoirs],
) -> Reservoirs:
    """Temporal and spatial reuse of whole paths that pixels have ``drawn``."""
    new, rows = drawn, frame.pixels
    if last is not None and frame.settings.temporal:
        new = partial(_temporal, frame, last, _reprojected(frame, last), drawn)
    fresh = in_bands(frame.schedule, rows, new)
    if not frame.settings.spatial:
        return fresh
    # Every pixel's reservoir is complete before a neighbour reads it.
    return in_bands(frame.schedule, rows, partial(_spatial, frame, fresh))


def _drawn(frame: FrameContext[PathSettings], rows: slice) -> Reservoirs:
    shift, number = path_shift(frame), frame.numbers(rows)
    tree = draw_paths(
        frame.world,
        cut(frame.visible.surface, rows),
        frame.bounces,
        shift.criterion,
        number,
        shift.uniforms(number),
    )
    return finalize(tree, tree.M)


def _reprojected(frame: FrameContext[PathSettings], last: PathFrame) -> Indices | None:
    """Row of each pixel in the last frame; ``None`` where all are in their place."""
    if last.world is frame.world:
        return None
    return reproject(
        last.world, last.visible, frame.world, frame.visible, None, frame.settings
    )


def _temporal(
    frame: FrameContext[PathSettings],
    last: PathFrame,
    reprojected: Indices | None,
    drawn: Callable[[slice], Reservoirs],
    rows: slice,
) -> Reservoirs:
    """The history of each pixel first, and what it draws."""
    points, here = cut(frame.visible.surface, rows), np.arange(rows.start, rows.stop)
    new = PathNeighbor(
        shift=path_shift(frame),
        world=frame.world,
        points=points,
        world_from=frame.world,
        points_from=points,
        reservoirs=drawn(rows),
        rows=here - rows.start,
        same_domain=True,
    )
    history = replace(
        new,
        world_from=last.world,
        points_from=last.visible.surface,
        reservoirs=last.reservoirs,
        rows=here if reprojected is None else reprojected[rows],
        same_domain=reprojected is None,
    )
    u = frame.uniforms(Stream.TEMPORAL, rows).draw(0)[0]
    s = frame.settings
    return resample([history, new], [u, u], s.mis, s.temporal_cap)


def _spatial(
    frame: FrameContext[PathSettings], fresh: Reservoirs, rows: slice
) -> Reservoirs:
    """The reservoir of each pixel first, and those of its neighbours."""
    s, here = frame.settings, np.arange(rows.start, rows.stop)
    uniforms = frame.uniforms(Stream.SPATIAL, rows)
    u = [uniforms.draw(k) for k in range(s.neighbors)]
    around = find_neighbors(here, frame.visible, frame.world.camera.width, s, u)
    own = PathNeighbor(
        shift=path_shift(frame),
        world=frame.world,
        points=cut(frame.visible.surface, rows),
        world_from=frame.world,
        points_from=frame.visible.surface,
        reservoirs=fresh,
        rows=here,
        same_domain=True,
    )
    neighbors = [replace(own, rows=row, same_domain=False) for row in around]
    choices = [np.zeros(len(here)), *(u_n[2] for u_n in u)]
    return resample([own, *neighbors], choices, s.mis, s.spatial_cap)
