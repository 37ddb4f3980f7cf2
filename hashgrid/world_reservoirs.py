"""Light reservoirs at every vertex of eye paths, reused through a grid in the world.

[Boisse21]: each vertex draws points on lights, keeps one of them by its light, shadows
left out, and takes over what vertices near it kept in the frame before; one ray looks
whether the light is seen.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from extensions.frame_loop import frames
from hashgrid.cache import Cache, fill
from hashgrid.keys import lattice_of
from hashgrid.light_donor import lent
from hashgrid.light_settings import LightSettings
from hashgrid.light_vertex import Vertex, Visit, Walk
from hashgrid.lights import lends
from hashgrid.vertex_numbers import of_vertices
from reference.arrays import Indices, Vec3s, zero_vectors
from reference.records import concatenate, cut, keep
from reference.rng import Stream, Uniforms
from reference.scene.animation import Animation
from reference.scene.surface import VisiblePoints
from reference.schedule import Schedule, in_bands
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class LightFrame:
    """What one frame leaves for the next, and the picture.

    Attributes
    ----------
    number : int; from 0
    world : World; the scene as it was
    visible : VisiblePoints; G-buffer, through the centres of the pixels
    pixel, vertex : (V,) int64
        Whose path each vertex of the cache is of, and its number on it.
    cache : Cache
        Vertices x_2 of all pixels, then x_3, ...; before them x_1, if they are kept.
    color : (N, 3) float64, W/(m² sr); indirect light
    """

    number: int
    world: World
    visible: VisiblePoints
    pixel: Indices
    vertex: Indices
    cache: Cache
    color: Vec3s


def render_light_frames(
    world: World,
    settings: LightSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[LightFrame]:
    """Frames of indirect light by light reservoirs in world space, without end.

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    animation : Animation, optional
        Validated scenes of all frames; by default the scene stands still.  Camera,
        shapes and lights may move.

    Returns
    -------
    iterator of LightFrame
        Frame after frame, each looking into the cells of the last one.
    """

    def frame(
        number: int, now: World, visible: VisiblePoints, last: LightFrame | None
    ) -> LightFrame:
        past = lent(last.cache, now) if last else None
        vertices = [
            Vertex(now, settings, number, seed, v, v == bounces + 1, past)
            for v in range(1, bounces + 2)
        ]
        return _frame(vertices, visible, schedule)

    return frames(frame, world, schedule, animation)


def _frame(
    vertices: list[Vertex], visible: VisiblePoints, schedule: Schedule
) -> LightFrame:
    pixels = len(visible.depth)
    walk = Walk(np.arange(pixels), visible.surface, 1.0 + zero_vectors(pixels))
    color, visited = zero_vectors(pixels), []
    for vertex in vertices:
        # Where nothing was hit, nothing is drawn; an empty walk is still a walk.
        walk = keep(walk, walk.points.hit)
        visit = in_bands(schedule, len(walk.pixel), _of(vertex, walk))
        color[walk.pixel] += visit.light
        if visit.reservoirs is not None:
            visited.append((vertex.number, walk, visit.reservoirs))
        walk = visit.onward
    first = vertices[0]
    walks = concatenate([walk for _, walk, _ in visited])
    number = concatenate([np.full(len(w.pixel), v) for v, w, _ in visited])
    cache = fill(
        first.world,
        lattice_of(first.world.camera, first.settings.facings),
        walks.points,
        concatenate([reservoirs for _, _, reservoirs in visited]),
        # Nobody is put in where nobody asks.
        lends(first.world, walks.points) & (first.settings.cells > 0),
        _insertions(first, walks.pixel, number),
    )
    return LightFrame(
        first.frame, first.world, visible, walks.pixel, number, cache, color
    )


def _insertions(first: Vertex, pixel: Indices, number: Indices) -> Uniforms:
    """Numbers of all vertices."""
    return of_vertices(pixel, first.frame, number, first.seed, Stream.CELLS)


def _of(vertex: Vertex, walk: Walk) -> Callable[[slice], Visit]:
    return lambda rows: vertex.visit(cut(walk, rows))
