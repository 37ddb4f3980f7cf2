"""Walks that are replayed from other visible points."""

from dataclasses import dataclass

from restir_gi.extensions.shifting import (
    Criterion,
    Leaving,
    Step,
    advance,
    leave,
    start,
)
from restir_gi.reference.numerics.arrays import Indices, Vec3s
from restir_gi.reference.numerics.records import where
from restir_gi.reference.numerics.rng import Uniforms
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True, eq=False)
class ReplayedWalk:
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
) -> ReplayedWalk:
    """Replay walks from visible points.

    Parameters
    ----------
    points : SurfacePoints; N points x_1
    slots : int; V
    """
    steps, leavings = [start(points)], []
    for vertex in range(1, slots + 1):
        step = steps[-1]
        leavings.append(
            leave(world, step, vertex=vertex, uniforms=uniforms, active=step.points.hit)
        )
        steps.append(
            advance(world, criterion, step=step, vertex=vertex, leaving=leavings[-1])
        )
    weights = tuple(step.weight for step in steps[1:])
    return ReplayedWalk(tuple(steps[:-1]), tuple(leavings), weights)


def at_slot(walk: ReplayedWalk, index: Indices) -> SurfacePoints:
    """Each row's point of a slot of its own.

    Parameters
    ----------
    index : (N,) int; v, from 1
    """
    found = walk.steps[0].points
    for v, step in enumerate(walk.steps, start=1):
        found = where(index == v, step.points, found)
    return found
