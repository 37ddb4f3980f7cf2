"""Scenes whose paths need every kind of shift, small."""

from dataclasses import replace
from functools import cache

import numpy as np

from extensions.candidates import draw_paths
from extensions.connection import CRITERIA
from extensions.shifting import Shift
from reference.passes.gbuffer import visible_points
from reference.records import scatter, take
from reference.rng import KeyedUniforms, Stream
from reference.scene.camera import pixel_centers
from reference.scene.catalogue.registry import find_scene
from reference.scene.materials.kinds import Coated, Conductor, Dielectric, mirror
from reference.scene.validation import validate
from reference.world import build_world

FLOORS = {
    "paint": None,
    "rough metal": Conductor((0.9, 0.8, 0.6), alpha=0.3),
    "glossy metal": Conductor((0.9, 0.8, 0.6), alpha=0.02),
    "mirror": mirror((0.9, 0.9, 0.9)),
    "rough coat": Coated((0.5, 0.3, 0.2), alpha=0.3),
    "smooth coat": Coated((0.5, 0.3, 0.2), alpha=0.0),
    "glass": Dielectric(1.5),
}
"""Materials of the blocks of a Cornell box."""

SIZE = 32


@cache
def world(name, size=SIZE):
    """A scene of the catalogue, or the Cornell box with other blocks."""
    found = find_scene("cornell-box" if name in FLOORS else name)
    camera = replace(found.camera, width=size, height=size)
    meshes = found.meshes
    if FLOORS.get(name) is not None:
        meshes = tuple(
            replace(mesh, material=FLOORS[name]) if "block" in mesh.name else mesh
            for mesh in meshes
        )
    return build_world(validate(replace(found, camera=camera, meshes=meshes)))


def points(w):
    """What its pixels see."""
    camera = w.camera
    return visible_points(w, *pixel_centers(camera.width, camera.height)).surface


def uniforms(pixels, seed=7):
    """Random numbers of paths by their numbers."""

    def of(number):
        pixel = (number % pixels).astype(np.uint32)
        return KeyedUniforms(pixel, number // pixels, seed, Stream.PATH)

    return of


def shifted(shift, w, x, paths, rows):
    """Paths at other points, and the Jacobian, for some of the rows; 0 elsewhere."""
    at = np.flatnonzero(rows & x.hit)
    value, jacobian = shift(w, take(x, at), take(paths, at))
    size = len(paths)
    jacobian = scatter(at, jacobian, size)
    return paths.moved(scatter(at, value, size), jacobian), jacobian


def drawn(name, kind, frame=0, bounces=4, size=SIZE):
    """World, visible points, candidates and shift of one frame."""
    w = world(name, size)
    x, pixels = points(w), size * size
    number = np.arange(pixels) + frame * pixels
    of = uniforms(pixels)
    criterion = CRITERIA[kind]
    found = draw_paths(w, x, bounces, criterion, number, of(number))
    return w, x, found, Shift(criterion, of)
