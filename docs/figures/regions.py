"""Pixels by where their visible points lie."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from restir_gi.reference.methods.aovs import gbuffer_layers
from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.transport.world import World

FLOOR = 1e-3  # height, m, below which a point that faces up lies on the floor


def floor_points(world: World, work: Work) -> tuple[Vec3s, Vec3s, Masks]:
    """What the camera sees, and whether it is the floor y = 0.

    Returns
    -------
    position, normal : (N, 3) float64, m and 1
        Of the visible points; 0 where nothing is seen.
    floor : (N,) bool; on the floor
    """
    layers = gbuffer_layers(world, work.schedule, ("position", "normal"))
    position, normal = layers["position"], layers["normal"]
    return position, normal, (normal[:, 1] > 0.5) & (position[:, 1] < FLOOR)


def zones(
    distance: Scalars, among: Masks, edges: Sequence[float]
) -> dict[tuple[float, float], Masks]:
    """Pixels from one distance to the next.

    Parameters
    ----------
    distance : (N,) float64, m; of each pixel, from whatever it is
    among : (N,) bool; which pixels may count
    edges : sequence of float, m

    Returns
    -------
    dict of (float, float) to (N,) bool
        By the ends of each zone, of which the lower one belongs to it; without those
        that no pixel lies in.
    """
    found = {
        (low, high): among & (distance >= low) & (distance < high)
        for low, high in pairwise(edges)
    }
    return {ends: mask for ends, mask in found.items() if np.any(mask)}
