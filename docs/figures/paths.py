"""Scenes of the size of a figure, and their path-traced light."""

from dataclasses import replace

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.moments import add_samples, no_samples
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.transport.path_tracer import Light
from restir_gi.reference.transport.world import World, build_world


def sized_world(name: str, size: int) -> World:
    """Built-in scene with a square picture, validated and ready for rays."""
    scene = find_scene(name)
    camera = replace(scene.camera, width=size, height=size)
    return build_world(validate(replace(scene, camera=camera)))


def path_traced(
    world: World, light: Light, bounces: int, samples: int, work: Work
) -> Vec3s:
    """Path-traced picture that is no part of any truth.

    Returns (N, 3) float64, W/(m² sr); their mean.
    """
    drawn = path_samples(world, work.schedule, light=light, bounces=bounces, seed=0)
    none = no_samples(drawn.rows)
    return add_samples(none, drawn.radiance, samples, work.schedule).mean
