"""Why a picture is black all over, as far as it can be told."""

import numpy as np

from restir_gi.reference.methods import Job
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.materials.table import can_scatter
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.path_tracer import camera_radiance, first_hits
from restir_gi.reference.transport.world import World, next_world

TRIED = 4
"""Paths a pixel that look for light which the picture leaves out."""


def why_black(job: Job) -> str:
    """Reason for a black picture, and what may help: one line, without a full stop."""
    world, frame = job.world, job.counts.get("frames", 1) - 1
    if job.animation is not None:
        world = next_world(world, job.animation(frame))
    if world.emitters is None:
        return f"nothing emits light in frame {job.frame + frame}"
    camera, table = world.camera, world.materials
    points = first_hits(world, *pixel_centers(camera.width, camera.height))
    if not points.hit.any():
        return "the camera sees no surface: it looks away from the scene or past it"
    if job.light != "full" and _finds_light(world, job, points):
        if job.light == "indirect":
            return (
                "nothing scatters light a second time, and --light indirect shows no"
                " other; try --light full"
            )
        return (
            f"--light {job.light} leaves out all the light there is; try --light full"
        )
    shows = points.front | table.two_sided[points.material]
    if not (can_scatter(table, points) & shows).any():
        return (
            "all that the camera sees is black, as are the backs of one-sided"
            " materials: it may be inside a shape or behind it"
        )
    return (
        "no light was found on what the camera sees: it may be inside a shape, or the"
        " lights shine elsewhere"
    )


def _finds_light(world: World, job: Job, points: SurfacePoints) -> bool:
    """Whether a few paths a pixel find light of any kind."""
    pixel = np.arange(len(points), dtype=np.uint32)
    for sample in range(TRIED):
        uniforms = KeyedUniforms(pixel, sample, job.seed, Stream.PATH)
        if camera_radiance(world, points, "full", job.bounces, uniforms).any():
            return True
    return False
