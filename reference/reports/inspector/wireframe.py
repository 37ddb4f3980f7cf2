"""What the page draws around the rays: camera, and edges of the scene."""

from typing import Any

import numpy as np

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World

MOST_EDGES = 20_000
"""Of a drawing; a finer mesh is shown by its points alone."""


def wireframe(world: World, points: SurfacePoints) -> dict[str, Any]:
    """Where the page looks from, what at, and the edges that it sees.

    Returns ``camera``, with the tangent of half its smaller angle of view; ``middle``
    of what is seen, m; ``edges``, (E, 2, 3) float32, m, or ``None`` of too many.
    """
    camera, seen = world.camera, points.position[points.hit]
    middle = np.median(seen, axis=0).tolist() if len(seen) else list(camera.target)
    return {
        "camera": {
            "position": list(camera.position),
            "up": camera.axes[1].tolist(),
            "tangent": _tangent(camera),
            "mirrored": camera.mirrored,
        },
        "middle": middle,
        "edges": edges(world.geometry),
    }


def edges(geometry: Geometry) -> Any:
    """Edges of triangles, each of them once.

    Parameters
    ----------
    geometry : Geometry; T triangles; spheres have no edges

    Returns
    -------
    (E, 2, 3) float32 or None, m; ``None`` of too many to draw
    """
    a, to_b, to_c = (geometry.triangle[:, k] for k in range(3))
    around = [(a, a + to_b), (a + to_b, a + to_c), (a + to_c, a)]
    ends = np.concatenate([np.stack(edge, axis=1) for edge in around])
    if len(ends) > MOST_EDGES:
        return None
    # Each one the same way round: from the end that comes first by coordinates.
    ends = ends.astype(np.float32)
    order = np.lexsort(ends.transpose(2, 0, 1)[::-1], axis=-1)
    ends = np.take_along_axis(ends, order[:, :, None], axis=1)
    return np.unique(ends, axis=0)


def _tangent(camera: Camera) -> float:
    smaller = min(1.0, camera.height / camera.width)
    return camera.half_width * smaller
