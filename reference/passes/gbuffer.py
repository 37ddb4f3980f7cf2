"""G-buffer: the visible point of each pixel."""

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, dot
from restir_gi.reference.scene.camera import view_depth
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.transport.path_tracer import first_hits
from restir_gi.reference.transport.world import World


def visible_points(world: World, x: Scalars, y: Scalars) -> VisiblePoints:
    """What the camera sees through points of the image.

    Parameters
    ----------
    x, y : (N,) float64, pixels; points of the image

    Returns
    -------
    VisiblePoints; N rows; depth 0 where the ray left the scene
    """
    surface = first_hits(world, x, y)
    depth = view_depth(world.camera, surface.position)
    return VisiblePoints(surface, np.where(surface.hit, depth, 0.0))


def similar(
    n_a: Vec3s,
    depth_a: Scalars,
    n_b: Vec3s,
    depth_b: Scalars,
    max_angle: float,
    max_depth: float,
) -> Masks:
    """Whether visible points are alike enough to share samples.

    [Ouyang21, section 4.2]: 25 degrees and 0.05.

    Parameters
    ----------
    n_a, n_b : (N, 3) float64; unit shading normals
    depth_a, depth_b : (N,) float64, m; view depths, 0 where nothing is seen
    max_angle : float, degrees; between the normals, inclusive
    max_depth : float; relative difference |a - b| / max(a, b), inclusive

    Returns
    -------
    (N,) bool; symmetric in a and b; false where either saw nothing
    """
    alike = dot(n_a, n_b) >= np.cos(np.radians(max_angle))
    near, far = np.minimum(depth_a, depth_b), np.maximum(depth_a, depth_b)
    similar_rows: Masks = alike & (near > 0) & (far - near <= max_depth * far)
    return similar_rows
