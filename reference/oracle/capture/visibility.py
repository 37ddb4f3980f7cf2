"""Who sees which sample, traced in the scene where an engine has dumped no bits.

At an edge two right ray tracers differ.  So each segment is traced with its ends moved
a little, too, and rows in which that decides are not looked at.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Vec3s, normalize
from restir_gi.reference.scene.surface import Viewpoints
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import World

LIFT = 1e-4
"""Height from which the surface beneath a visible point is looked for, as a share of
the scene."""

ABOVE = 1e-5
"""Height at which rays begin: rays are in single precision, and so are the points."""

APART = 1e-3
"""By how much the ends of segments are moved, as a share of their length."""

OFF = 0.1
"""Share of visible points from which on the scene is not the one that was captured."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedPoints:
    """Points with normals, N rows; a normal of 0 where there is none.

    Attributes
    ----------
    position, normal : (N, 3) float64
    """

    position: Vec3s
    normal: Vec3s


def traced(
    world: World, viewers: Sequence[PlacedPoints], samples: Sequence[PlacedPoints]
) -> tuple[NDArray[np.uint32], Masks]:
    """Bits of the contract: a column for each viewer, a bit for each sample.

    Raises UsageError: visible points lie on no surface of the scene.

    Returns
    -------
    (N, V) uint32; who sees which
    (N,) bool; whether all that holds with ends that are moved
    """
    rows = len(viewers[0].position)
    words, sure = np.zeros((rows, len(viewers)), np.uint32), np.ones(rows, bool)
    for column, viewer in enumerate(viewers):
        points, there = _on_surfaces(world, viewer)
        for bit, y in enumerate(samples):
            sees, known = _sees(world, points, there, y)
            words[:, column] |= sees.astype(np.uint32) << np.uint32(bit)
            sure &= known
    return words, sure


def _on_surfaces(world: World, x: PlacedPoints) -> tuple[Viewpoints, Masks]:
    """Visible points on the surfaces of the scene, and where there is one.

    Raises UsageError: many lie off them.
    """
    seen: Masks = np.any(x.normal != 0, axis=1)
    up = np.where(seen[:, None], x.normal, [0.0, 0.0, 1.0])
    lift = LIFT * world.geometry.extent
    origin = x.position + lift * up
    hits = world.caster.from_camera(origin, -up)
    there = seen & (hits.distance < 3 * lift)
    if (seen & ~there).sum() > OFF * max(int(seen.sum()), 1):
        raise UsageError(
            f"{int((seen & ~there).sum())} of {int(seen.sum())} visible points lie on"
            " no surface of the scene; name the scene that the frames show, in its"
            " units, or dump visibility"
        )
    distance = np.where(there, hits.distance - ABOVE * world.geometry.extent, 0.0)
    position = np.where(there[:, None], origin - up * distance[:, None], x.position)
    return Viewpoints(position, np.maximum(hits.primitive, 0)), there


def _sees(
    world: World, x: Viewpoints, there: Masks, y: PlacedPoints
) -> tuple[Masks, Masks]:
    """Whether points see others, and whether moved ends say the same."""
    v = y.position - x.position
    apart = APART * np.sqrt((v * v).sum(axis=1))[:, None]
    # Within the surface: moved out of it, an end would be hidden by the surface itself.
    has_normal: Masks = np.any(y.normal != 0, axis=1)
    up = np.where(has_normal[:, None], y.normal, [0.0, 0.0, 1.0])
    side = normalize(np.cross(up, np.roll(up, 1, axis=1) + np.array([0.3, 0.0, 0.0])))
    other = np.cross(up, side)
    answers = [
        world.caster.visible(x, y.position + apart * move, y.normal, there, "reuse")
        for move in (0 * side, side, -side, other, -other)
    ]
    sure: Masks = np.all(answers, axis=0) | ~np.any(answers, axis=0)
    return answers[0], sure
