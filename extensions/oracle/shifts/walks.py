"""Walks that are replayed from other visible points."""

from dataclasses import dataclass

from extensions.connection import Criterion
from extensions.walking import Leaving, Step, arrive, leave, start
from reference.arrays import Indices, Vec3s
from reference.records import where
from reference.rng import Uniforms
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """Replayed walks of N paths.

    Attributes
    ----------
    steps : tuple of Step; x_1 to x_V
    leavings : tuple of Leaving; how each is left
    weights : tuple of (N, 3) float64; f cos / p of that
    """

    steps: tuple[Step, ...]
    leavings: tuple[Leaving, ...]
    weights: tuple[Vec3s, ...]


def walked(
    world: World,
    criterion: Criterion,
    points: SurfacePoints,
    uniforms: Uniforms,
    slots: int,
) -> Walk:
    """Replay walks from visible points.

    Parameters
    ----------
    points : SurfacePoints; N points x_1
    slots : int; V
    """
    steps, leavings = [start(points)], []
    for vertex in range(1, slots + 1):
        step = steps[-1]
        leavings.append(leave(world, step, vertex, uniforms, step.points.hit))
        steps.append(arrive(world, criterion, step, vertex, leavings[-1]))
    weights = tuple(step.weight for step in steps[1:])
    return Walk(tuple(steps[:-1]), tuple(leavings), weights)


def at_slot(walk: Walk, index: Indices) -> SurfacePoints:
    """Each row's point of a slot of its own.

    Parameters
    ----------
    index : (N,) int; v, from 1
    """
    found = walk.steps[0].points
    for v, step in enumerate(walk.steps, start=1):
        found = where(index == v, step.points, found)
    return found
