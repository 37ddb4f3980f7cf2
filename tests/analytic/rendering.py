"""Pictures of scenes, made the shortest way: what the tests of this folder look at."""

from dataclasses import replace
from itertools import islice

import numpy as np

from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.path_tracer import camera_radiance, first_hits
from restir_gi.reference.transport.world import build_world

ONE_BAND = Schedule(band=1 << 20)


def sized(scene, width, height=None):
    """The scene with an image of another size."""
    camera = replace(scene.camera, width=width, height=height or width)
    return replace(scene, camera=camera)


def world_of(scene, width, height=None):
    """The scene made ready for rays, with an image of another size."""
    return build_world(sized(scene, width, height))


def what_is_seen(world):
    """First hits through all pixel centres."""
    return first_hits(world, *pixel_centers(world.camera.width, world.camera.height))


def path_traced(world, light="indirect", bounces=1, samples=1, seed=0, points=None):
    """Mean of some path-traced samples a pixel, (N, 3)."""
    points = what_is_seen(world) if points is None else points
    pixel = np.arange(len(points), dtype=np.uint32)
    total = np.zeros((len(points), 3))
    for sample in range(samples):
        u = KeyedUniforms(pixel, sample, seed, Stream.PATH)
        total += camera_radiance(world, points, light, bounces, u)
    return total / samples


def frames_of(world, count, bounces=1, seed=0, schedule=ONE_BAND, **settings):
    """The first frames of ReSTIR GI."""
    frames = render_frames(world, Settings(**settings), bounces, seed, schedule)
    return list(islice(frames, count))


def moved(scene, matrix):
    """The scene under a similarity: turned, scaled and moved, its eye and suns too.

    Radiance and irradiance stay; a lamp shines with the square of the scale.
    """
    matrix = np.asarray(matrix, float)
    scale = np.linalg.norm(matrix[:3, 0])  # exact for powers of two

    def point(x):
        return tuple(matrix[:3, :3] @ np.array(x, float) + matrix[:3, 3])

    def direction(d):
        return tuple(matrix[:3, :3] @ np.array(d, float) / scale)

    def lamp(light):
        intensity = tuple(scale**2 * np.array(light.intensity))
        return replace(light, position=point(light.position), intensity=intensity)

    camera = scene.camera
    return replace(
        scene,
        camera=replace(
            camera,
            position=point(camera.position),
            target=point(camera.target),
            up=direction(camera.up),
        ),
        meshes=tuple(replace(m, pose=matrix @ m.pose) for m in scene.meshes),
        spheres=tuple(
            replace(s, center=point(s.center), radius=float(scale * s.radius))
            for s in scene.spheres
        ),
        points=tuple(lamp(p) for p in scene.points),
        spots=tuple(
            replace(lamp(s), direction=direction(s.direction)) for s in scene.spots
        ),
        suns=tuple(replace(s, direction=direction(s.direction)) for s in scene.suns),
    )
